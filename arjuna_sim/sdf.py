"""Reading an SDF world: its fixed boxes, cylinders, spheres, planes and meshes."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from xml.etree.ElementTree import Element  # types only; parsing is defusedxml's

from arjuna_core.errors import WorldError
from arjuna_sim.actors import Actor, read_actor
from arjuna_sim.mesh_shape import mesh_shape
from arjuna_sim.pose3 import ORIGIN, Pose3
from arjuna_sim.shapes import GREY, Kind, Part, Shape
from arjuna_sim.xml_file import XmlFile

BUILT_IN = ("sun", "ground_plane")
GROUND = "ground_plane"
_SHAPES = {"box": ("size",), "cylinder": ("radius", "length"), "sphere": ("radius",), "plane": ()}
_IGNORED = ("polyline", "heightmap", "image", "empty", "capsule", "ellipsoid", "cone")
_UNLIT = ("light", "gui", "physics", "gravity", "scene", "plugin", "state", "magnetic_field")
_SCRIPT_COLOURS = {
    "red": (0.8, 0.1, 0.1, 1.0),
    "green": (0.1, 0.7, 0.1, 1.0),
    "blue": (0.1, 0.1, 0.8, 1.0),
    "yellow": (0.9, 0.8, 0.1, 1.0),
    "orange": (1.0, 0.5, 0.1, 1.0),
    "white": (1.0, 1.0, 1.0, 1.0),
    "black": (0.05, 0.05, 0.05, 1.0),
}


@dataclass(frozen=True)
class Body:
    """One part of a world.

    Attributes:
        model: Name of the model it belongs to.
        part: Its shape, pose in the world and colour.
        collides: Whether it stops robots and rays, or is only drawn.
        T_world_model: Where its model stands.
    """

    model: str
    part: Part
    collides: bool
    T_world_model: Pose3 = ORIGIN


@dataclass(frozen=True)
class World:
    """A world as it was read.

    Attributes:
        path: The file.
        name: The world's name.
        bodies: Its fixed parts; the ground is one with the model `ground_plane`.
        notes: What the file says and the simulation leaves out, one line each.
        actors: What moves by itself.
    """

    path: Path
    name: str
    bodies: tuple[Body, ...]
    notes: tuple[str, ...]
    actors: tuple[Actor, ...] = ()


def load_world(path: str | Path) -> World:
    """Read a `.world` or `.sdf` file.

    Raises:
        WorldError: The file cannot be read, or holds values or models that cannot be simulated.
    """
    return read_world(XmlFile(Path(path), "sdf", WorldError))


def read_world(xml: XmlFile) -> World:
    """Read a parsed SDF file.

    Raises:
        WorldError: It holds values or models that cannot be simulated.
    """
    found = xml.root.find("world")
    world = xml.root if found is None else found
    if found is None and xml.root.find("model") is None and xml.root.find("actor") is None:
        raise WorldError(xml.path, "<sdf> must hold a <world>, a <model> or an <actor>")
    bodies: list[Body] = []
    actors: list[Actor] = []
    for element in world:
        if element.tag == "include":
            bodies.extend(_include(xml, element, Pose3()))
        elif element.tag == "model":
            bodies.extend(_model(xml, element, Pose3()))
        elif element.tag == "actor":
            actors.append(read_actor(xml, element, _pose(xml, element, "an actor")))
        elif element.tag not in _UNLIT:
            xml.note(f"<{element.tag}>: not simulated")
    for plugin in world.iter("plugin"):
        xml.note(f"plugin '{plugin.get('name', '?')}': not simulated")
    if not any(body.part.shape.kind is Kind.PLANE and body.collides for body in bodies):
        xml.note("has no ground plane: one is put at height 0")
        bodies.extend(_ground())
    name = world.get("name", "world")
    return World(xml.path, name, tuple(bodies), tuple(xml.notes), tuple(actors))


def _ground() -> list[Body]:
    part = Part(Shape(Kind.PLANE), rgba=(0.6, 0.6, 0.6, 1.0))
    return [Body(GROUND, part, True), Body(GROUND, part, False)]


def _include(xml: XmlFile, element: Element, T_world: Pose3) -> list[Body]:
    uri = (element.findtext("uri") or "").strip()
    name = uri.strip("/").rpartition("/")[2].lower().replace(" ", "_")
    if name == "sun":
        return []
    if name == GROUND:
        return _ground()
    path = xml.find(f"{uri}/model.sdf", f"include '{uri}'")
    if path is None:
        built_in = ", ".join(BUILT_IN)
        xml.note(f"include: model '{uri}' does not exist, so it is left out; built in: {built_in}")
        return []
    if path.resolve() in xml.included:
        raise xml.fail("include", f"model '{uri}' includes itself")
    inner = XmlFile(path, "sdf", WorldError, search=xml.search)
    inner.included += xml.included
    model = inner.child(inner.root, "model", "sdf")
    model.set("name", (element.findtext("name") or model.get("name") or name).strip())
    T_world_model = T_world @ _pose(xml, element, f"include '{uri}'")
    bodies = _model(inner, model, T_world_model, placed=True)
    for note in inner.notes:
        xml.note(note)
    return bodies


def _pose(xml: XmlFile, element: Element, place: str) -> Pose3:
    pose = element.find("pose")
    if pose is None or not (pose.text or "").strip():
        return Pose3()
    if pose.get("relative_to") or pose.get("frame"):
        xml.note(f"{place}: the frame of its <pose> is taken to be its parent")
    numbers = xml.numbers(pose.text or "", 6, f"{place} pose")
    angles = numbers[3:]
    if pose.get("degrees") == "true":
        angles = tuple(math.radians(angle) for angle in angles)
    return Pose3.from_rpy(numbers[:3], angles)


def _model(xml: XmlFile, model: Element, T_world: Pose3, placed: bool = False) -> list[Body]:
    """Read a model; `placed` says that its own pose is overruled by who includes it."""
    name = xml.attribute(model, "name", "a model")
    place = f"model '{name}'"
    if (model.findtext("static") or "").strip() not in ("true", "1"):
        xml.note(f"{place}: is not static, but is held in place")
    T_world_model = T_world if placed else T_world @ _pose(xml, model, place)
    bodies = []
    for link in model.findall("link"):
        T_world_link = T_world_model @ _pose(xml, link, f"{place} link")
        for tag in ("collision", "visual"):
            for element in link.findall(tag):
                bodies.extend(_body(xml, name, element, T_world_link, T_world_model))
    for nested in model.findall("model"):
        bodies.extend(_model(xml, nested, T_world_model))
    for include in model.findall("include"):
        bodies.extend(_include(xml, include, T_world_model))
    return bodies


def _body(
    xml: XmlFile, model: str, element: Element, T_world_link: Pose3, T_world_model: Pose3
) -> list[Body]:
    place = f"model '{model}' {element.tag}"
    shape = _shape(xml, xml.child(element, "geometry", place), place)
    if shape is None:
        return []
    pose = T_world_link @ _pose(xml, element, place)
    collides = element.tag == "collision"
    part = Part(shape, pose, _colour(xml, element, place))
    return [Body(model, part, collides, T_world_model)]


def _shape(xml: XmlFile, geometry: Element, place: str) -> Shape | None:
    """Read a shape; None (and a note) for one that is not simulated."""
    if len(geometry) == 0:
        valid = ", ".join([*_SHAPES, "mesh"])
        raise xml.fail(place, f"<geometry> is empty; valid: {valid}")
    item = geometry[0]
    if item.tag == "mesh":
        uri = (item.findtext("uri") or "").strip()
        return mesh_shape(xml, uri, item.findtext("scale") or "1 1 1", place)
    if item.tag in _IGNORED:
        xml.note(f"{place}: <{item.tag}> is left out; simulated are {', '.join(_SHAPES)}, mesh")
        return None
    if item.tag not in _SHAPES:
        valid = ", ".join([*_SHAPES, "mesh"])
        raise xml.fail(place, f"<{item.tag}> is unknown; valid: {valid}")
    size: tuple[float, ...] = ()
    for key in _SHAPES[item.tag]:
        count = 3 if key == "size" else 1
        text = xml.child(item, key, place).text or ""
        size += xml.positive(text, count, f"{place} <{key}>")
    return Shape(Kind(item.tag), size)


def _colour(xml: XmlFile, element: Element, place: str) -> tuple[float, ...]:
    for key in ("diffuse", "ambient"):
        text = element.findtext(f"material/{key}")
        if text:
            words = " ".join([*text.split(), "1"][:4])
            return xml.numbers(words, 4, f"{place} <{key}>")
    script = (element.findtext("material/script/name") or "").rpartition("/")[2].lower()
    return _SCRIPT_COLOURS.get(script, GREY)
