"""Meshes that robots and worlds refer to: STL, OBJ and COLLADA, read by trimesh."""

from __future__ import annotations

import io
import itertools
import json
import re
import struct
from functools import cache
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import (  # parsing is defusedxml's
    Element,
    SubElement,
    register_namespace,
    tostring,
)

import numpy as np
from PIL import Image
from PIL.PngImagePlugin import PngInfo

from arjuna_core.arrays import Bytes, Floats, Singles
from arjuna_core.errors import InputFileError
from arjuna_core.files.array_cache import Arrays, cached, made_by
from arjuna_core.files.input_file import MESH_BYTES_MAX, read_bytes
from arjuna_core.files.xml_text import parse_xml
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.geometry.convex_pieces import surface
from arjuna_sim.model.geometry.shapes import Kind, Look, Mesh, Shape, Skin
from arjuna_sim.model.notes import NoteKind

MESH_SUFFIXES = (".dae", ".obj", ".stl")
# Bounds on hostile files, beside that of their size.
_TEXT_MAX = 20_000_000  # bytes of text, in lines:
_LINES_MAX = 600_000
_FACES_MAX = 1_000_000
_PLACED_MAX = 10_000  # geometries that COLLADA's nodes place
_NAME = "picture"  # what a picture's name is called within a dot that stands for it
_STL_HEADER, _STL_FACE = 84, 50  # bytes of binary STL
_REACH_MAX = 1e5  # [m]
_OPTIONS = {"package": "--package-path", "model": "--model-path"}
_BROKEN = (
    *(ValueError, LookupError, AttributeError, TypeError, OverflowError, struct.error),
    *(RuntimeError, SyntaxError),  # a bare raise of pycollada's, and lxml's
)
"""What readers raise where a file is broken."""


class MeshError(InputFileError):
    """A mesh cannot be read."""


def mesh_shape(
    xml: XmlFile, uri: str, scale: str, label: str, part: str = "", centred: bool = False
) -> Shape | None:
    """Read a mesh; None (and a note) where it is missing, of a foreign form, or broken and drawn.

    Args:
        label: Name of the element in messages; of a visual it ends in `visual`.
        part: Name of the part of it that is meant; "" for all of it.
        centred: Whether that part is put about its own middle.

    Raises:
        InputFileError: A mesh that collides is broken, or the scale is no scale.
    """
    size = xml.numbers(scale, 3, f"{label} scale")
    if 0.0 in size:
        raise xml.fail(f"{label} scale", f"{scale!r} must not be zero")
    path, of = xml.find(uri, label), "visual" if label.endswith("visual") else "collision"
    if path is None:
        option = _OPTIONS.get(uri.partition("://")[0])
        rest = "" if option is None else f"; {option} DIR finds it below DIR"
        problem = f"mesh '{uri}' does not exist, so it is left out{rest}"
        xml.note(f"{label}: {problem}", NoteKind.MISSING, of)
        return None
    if path.suffix.lower() not in MESH_SUFFIXES:
        xml.note(
            f"{label}: mesh '{uri}' left out; simulated are {', '.join(MESH_SUFFIXES)}",
            NoteKind.UNSUPPORTED,
            of,
        )
        return None
    try:
        mesh = _mesh(xml, path, part, centred, f"{label}: mesh '{uri}'")
    except MeshError as error:
        if of == "collision":
            raise xml.fail(label, f"mesh '{uri}' {error.problem}") from error
        xml.note(f"{label}: mesh '{uri}' {error.problem}, so it is not drawn", NoteKind.BROKEN, of)
        return None
    reach = mesh.reach * max(map(abs, size))
    if not reach <= _REACH_MAX:
        raise xml.fail(label, f"mesh '{uri}' is {reach:.3g} m large; valid: up to {_REACH_MAX:g}")
    if not surface(mesh.triangles * size) > 1e-9:
        problem = f"mesh '{uri}' has no surface, so it is left out"
        xml.note(f"{label}: {problem}", NoteKind.BROKEN, of)
        return None
    return Shape(Kind.MESH, size, mesh)


