"""Entities that clients spawn: simple shapes by name, SDF models and actors, URDF robots."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from arjuna_core.errors import InputFileError, RobotError, WorldError
from arjuna_core.files.input_file import read_bytes
from arjuna_core.pose3 import Pose3
from arjuna_sim.files.library import Fault, Library, ResourceError, sent_text
from arjuna_sim.files.robots.robot_file import names_drive, robot_of_text
from arjuna_sim.files.sdf.world import read_world
from arjuna_sim.files.urdf.links_and_joints import read_urdf
from arjuna_sim.files.urdf.xacro_file import Expanded
from arjuna_sim.files.xml_file import BYTES_MAX, XmlFile, root_tag
from arjuna_sim.model.entities import (
    Category,
    Entity,
    entity_of_actor,
    entity_of_model,
    entity_of_robot,
    moving_entities,
)
from arjuna_sim.model.geometry.shapes import Kind, Part, Shape
from arjuna_sim.model.notes import Note, NoteKind
from arjuna_sim.model.robot import RobotModel
from arjuna_sim.model.world import GROUND, Movable, World, person

FORMATS = ("sdf", "urdf")
PRIMITIVES = ("box:X,Y,Z", "cylinder:RADIUS,LENGTH", "sphere:RADIUS", "person")
_COUNTS = {"box": 3, "cylinder": 2, "sphere": 1, "person": 0}
_PRIMITIVE = re.compile(r"(box|cylinder|sphere|person)(?::([^?]*))?(?:\?mass=(.*))?")
_SIZES = (1e-3, 100.0)
_MASS_MAX = 10_000.0
_ASSET_FAULTS = {
    NoteKind.MISSING: Fault.MISSING_ASSETS,
    NoteKind.UNSUPPORTED: Fault.UNSUPPORTED_ASSETS,
    NoteKind.BROKEN: Fault.RESOURCE_PARSE_ERROR,
}
_PARTS_MAX = 2000


def read_entity(uri: str, text: str, library: Library, drives: bool = False) -> Entity:
    """Read what a client asks to spawn, named as its file names it, standing at the origin.

    A primitive such as `box:0.4,0.4,1` stands on its origin and is held where it is put;
    `box:0.4,0.4,1?mass=5` can be pushed. A model of a file can be, unless it is static.

    Args:
        uri: A primitive, or a file's path or URI; may be empty.
        text: The file's content, where there is no URI.
        drives: Whether it is a robot that drives, whose file may refer to what is not there.

    Raises:
        ResourceError: It cannot be read or is nothing that can be spawned.
    """
    primitive = _PRIMITIVE.fullmatch(uri.strip())
    if primitive is not None:
        return _primitive(*primitive.groups())
    return _read_text(*_content(uri, text, library), library, drives)


def read_driven(uri: str, text: str, library: Library) -> RobotModel | None:
    """Return what a client asks to spawn as a robot, None where it is none that drives itself.

    An SDF model drives where it has a plugin for it, a URDF also where its wheels are found.

    Args:
        uri: As `read_entity` takes it, which has the word on what else is wrong with it.

    Raises:
        ResourceError: A file that names a drive cannot be read as a robot.
    """
    if _PRIMITIVE.fullmatch(uri.strip()) is not None:
        return None
    path, content = _content(uri, text, library)
    data = content.encode()
    if root_tag(data) == "sdf" and not names_drive(data):
        return None
    try:
        robot = robot_of_text(path, Expanded(data), library.search)
    except InputFileError as error:
        if not names_drive(data):
            return None
        raise ResourceError(Fault.RESOURCE_PARSE_ERROR, str(error)) from error
    return robot if robot.drive.wheels else None


def _content(uri: str, text: str, library: Library) -> tuple[Path, str]:
    """Return the text that a client names or sends, and where it is from."""
    if not uri.strip():
        return library.folder / "resource_string", sent_text(text)
    path = library.find(uri.strip(), (".sdf", ".urdf"))
    try:
        return path, read_bytes(path, BYTES_MAX).decode("utf-8", "replace")
    except InputFileError as error:
        raise ResourceError(Fault.FORBIDDEN, f"'{uri}' {error.problem}") from error


def _primitive(kind: str, sizes: str | None, mass: str | None) -> Entity:
    numbers = _numbers(sizes, _COUNTS[kind], kind)
    weight = 0.0 if mass is None else _numbers(mass, 1, "mass")[0]
    if not 0.0 <= weight <= _MASS_MAX:
        problem = f"mass is {weight} kg; valid: 0 to {_MASS_MAX:g}"
        raise ResourceError(Fault.RESOURCE_PARSE_ERROR, problem)
    about = "a person" if kind == "person" else f"a {kind} of {sizes} m"
    if kind == "person":
        return Entity(
            kind, person(), spawned=True, category=Category.HUMAN, description=about, mass=weight
        )
    low, high = _SIZES
    if any(not low <= number <= high for number in numbers):
        problem = f"'{kind}:{sizes}' has a size beyond {low:g} to {high:g} m"
        raise ResourceError(Fault.RESOURCE_PARSE_ERROR, problem)
    shape = Shape(Kind(kind), numbers)
    height = {"box": numbers[-1] / 2, "cylinder": numbers[-1] / 2, "sphere": numbers[0]}[kind]
    part = Part(shape, Pose3((0.0, 0.0, height)), (0.9, 0.6, 0.1, 1.0))
    category = Category.STATIC_OBJECT if weight == 0.0 else Category.OBJECT
    return Entity(kind, (part,), spawned=True, category=category, description=about, mass=weight)


def _numbers(text: str | None, count: int, what: str) -> tuple[float, ...]:
    words = text.split(",") if text else []
    try:
        values = tuple(float(word) for word in words)
    except ValueError:
        values = ()
    if len(words) != count or len(values) != count or not np.isfinite(values).all():
        valid = ", ".join(PRIMITIVES)
        problem = f"'{what}:{text or ''}' needs {count} finite numbers; valid: {valid}"
        raise ResourceError(Fault.RESOURCE_PARSE_ERROR, problem)
    return values


def _read_text(path: Path, text: str, library: Library, drives: bool) -> Entity:
    root = root_tag(text.encode())
    if not root:
        problem = f"holds neither <sdf> nor <robot>; valid formats: {', '.join(FORMATS)}"
        raise ResourceError(Fault.UNSUPPORTED_FORMAT, problem)
    read = _read_sdf if root == "sdf" else _read_urdf
    try:
        return read(path, text.encode(), library, drives)
    except (InputFileError, ValueError) as error:
        raise ResourceError(Fault.RESOURCE_PARSE_ERROR, str(error)) from error


def _read_sdf(path: Path, text: bytes, library: Library, drives: bool) -> Entity:
    xml = XmlFile(path, "sdf", WorldError, text, library.search)
    if xml.root.find("world") is not None:
        problem = "holds a <world>, which load_world takes; valid: one <model> or <actor>"
        raise ResourceError(Fault.UNSUPPORTED_FORMAT, problem)
    world = read_world(xml)
    undrawn = _undrawn(world.notes, drives)
    if len(xml.root.findall("model")) + len(xml.root.findall("actor")) != 1:
        raise xml.fail("sdf", "must hold one <model> or one <actor>")
    if world.actors:
        about = "an actor"
        return dataclasses.replace(
            entity_of_actor(world.actors[0]), spawned=True, description=about
        )
    if any(b.part.shape.kind is Kind.PLANE and b.model != GROUND for b in world.bodies):
        problem = "has a <plane>, which only a world can have"
        raise ResourceError(Fault.UNSUPPORTED_ASSETS, problem)
    return _of_model(xml, world, undrawn)


def _of_model(xml: XmlFile, world: World, undrawn: tuple[str, ...]) -> Entity:
    """Return a model: one body, which stands fast or moves, and what hangs on that in joints."""
    name = xml.attribute(xml.child(xml.root, "model", "sdf"), "name", "a model")
    bodies = [body for body in world.bodies if body.model != GROUND]
    if not bodies:
        raise xml.fail(f"model '{name}'", "has neither <collision> nor <visual>")
    T_world, hung = bodies[0].T_world_model, [e for e in moving_entities(world).values() if e.on]
    apart = {one.name for one in hung}
    loose = tuple(dict.fromkeys(body.model for body in bodies if body.model not in apart))
    own = [dataclasses.replace(b, model=name, T_world_model=T_world) for b in bodies]
    own = [new for new, body in zip(own, bodies, strict=True) if body.model in loose]
    model = entity_of_model(dataclasses.replace(world, bodies=tuple(own)), name)
    held = any(part not in world.movable for part in loose)
    mass = 0.0 if held else sum(world.movable[part].mass for part in loose)
    entity = _entity(name, model.solid, model.drawn, mass)
    if not held:
        entity = _moving(entity, world.movable[loose[0]])
    parts = tuple(
        dataclasses.replace(
            _moving(_entity(one.name, one.solid, one.drawn, one.mass), world.movable[one.name]),
            name=one.name.removeprefix(name),
            on="" if one.on in loose else one.on.removeprefix(name),
            start=T_world.inverse() @ one.start,
        )
        for one in hung
    )
    stiff = ("what of it hangs on nothing is spawned as one body",) * (len(loose) > 1)
    return dataclasses.replace(entity, hung=parts, notes=(*undrawn, *stiff))


def _moving(entity: Entity, as_in: Movable) -> Entity:
    """Return an entity that moves as a part of a world does."""
    _, hinge, floats, _, touches = as_in
    return dataclasses.replace(entity, hinge=hinge, floats=floats, self_collides=touches)


def _read_urdf(path: Path, text: bytes, library: Library, drives: bool) -> Entity:
    xml = XmlFile(path, "robot", RobotError, text, library.search)
    urdf = read_urdf(xml)
    undrawn = _undrawn(xml.notes, drives)
    robot = entity_of_robot(urdf)
    if not robot.solid and not robot.drawn:
        raise xml.fail(f"robot '{urdf.name}'", "has neither <collision> nor <visual>")
    static = any((e.findtext("static") or "").strip() == "true" for e in xml.root.iter("gazebo"))
    found = _entity(urdf.name, robot.solid, robot.drawn, 0.0 if static else robot.mass)
    return dataclasses.replace(found, notes=undrawn)


def _entity(name: str, solid: tuple[Part, ...], drawn: tuple[Part, ...], mass: float) -> Entity:
    """Build an entity; what nothing can touch is held, or it would fall through the ground."""
    if not 0.0 <= mass <= _MASS_MAX:
        problem = f"'{name}' weighs {mass:g} kg; valid: 0 to {_MASS_MAX:g}"
        raise ResourceError(Fault.RESOURCE_PARSE_ERROR, problem)
    if len(solid) + len(drawn) > _PARTS_MAX:
        problem = f"'{name}' has {len(solid) + len(drawn)} shapes; at most {_PARTS_MAX} are valid"
        raise ResourceError(Fault.RESOURCE_PARSE_ERROR, problem)
    weight = mass if solid else 0.0
    category = Category.OBJECT if weight > 0.0 else Category.STATIC_OBJECT
    return Entity(
        name, solid, drawn, spawned=True, mass=weight, category=category, description="a model"
    )


def _undrawn(notes: Iterable[Note], drives: bool) -> tuple[str, ...]:
    """Return what is not drawn, which Gazebo leaves out too.

    Anything else that is left out is refused, but of a robot that drives: the first one of a file
    starts so (`sim --robot`), and so do those that are spawned beside it.
    """
    if not drives:
        check_assets(note for note in notes if note.of != "visual")
    return tuple(note.text for note in notes if note.of == "visual")


def check_assets(notes: Iterable[Note]) -> None:
    """Refuse a file that refers to what is not there, or to what cannot be simulated.

    Raises:
        ResourceError: Something was left out; the message is the first such note.
    """
    for note in notes:
        if note.kind in _ASSET_FAULTS:
            raise ResourceError(_ASSET_FAULTS[note.kind], note.text)
