"""Reading SDF's geometries, materials and surfaces."""

from __future__ import annotations

import math
import zlib
from pathlib import Path
from xml.etree.ElementTree import Element  # types only; parsing is defusedxml's

import numpy as np

from arjuna_core.arrays import Floats
from arjuna_core.pose3 import ORIGIN, Pose3
from arjuna_sim.files.meshes import mesh_shape
from arjuna_sim.files.sdf.includes import leaving_out
from arjuna_sim.files.sdf.solids import cone, prism, read_heights
from arjuna_sim.files.tag_text import gazebo_colour, is_true
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.geometry.shapes import GREY, Kind, Mesh, Shape, Terrain
from arjuna_sim.model.notes import NoteKind
from arjuna_sim.model.world import World

_SHAPES = {
    "box": ("size",),
    "cylinder": ("radius", "length"),
    "capsule": ("radius", "length"),
    "sphere": ("radius",),
    "ellipsoid": ("radii",),
}
_TRIPLES = ("size", "radii")
_OTHERS = ("plane", "cone", "polyline", "heightmap", "mesh")
_IGNORED = ("image", "empty")

Placed = tuple[Shape, Pose3]
"""A shape, and its pose in the frame of its `<collision>` or `<visual>`."""
_FRICTION = "surface/friction"
_ODE = f"{_FRICTION}/ode"
_BOUNCE = "surface/bounce/restitution_coefficient"
_BITMASK = "surface/contact/collide_bitmask"
_EVERYTHING = ("0xff", "255", "0xffff", "65535")  # Gazebo's own are the lowest 8 of SDF's 16 bits
_PULL_MAX = 100.0  # [m/s^2] Jupiter's gravity is 24.8


def read_shape(xml: XmlFile, geometry: Element, label: str) -> Placed | None:
    """Read a shape; None (and a note) for one that is not simulated.

    Raises:
        WorldError: It is unknown, or its size is no size.
    """
    valid = ", ".join([*_SHAPES, *_OTHERS])
    item = next((child for child in geometry if isinstance(child.tag, str)), None)
    if item is None:
        raise xml.fail(label, f"<geometry> is empty; valid: {valid}")
    if item.tag in _IGNORED:
        problem = f"{label}: <{item.tag}> is left out; simulated are {valid}"
        xml.note(problem, NoteKind.UNSUPPORTED if item.tag == "image" else NoteKind.IGNORED)
        return None
    if item.tag == "plane":
        return Shape(Kind.PLANE), _upright(xml, item, label)
    if item.tag == "heightmap":
        return _terrain(xml, item, label)
    shape = _shape(xml, item, label, valid)
    return None if shape is None else (shape, ORIGIN)


def _shape(xml: XmlFile, item: Element, label: str, valid: str) -> Shape | None:
    if item.tag == "mesh":
        uri = (item.findtext("uri") or "").strip()
        part = (item.findtext("submesh/name") or "").strip()
        centred = is_true(item.findtext("submesh/center"))
        return mesh_shape(xml, uri, item.findtext("scale") or "1 1 1", label, part, centred)
    if item.tag == "cone":
        radius, length = _sizes(xml, item, ("radius", "length"), label)
        return _made(xml, "cone", cone(radius, length))
    if item.tag == "polyline":
        return _made(xml, "polyline", _polyline(xml, item, label))
    if item.tag not in _SHAPES:
        raise xml.fail(label, f"<{item.tag}> is unknown; valid: {valid}")
    return Shape(Kind(item.tag), _sizes(xml, item, _SHAPES[item.tag], label))


def _sizes(xml: XmlFile, item: Element, keys: tuple[str, ...], label: str) -> tuple[float, ...]:
    size: tuple[float, ...] = ()
    for key in keys:
        text = xml.child(item, key, label).text or ""
        size += xml.sizes(text, 3 if key in _TRIPLES else 1, f"{label} <{key}>")
    return size


def _made(xml: XmlFile, kind: str, triangles: Floats) -> Shape:
    """Return triangles that were made as a mesh, the same for the same triangles."""
    path = Path(f"{xml.path}#{kind}-{zlib.crc32(triangles.tobytes()):08x}")
    return Shape(Kind.MESH, (1.0, 1.0, 1.0), xml.meshes.setdefault(path, Mesh(path, triangles)))