def _mesh(xml: XmlFile, path: Path, part: str, centred: bool, label: str) -> Mesh:
    key = path.with_name(f"{path.name}#{part}{'~' * centred}") if part else path
    if key in xml.meshes:
        return xml.meshes[key]
    triangles, skin = read_skinned(path, part)
    if part and not len(triangles):
        xml.note(f"{label} has no part '{part}': all of it is taken")
        triangles, skin = read_skinned(path)
    if centred:
        points = triangles.reshape(-1, 3)
        triangles = triangles - (points.min(axis=0) + points.max(axis=0)) / 2
    resolved = path.resolve()
    called = resolved.with_name(key.name) if part else resolved
    xml.meshes[key] = Mesh(called, triangles, skin)
    return xml.meshes[key]


def read_skinned(path: Path, part: str = "") -> tuple[Floats, Skin]:
    """Return a mesh's triangles, and how each looks.

    Args:
        path: A `.stl` (binary or text), `.obj` or `.dae` file.
        part: Name of an object, group, node or geometry in it; "" for all of it. Without such a
            part there are no triangles.

    Returns:
        Corners `(N, 3, 3) float64`, in the file's units; COLLADA in metres. Its `<up_axis>` is left
        out, as Gazebo leaves it out: its worlds are made for that.

    Raises:
        MeshError: The file is unreadable, broken, empty, too large or not finite.
    """
    suffix = path.suffix.lower()
    if suffix not in MESH_SUFFIXES:
        raise MeshError(path, f"has the form '{suffix}'; valid: {', '.join(MESH_SUFFIXES)}")
    content = read_bytes(path, MESH_BYTES_MAX, MeshError)
    try:
        read = (_read if len(content) < 2000 else _kept)(path, content, part)
    except IndexError as error:
        raise MeshError(
            path, "is a broken mesh: a face names a corner that does not exist"
        ) from error
    except _BROKEN as error:
        raise MeshError(path, f"is a broken mesh: {' '.join(str(error).split())}") from error
    triangles, places, of, looks = read
    skin = Skin(places, of, tuple(Look(*each) for each in json.loads(looks.tobytes())))
    if len(triangles) == 0 and part:
        return triangles, skin
    if len(triangles) == 0:
        raise MeshError(path, "is a broken mesh: it has no triangles")
    if len(triangles) > _FACES_MAX:
        raise MeshError(path, f"has {len(triangles)} triangles; at most {_FACES_MAX} are read")
    if not (np.isfinite(triangles).all() and np.abs(triangles).max() < 1e9):
        raise MeshError(path, "is a broken mesh: its corners must be finite, below 1e9")
    return triangles, skin


def _kept(path: Path, content: bytes, part: str) -> Arrays:
    """Return what `_read` returns, from the user's cache where the mesh was read before."""
    made_of = made_by(__file__), content, f"{path.suffix.lower()}#{part}".encode()
    beside = _materials(path, content)
    return cached("triangles", (*made_of, beside), lambda: _read(path, content, part))


def _read(path: Path, content: bytes, part: str) -> Arrays:
    """Return triangles, their corners' places in pictures, and the numbers of their looks.

    The looks are the last array, as JSON. Corners without a place have NaN.
    """
    suffix = path.suffix.lower()
    prepared = {".stl": _stl, ".obj": _obj, ".dae": _collada}[suffix](path, content, part)
    if prepared:
        return _loaded(prepared, suffix, _materials(path, content))
    return np.zeros((0, 3, 3)), np.zeros((0, 3, 2), np.float32), np.zeros(0, np.int32), _packed([])


def _packed(looks: list[Any]) -> Bytes:
    return np.frombuffer(json.dumps(looks).encode(), np.uint8)


def _materials(path: Path, content: bytes) -> bytes:
    """Return the file of materials that an OBJ names, of its own folder; empty without one."""
    named = (
        re.search(rb"^mtllib[ \t]+([^\s/\\]+)", content, re.M) if path.suffix == ".obj" else None
    )
    beside = path.with_name(named[1].decode("utf-8", "replace")) if named else None
    return (
        b"" if beside is None or not beside.is_file() else read_bytes(beside, _TEXT_MAX, MeshError)
    )


