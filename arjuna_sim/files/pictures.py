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
from arjuna_sim.model.geometry.shapes import Kind, Look, Mesh, Part, Picture, Shape, Skin
from arjuna_sim.model.look import PIXELS_MAX
from arjuna_sim.model.notes import NoteKind

_KINDS = ("PNG", "JPEG", "TIFF", "BMP")
_SIDE_MIN = 512  # smaller ones are drawn from as large a copy, for sharp edges [pixels]
CUT = "#~"
"""Stands before the number of a part of a mesh that has one material, after its file's name."""
_MAPS = tuple(f"material/pbr/{flow}/albedo_map" for flow in ("metal", "specular"))


def dressed(xml: XmlFile, part: Part, visual: Element, label: str) -> list[Part]:
    """Return a part as it looks: with its picture, or as a part for each material of a mesh.

    Boxes, planes and meshes have pictures, others a picture's mean colour.

    Args:
        visual: Its `<visual>`, of SDF or URDF; what is no visual has no look.
    """
    if visual.tag != "visual":
        return [part]
    material = visual.find("material")
    texture = visual.find("material/texture")
    uri = next((text.strip() for path in _MAPS if (text := visual.findtext(path))), "")
    uri = uri or ("" if texture is None else texture.get("filename", ""))
    mesh = part.shape.mesh
    if not uri and material is None and mesh is not None and mesh.skin is not None:
        looks = np.unique(mesh.skin.of).tolist()
        return [_skinned(xml, part, mesh, look, f"{CUT}{i}", label) for i, look in enumerate(looks)]
    found = xml.find(uri, label) if uri else next(_of_script(xml, visual), None)
    picture = _picture(xml, found, uri, label)
    if picture is not None and part.shape.kind is Kind.PLANE:
        part = _sheet(xml, part, visual, label)
    return [part if picture is None else _with(xml, part, picture, label)]


def _picture(xml: XmlFile, path: Path | None, uri: str, label: str) -> Picture | None:
    """Return the picture of a file; None (and a note) where it is missing or broken."""
    try:
        if path is not None:
            return _read(path, path.stat().st_mtime_ns)
    except InputFileError as error:
        problem = f"its picture {error.problem}, so it is not drawn"
        xml.note(f"{label}: {problem}", NoteKind.BROKEN, "visual")
        return None
    if uri:
        problem = f"picture '{uri}' does not exist, so it is not drawn"
        xml.note(f"{label}: {problem}", NoteKind.MISSING, "visual")
    return None


def _with(xml: XmlFile, part: Part, picture: Picture, label: str) -> Part:
    """Return a part with a picture, or with its mean colour where it has no place for one."""
    skin = None if part.shape.mesh is None else part.shape.mesh.skin
    if part.shape.kind is Kind.BOX or (skin is not None and np.isfinite(skin.places).all()):
        return dataclasses.replace(part, picture=picture)
    r, g, b = (float(value) / 255.0 for value in picture.pixels.mean(axis=(0, 1)))
    xml.note(f"{label}: of the picture '{picture.path.name}' the mean colour is drawn")
    return dataclasses.replace(part, rgba=(r, g, b, part.rgba[3]))


def _skinned(xml: XmlFile, part: Part, mesh: Mesh, number: int, suffix: str, label: str) -> Part:
    """Return the part of a mesh that has one of its materials."""
    assert mesh.skin is not None
    skin, own = mesh.skin, mesh.skin.of == number
    (rgba, name), path = skin.looks[number], mesh.path
    if len(skin.looks) > 1:
        path = path.with_name(path.name + suffix)
        cut = Mesh(path, mesh.triangles[own], Skin(skin.places[own], skin.of[own], skin.looks))
        mesh = xml.meshes.setdefault(path, cut)
    colour = part.rgba if rgba is None else (*rgba[:3], (*rgba, 1.0)[3] or 1.0)
    part = dataclasses.replace(
        part, shape=dataclasses.replace(part.shape, mesh=mesh), rgba=tuple(colour)
    )
    picture = _picture(xml, _beside(path, name), name, label) if name else None
    return part if picture is None else _with(xml, part, picture, label)


def _beside(mesh: Path, name: str) -> Path | None:
    """Return the picture that a mesh names: beside it, or where its model has pictures."""
    folder, plain = mesh.parent, Path(name.replace("\\", "/"))
    places = (
        folder / plain,
        folder / plain.name,
        folder.parent / "materials/textures" / plain.name,
    )
    found = (place.resolve() for place in places if place.is_file())
    return next((place for place in found if place.is_relative_to(folder.parent)), None)


def _sheet(xml: XmlFile, part: Part, visual: Element, label: str) -> Part:
    """Return a plane as large as its file says, for it has a picture on all of it."""
    text = visual.findtext("geometry/plane/size") or "1 1"
    x, y = (size / 2 for size in xml.sizes(text, 2, f"{label} <size>"))
    corners = np.array([[-x, -y, 0.0], [x, -y, 0.0], [x, y, 0.0], [-x, y, 0.0]])
    places, faces = np.array([[0, 1], [1, 1], [1, 0], [0, 0]], np.float32), [[0, 1, 2], [0, 2, 3]]
    path = Path(f"{xml.path}#plane-{x:g}-{y:g}")
    skin = Skin(places[faces], np.zeros(2, np.int32), (Look(None, ""),))
    mesh = xml.meshes.setdefault(path, Mesh(path, corners[faces], skin))
    return dataclasses.replace(part, shape=Shape(Kind.MESH, (1.0, 1.0, 1.0), mesh))


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
                rf"^[ \t]*material\s+{name}\b(.*?)(?=^[ \t]*material\s|\Z)", text, re.M | re.S
            )
            texture = block and re.search(r"^[ \t]*texture\s+([\w.-]+)", block[1], re.M)
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
            if max(image.size) > PIXELS_MAX:
                problem = f"has {max(image.size)} pixels a side; valid: up to {PIXELS_MAX}"
                raise InputFileError(path, problem)
            pixels = np.asarray(image.convert("RGB"))
    except (OSError, ValueError, SyntaxError, Image.DecompressionBombError) as error:
        raise InputFileError(path, f"cannot be read: {error}") from error
    times = -(-_SIDE_MIN // max(pixels.shape[:2]))
    return Picture(path, pixels.repeat(times, axis=0).repeat(times, axis=1))