def _polyline(xml: XmlFile, item: Element, label: str) -> Floats:
    height = xml.sizes(item.findtext("height") or "1", 1, f"{label} <height>")[0]
    lines = [item, *item.findall("polyline")]
    corners = [xml.numbers(p.text or "", 2, f"{label} <point>") for p in lines[0].iter("point")]
    try:
        return prism(np.array(corners).reshape(-1, 2), height)
    except ValueError as error:
        raise xml.fail(label, f"<polyline> {error}") from error


def _upright(xml: XmlFile, item: Element, label: str) -> Pose3:
    text = item.findtext("normal") or "0 0 1"
    x, y, z = xml.numbers(text, 3, f"{label} <normal>")
    length = math.hypot(x, y, z)
    if not 0.0 < length < math.inf:
        raise xml.fail(f"{label} <normal>", "must not be zero")
    return Pose3.from_rpy((0.0, 0.0, 0.0), (0.0, math.acos(z / length), math.atan2(y, x)))


def _terrain(xml: XmlFile, item: Element, label: str) -> Placed | None:
    """Read a heightmap; None (and a note) where its image is missing."""
    uri = (item.findtext("uri") or "").strip()
    path = xml.find(uri, label)
    if path is None:
        xml.note(f"{label}: heightmap '{uri}' does not exist, so it is left out", NoteKind.MISSING)
        return None
    size = xml.sizes(item.findtext("size") or "1 1 1", 3, f"{label} <size>")
    x, y, z = xml.position(item.findtext("pos") or "0 0 0", f"{label} <pos>")
    if path not in xml.terrains:
        xml.terrains[path] = Terrain(path.resolve(), read_heights(path))
    return Shape(Kind.TERRAIN, size, terrain=xml.terrains[path]), Pose3((x, y, z))


def read_colour(xml: XmlFile, element: Element, label: str) -> tuple[float, ...]:
    """Return the colour of a `<visual>`'s material.

    Raises:
        WorldError: It is no colour.
    """
    for key in ("diffuse", "ambient"):
        text = element.findtext(f"material/{key}")
        if text:
            words = " ".join([*text.split(), "1"][:4])
            return xml.numbers(words, 4, f"{label} <{key}>")
    return gazebo_colour(element.findtext("material/script/name") or "") or GREY


def read_friction(xml: XmlFile, element: Element, label: str) -> float | None:
    """Return the friction of a `<collision>`; None where it names none.

    Rubber is the same all around here: what the file says of a second direction, of slip or of
    twisting becomes a note, and so does that it bounces or does not touch everything.
    """
    mask = (element.findtext(_BITMASK) or "0xffff").strip()
    if mask.lower() not in _EVERYTHING:
        xml.note(f"{label}: <collide_bitmask> {mask}: it touches everything", NoteKind.IGNORED)
    with leaving_out(xml, f"{label} <bounce>"):
        if xml.number(element, _BOUNCE, 0.0, label) > 0.0:
            xml.note(f"{label}: <restitution_coefficient>: not simulated", NoteKind.IGNORED)
    mu = element.findtext(f"{_ODE}/mu") or element.findtext(f"{_FRICTION}/bullet/friction")
    if mu is None:
        return None
    with leaving_out(xml, f"{label} <friction>"):
        value = max(0.0, xml.numbers(mu, 1, f"{label} <mu>")[0])
        second = xml.number(element, f"{_ODE}/mu2", value, label)
        if second != value:
            xml.note(f"{label}: <mu2> is taken to be <mu>, {value:g}")
        for tag in ("slip1", "slip2"):
            if xml.number(element, f"{_ODE}/{tag}", 0.0, label) != 0.0:
                xml.note(f"{label}: <{tag}>: not simulated", NoteKind.IGNORED)
        return value
    return None


def read_gravity(xml: XmlFile, world: Element) -> tuple[float, float, float]:
    """Return the acceleration of free fall of a `<world>` [m/s^2]."""
    text = world.findtext("gravity") or world.findtext("physics/gravity")
    if not text or not text.strip():
        return World.gravity
    with leaving_out(xml, "world <gravity>"):
        x, y, z = xml.numbers(text, 3, "world <gravity>")
        if max(abs(x), abs(y), abs(z)) > _PULL_MAX:
            raise xml.fail("world <gravity>", f"is {text.strip()}; valid: up to {_PULL_MAX:g}")
        return x, y, z
    return World.gravity