class _Named:
    """Answers trimesh with the file of materials, and with a dot that knows a picture's name."""

    def __init__(self, materials: bytes) -> None:
        self._materials = materials

    def get(self, name: str) -> bytes:
        """Return the content of a file that a mesh names."""
        if name.endswith(".mtl"):
            return self._materials
        dot, said = io.BytesIO(), PngInfo()
        said.add_text(_NAME, name.encode("ascii", "replace").decode())
        Image.new("RGB", (1, 1)).save(dot, "PNG", pnginfo=said)
        return dot.getvalue()

    __getitem__ = get


def _loaded(content: bytes, suffix: str, materials: bytes) -> Arrays:
    """Return what `_read` returns of a whole file, as trimesh reads it.

    Raises:
        ValueError: It is broken; other exceptions of `_BROKEN` say the same.
    """
    import trimesh  # takes 0.8 s
    from collada.common import DaeError

    names: Any = _Named(materials)
    try:
        with np.errstate(all="ignore"):  # what is not finite is refused by the caller
            file = io.BytesIO(content)
            options: dict[str, Any] = {"process": False, "ignore_broken": False}
            scene = trimesh.load_scene(file, suffix[1:], names, **options)
            found: list[Any] = scene.dump() if scene.geometry else []
            triangles = [np.asarray(each.triangles, np.float64) for each in found]
    except DaeError as error:
        raise ValueError(str(error)) from error
    looks = [_look(getattr(each.visual, "material", None)) for each in found]
    kinds = list(dict.fromkeys(looks))  # many parts may have one look
    of = [kinds.index(look) for look in looks]
    units = scene.units or "meters"
    scale = float(units.partition(" * ")[0]) if " * " in units else 1.0
    return (
        np.concatenate((np.zeros((0, 3, 3)), *triangles)) * scale,
        np.concatenate((np.zeros((0, 3, 2), np.float32), *(_places(each) for each in found))),
        np.repeat(np.array(of, np.int32), [len(each) for each in triangles]),
        _packed(kinds),
    )


def _places(mesh: Any) -> Singles:
    """Return where corners are in a picture, from its top, `(N, 3, 2) float32`; NaN for nowhere."""
    uv = getattr(mesh.visual, "uv", None)
    if uv is None or len(uv) != len(mesh.vertices):
        return np.full((len(mesh.faces), 3, 2), np.nan, np.float32)
    placed: Singles = np.asarray(uv)[np.asarray(mesh.faces), :2].astype(np.float32)
    placed[..., 1] = 1.0 - placed[..., 1]
    return placed


def _look(material: Any) -> tuple[tuple[float, ...] | None, str]:
    """Return the colour and the picture's name of a material of trimesh; None and "" for none."""
    colour = getattr(material, "baseColorFactor", getattr(material, "diffuse", None))
    picture = getattr(material, "baseColorTexture", getattr(material, "image", None))
    rgba = None if colour is None else tuple(float(value) / 255.0 for value in np.ravel(colour))
    return rgba, "" if picture is None else str(picture.info.get(_NAME, ""))


def _stl(path: Path, content: bytes, part: str) -> bytes:
    """Return STL without what follows its last face; text is known by its size or beginning."""
    if part:
        return b""
    if len(content) >= _STL_HEADER:
        (count,) = struct.unpack_from("<I", content, 80)
        end = _STL_HEADER + _STL_FACE * count
        if len(content) == end or (len(content) > end and not content.startswith(b"solid")):
            return content[:end]
    if not content.lstrip().startswith(b"solid"):
        raise ValueError("it is cut off")
    return _text(content).strip().encode()


def _text(content: bytes) -> str:
    count = content.count(b"\n")
    if len(content) > _TEXT_MAX or count > _LINES_MAX:
        problem = f"it has {len(content)} bytes of text in {count} lines; valid: up to"
        raise ValueError(f"{problem} {_TEXT_MAX} bytes in {_LINES_MAX} lines")
    return content.decode("utf-8", "replace")


