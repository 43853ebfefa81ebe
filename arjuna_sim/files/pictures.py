"""Pictures on shapes: what materials of SDF, of Ogre's scripts and of URDF name."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path
from xml.etree.ElementTree import Element  # types only; parsing is defusedxml's

import numpy as np
from PIL import Image

from arjuna_core.errors import InputFileError
from arjuna_core.files.input_file import open_file, read_text
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.geometry.shapes import Kind, Part, Picture
from arjuna_sim.model.notes import NoteKind

_KINDS = ("PNG", "JPEG", "TIFF", "BMP")
_SIDE_MAX = 4096  # as far as OpenGL goes everywhere [pixels]
_SIDE_MIN = 512  # smaller ones are drawn from as large a copy, for sharp edges [pixels]
_MAPS = tuple(f"material/pbr/{flow}/albedo_map" for flow in ("metal", "specular"))


def with_picture(xml: XmlFile, part: Part, visual: Element, label: str) -> Part:
    """Return a part with its picture where it is a box; others get the picture's mean colour.

    Args:
        visual: Its `<visual>`, of SDF or URDF; what is no visual has no picture.
    """
    if visual.tag != "visual":
        return part
    texture = visual.find("material/texture")
    uri = next((text.strip() for path in _MAPS if (text := visual.findtext(path))), "")
    uri = uri or ("" if texture is None else texture.get("filename", ""))
    try:
        path = xml.find(uri, label) if uri else next(_of_script(xml, visual), None)
        picture = None if path is None else _read(path, path.stat().st_mtime_ns)
    except InputFileError as error:
        xml.note(f"{label}: its picture {error.problem}, so it is not drawn", NoteKind.BROKEN)
        return part
    if picture is None:
        if uri:
            problem = f"picture '{uri}' does not exist, so it is not drawn"
            xml.note(f"{label}: {problem}", NoteKind.MISSING)
        return part
    if part.shape.kind is Kind.BOX:
        return dataclasses.replace(part, picture=picture)
    r, g, b = (float(value) / 255.0 for value in picture.pixels.mean(axis=(0, 1)))
    name = picture.path.name
    xml.note(f"{label}: of the picture '{name}' the mean colour is drawn, for it is on no box")
    return dataclasses.replace(part, rgba=(r, g, b, part.rgba[3]))


def _of_script(xml: XmlFile, visual: Element) -> Iterator[Path]:
    """Yield the files that may be the picture of a material of Ogre's scripts."""
    name = re.escape((visual.findtext("material/script/name") or "").strip())
    folders = [
        folder for uri in visual.iterfind("material/script/uri") for folder in _folder(xml, uri)
    ]
    for folder in folders if name else ():
        for script in sorted(folder.glob("*.material")):
            text = read_text(script, error=InputFileError)
            block = re.search(
                rf"^\s*material\s+{name}\b(.*?)(?=^\s*material\s|\Z)", text, re.M | re.S
            )
            texture = block and re.search(r"^\s*texture\s+([\w.-]+)", block[1], re.M)
            for beside in (*folders, folder.parent / "textures") if texture else ():
                if texture and (beside / texture[1]).is_file():
                    yield beside / texture[1]


def _folder(xml: XmlFile, uri: Element) -> Iterator[Path]:
    """Yield the folder that a URI of scripts or textures names, or that of the script it names."""
    _, _, rest = (uri.text or "").strip().rpartition("model://")
    name, _, inside = rest.partition("/")
    root = xml.search.package(xml.path, name)
    if root is None:
        return
    paths = (path for path in (root / inside, (root / inside).parent) if path.is_dir())
    yield from [path for path in paths if path.resolve().is_relative_to(root.resolve())][:1]


@lru_cache(maxsize=64)
def _read(path: Path, changed: int) -> Picture:
    """Return a file's picture; a wall's hundred parts have the same one."""
    try:
        with (
            open_file(path, InputFileError, 1 << 27) as file,
            Image.open(file, formats=_KINDS) as image,
        ):
            if max(image.size) > _SIDE_MAX:
                problem = f"has {max(image.size)} pixels a side; valid: up to {_SIDE_MAX}"
                raise InputFileError(path, problem)
            pixels = np.asarray(image.convert("RGB"))
    except (OSError, ValueError, SyntaxError, Image.DecompressionBombError) as error:
        raise InputFileError(path, f"cannot be read: {error}") from error
    times = -(-_SIDE_MIN // max(pixels.shape[:2]))
    return Picture(path, pixels.repeat(times, axis=0).repeat(times, axis=1))