def _obj(path: Path, content: bytes, part: str) -> bytes:
    """Return Wavefront OBJ with the faces of an object or group alone, and without normals.

    Faces count from the first corner: trimesh takes those that count back from the last of all.
    """
    names: set[str] = set()
    kept, counts, has_faces = [], {"v": 0, "vt": 0}, False

    def counted(text: str, kind: str) -> int:
        i = int(text)
        return i if i > 0 else counts[kind] + 1 + i

    for line in _text(content).splitlines():
        words = line.split()
        if words[:1] in (["o"], ["g"]):
            names = set(words[1:])
        elif words[:1] in (["mtllib"], ["usemtl"]):
            kept.append(line)
        elif len(words) >= 3 and words[0] in counts:
            kept.append(" ".join(words[: 4 if words[0] == "v" else 3]))
            counts[words[0]] += 1
        elif len(words) >= 4 and words[0] == "f" and (not part or part in names):
            ends = [word.split("/") for word in words[1:]]
            ring = [counted(end[0], "v") for end in ends]
            if min(ring) < 1:
                raise ValueError("a face names a corner that does not exist")
            corners = [str(corner) for corner in ring]
            if all(len(end) > 1 and end[1] for end in ends):
                places = [counted(end[1], "vt") for end in ends]
                corners = [f"{corner}/{place}" for corner, place in zip(ring, places, strict=True)]
            kept += [f"f {corners[0]} {a} {b}" for a, b in itertools.pairwise(corners[1:])]
            has_faces = True
    return "\n".join(kept).encode() if has_faces else b""


def _collada(path: Path, content: bytes, part: str) -> bytes:
    """Return COLLADA that was parsed safely, with the geometries of a part alone.

    Source: Khronos, COLLADA 1.4.1 specification, chapter 10 (scenes).
    """
    if len(content) > _TEXT_MAX:
        raise ValueError(f"it has {len(content)} bytes; valid: up to {_TEXT_MAX}")
    root = parse_xml(path, content, MeshError)
    space = root.tag[: root.tag.rfind("}") + 1]
    nodes = {node.get("id", ""): node for node in root.iter(f"{space}node")}
    geometries = list(root.iter(f"{space}geometry"))
    scenes = list(root.iter(f"{space}visual_scene"))
    if sum(_placed(space, nodes, scene) for scene in scenes) > _PLACED_MAX:
        raise ValueError(f"it places more than {_PLACED_MAX} geometries")
    if part:
        _keep_part(space, root, geometries, part)
    kinds = (f".//{space}instance_geometry", f".//{space}instance_node")
    is_placed = any(scene.find(kind) is not None for scene in scenes for kind in kinds)
    if not is_placed and part:
        return b""
    if not is_placed:
        scenes = [_scene_of_all(space, root, geometries)]
    elif not part and root.find(f"{space}scene") is not None:
        return content
    if root.find(f"{space}scene") is None:
        scene = SubElement(root, f"{space}scene")
        SubElement(scene, f"{space}instance_visual_scene", url=f"#{scenes[0].get('id')}")
    register_namespace("", space.strip("{}"))  # which pycollada expects without a prefix
    return bytes(tostring(root))


def _placed(space: str, nodes: dict[str, Element], scene: Element) -> int:

    @cache
    def count(node: Element, depth: int) -> int:
        if depth > 64:
            raise ValueError("its nodes are nested too deeply or form a cycle")
        own = len(node.findall(f"{space}instance_geometry"))
        urls = (i.get("url", "")[1:] for i in node.findall(f"{space}instance_node"))
        inner = [*node.findall(f"{space}node"), *(nodes[url] for url in urls if url in nodes)]
        return own + sum(count(child, depth + 1) for child in inner)

    return count(scene, 0)


def _keep_part(space: str, root: Element, geometries: list[Element], part: str) -> None:
    """Take out the instances of geometries that neither their node nor they name as a part."""
    names = {g.get("id", ""): g.get("name") for g in geometries}
    for node in root.iter(f"{space}node"):
        for instance in node.findall(f"{space}instance_geometry"):
            geometry = instance.get("url", "").lstrip("#")
            own = (node.get("name"), node.get("id"), geometry, names.get(geometry))
            if part not in own:
                node.remove(instance)


def _scene_of_all(space: str, root: Element, geometries: list[Element]) -> Element:
    library = SubElement(root, f"{space}library_visual_scenes")
    scene = SubElement(library, f"{space}visual_scene", id="all")
    node = SubElement(scene, f"{space}node", id="all_geometries")
    for geometry in geometries:
        SubElement(node, f"{space}instance_geometry", url=f"#{geometry.get('id')}")
    for old in root.findall(f"{space}scene"):
        root.remove(old)
    return scene
