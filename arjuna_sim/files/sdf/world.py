"""Reading an SDF world: its models, actors, joints and position on Earth."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Collection, Sequence
from typing import Any
from xml.etree.ElementTree import Element  # types only; parsing is defusedxml's

from arjuna_core.errors import WorldError
from arjuna_core.geodesy import GeoPoint
from arjuna_core.pose3 import ORIGIN, Pose3
from arjuna_core.se2 import SE2
from arjuna_sim.files.robots.plugins import is_done
from arjuna_sim.files.sdf.frames import Scope, raw_pose
from arjuna_sim.files.sdf.geometry_tags import read_gravity
from arjuna_sim.files.sdf.includes import ExcessError, Includes, leaving_out
from arjuna_sim.files.sdf.look_tags import read_light, read_look
from arjuna_sim.files.sdf.model_tags import (
    PARTS_MAX,
    WORLD,
    ModelReader,
    SdfJoint,
    is_static,
    parts_of,
    read_joint,
)
from arjuna_sim.files.sdf.rigid_groups import RigidGroup, rigid_groups, with_belts
from arjuna_sim.files.sdf.robots_in_world import (
    driven_joints,
    is_mover,
    models_by_name,
    read_belt,
    read_follower,
    read_motors,
    read_mover,
    robots_of,
)
from arjuna_sim.files.sdf.world_sensors import read_fixtures
from arjuna_sim.files.sdf.world_state import moved_models, stretch_models
from arjuna_sim.files.tag_text import is_true
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.geometry.convex_pieces import PIECES_MAX, PIECES_OF_MOVING
from arjuna_sim.model.geometry.shapes import MASS_MAX, Kind, Part, estimated_inertial
from arjuna_sim.model.look import Light
from arjuna_sim.model.notes import NoteKind
from arjuna_sim.model.urdf import Hinge
from arjuna_sim.model.world import (
    GROUND,
    Actor,
    Body,
    Earth,
    Fixture,
    Follower,
    Motor,
    Movable,
    Mover,
    Trajectory,
    World,
    ground_bodies,
    person,
)

_WAYPOINTS_MAX = 10_000
_ANGLES = {"latitude_deg": 90.0, "longitude_deg": 360.0, "heading_deg": 360.0}
_PASSIVE = (
    *("gui", "physics", "gravity", "scene", "plugin", "state", "magnetic_field"),
    *("frame", "joint", "atmosphere", "wind", "spherical_coordinates", "audio"),
)
_MASS = 1.0  # SDF's default [kg]


def read_actor(
    xml: XmlFile, element: Element, T_world: Pose3, models: ModelReader | None = None
) -> Actor:
    """Read an SDF `<actor>`: its name, pose, links and scripted trajectories.

    A cylinder stands for its skin and animations, unless it has links, which move in one piece.

    Args:
        T_world: Its own pose in the world.
        models: The reader of its links, which are left out without it.

    Raises:
        InputFileError: A waypoint lacks its time or pose, or they are no numbers.
    """
    name = xml.attribute(element, "name", "an actor")
    script = element.find("script")
    trajectory = None if script is None else _read_script(xml, script, f"actor '{name}'")
    start = T_world.planar() if trajectory is None else trajectory.poses[0]
    parts = () if models is None else _actor_parts(xml, element, T_world, models)
    if not parts:
        xml.note(f"actor '{name}': an upright cylinder stands for its skin")
    return Actor(name, parts or person(), start, trajectory)


def _actor_parts(
    xml: XmlFile, element: Element, T_world: Pose3, models: ModelReader
) -> tuple[Part, ...]:
    """Return what an actor's links look like, as high as it begins; nothing where it has none."""
    held, first = Element("model", element.attrib), element.find("script/trajectory/waypoint/pose")
    held.extend(element.findall("link"))
    height = T_world.position[2]
    if first is not None:
        height = xml.numbers(first.text or "", 6, f"actor '{element.get('name')}' <pose>")[2]
    links, _ = models.read(xml, held, Pose3((0.0, 0.0, height)))
    return tuple(part for link in links for part in link.drawn or link.solid)


def _read_script(xml: XmlFile, script: Element, label: str) -> Trajectory | None:
    """Join a script's trajectories by their ids, as Gazebo plays them."""
    if not is_true(script.findtext("auto_start", "true")):
        xml.note(f"{label}: <auto_start> is false, so it stands still")
        return None
    waypoints = [w for t in script.findall("trajectory") for w in t.findall("waypoint")]
    if not waypoints:
        return None
    if len(waypoints) > _WAYPOINTS_MAX:
        raise xml.fail(label, f"has {len(waypoints)} waypoints; at most {_WAYPOINTS_MAX} are read")
    read = [_read_waypoint(xml, waypoint, label) for waypoint in waypoints]
    read.sort(key=lambda item: item[0])
    delay = xml.number(script, "delay_start", 0.0, label)
    if delay < 0.0:
        raise xml.fail(label, f"<delay_start> is {delay}; valid: 0 or more")
    loop = is_true(script.findtext("loop", "true"))
    return Trajectory(tuple(t for t, _ in read), tuple(p for _, p in read), loop, delay)


def _read_waypoint(xml: XmlFile, waypoint: Element, label: str) -> tuple[float, SE2]:
    label = f"{label} waypoint"
    (time,) = xml.numbers(xml.child(waypoint, "time", label).text or "", 1, f"{label} <time>")
    if time < 0.0:
        raise xml.fail(label, f"<time> is {time}; valid: 0 or more")
    text = xml.child(waypoint, "pose", label).text or ""
    values: Sequence[float] = xml.numbers(text, 6, f"{label} <pose>")
    return time, SE2(values[0], values[1], values[5])


def _note_pace(xml: XmlFile, world: Element) -> None:
    """Note a pace of time that the file asks for: the simulator's user says it."""
    with leaving_out(xml, "<physics>"):
        factor = xml.number(world.find("physics"), "real_time_factor", 1.0, "<physics>")
        if factor not in (0.0, 1.0):
            pace = f"time runs at 1, unless '--rtf {max(0.0, factor):g}' says so"
            xml.note(f"<real_time_factor> {factor:g}: {pace}", NoteKind.IGNORED)


def read_earth(xml: XmlFile, world: Element) -> Earth:
    """Read `<spherical_coordinates>` and `<magnetic_field>`; what is broken is left out."""
    nowhere = Earth()
    origin, heading, field = nowhere.origin, nowhere.heading, nowhere.magnetic_field
    with leaving_out(xml, "<spherical_coordinates>"):
        tag, label = world.find("spherical_coordinates"), "<spherical_coordinates>"
        latitude, longitude, turn = (_angle(xml, tag, key, label) for key in _ANGLES)
        altitude = xml.number(tag, "elevation", 0.0, label)
        origin = GeoPoint(latitude, math.remainder(longitude, 360.0), altitude)
        heading = math.radians(turn)
    with leaving_out(xml, "<magnetic_field>"):
        text = world.findtext("magnetic_field")
        if text is not None and text.strip():
            x, y, z = xml.numbers(text, 3, "<magnetic_field>")
            field = (x, y, z)
    return Earth(origin, heading, field)


def _angle(xml: XmlFile, tag: Element | None, key: str, label: str) -> float:
    value = xml.number(tag, key, 0.0, label)
    if abs(value) > _ANGLES[key]:
        raise xml.fail(label, f"<{key}> is {value:g}; valid: up to {_ANGLES[key]:g}")
    return value


def world_joints(xml: XmlFile, world: Element, scope: Scope) -> dict[str, list[SdfJoint]]:
    """Return a world's own joints by the model that each holds, as if they were that model's.

    What connects two models that both move is left out, with a note.
    """
    models = models_by_name(world)
    found: dict[str, list[SdfJoint]] = {}
    for element in world.findall("joint"):
        label = f"joint '{element.get('name', '?')}'"
        with leaving_out(xml, label):
            joint = read_joint(xml, element, scope, ORIGIN, "")
            ends = [_end(models, name) for name in (joint.parent, joint.child)]
            held = sorted({model for model, _ in ends if model != WORLD})
            if len(held) != 1:
                problem = "connects no model to what stands fast: not simulated"
                xml.note(f"{label}: {problem}", NoteKind.IGNORED)
                continue
            parent, child = (WORLD if model == WORLD else link for model, link in ends)
            found.setdefault(held[0], []).append(
                dataclasses.replace(joint, parent=parent, child=child)
            )
    return found


def _end(models: dict[str, Element], name: str) -> tuple[str, str]:
    """Return the model and the path of the link that a joint's end names; `WORLD` for what stands.

    A model's name alone stands for its canonical link, its first unless it says otherwise.
    """
    first, _, rest = name.partition("::")
    model = models.get(first)
    if model is None or is_static(model):
        return WORLD, ""
    link = model.find("link")
    canonical = "" if link is None else link.get("name", "")
    return first, rest or model.get("canonical_link", canonical)


def read_world(xml: XmlFile, without: Collection[str] = ()) -> World:
    """Read a parsed SDF file; a piece of it that is broken or missing is left out, with a note.

    Args:
        without: Names of models that are robots, and no part of the world.

    Raises:
        WorldError: It is no world, or holds more than is read.
    """
    found = xml.root.find("world")
    world = xml.root if found is None else found
    if found is None and xml.root.find("model") is None and xml.root.find("actor") is None:
        raise WorldError(xml.path, "<sdf> must hold a <world>, a <model> or an <actor>")
    if len(xml.root.findall("world")) > 1:
        xml.note("has more than one <world>: only the first is simulated")
    if sum(1 for e in world.iter() if e.tag in ("collision", "visual")) > PARTS_MAX:
        raise ExcessError(xml.path, f"has too many parts; valid: up to {PARTS_MAX}")
    reader = _Reader(xml)
    reader.read(world, without)
    reader.note_missing()
    parts = (*world.iter("sensor"), *world.iter("gui"), *reader.known)
    known = {id(plugin) for each in parts for plugin in each.iter("plugin")}
    for plugin in world.iter("plugin"):
        if id(plugin) not in known and not is_done(plugin):
            xml.note(f"plugin '{plugin.get('name', '?')}': not simulated", NoteKind.IGNORED)
    _note_pace(xml, world)
    look = read_look(xml, world, reader.lights)
    bodies, earth, gravity = reader.bodies, read_earth(xml, world), read_gravity(xml, world)
    flat = (Kind.PLANE, Kind.TERRAIN)
    if not any(body.part.shape.kind in flat and body.collides for body in bodies):
        xml.note("has no ground plane: one is put at height 0")
        bodies.extend(ground_bodies())
    return World(
        xml.path,
        world.get("name", "world"),
        tuple(bodies),
        tuple(xml.notes),
        tuple(reader.actors),
        reader.movable,
        earth,
        gravity,
        look,
        tuple(reader.sensors),
        reader.movers,
        reader.followers,
        reader.motors,
    )


class _Reader:
    """Collects a world's parts, from its file and those that it includes."""

    def __init__(self, xml: XmlFile) -> None:
        self._xml = xml
        self._includes = Includes(xml)
        self._models = ModelReader(self._includes)
        self._used: set[str] = set()
        self._held: dict[str, list[SdfJoint]] = {}
        self.bodies: list[Body] = []
        self.actors: list[Actor] = []
        self.movable: dict[str, Movable] = {}
        self.lights: list[Light] = []
        self.sensors: list[Fixture] = []
        self.movers: dict[str, Mover] = {}
        self.followers: dict[str, Follower] = {}
        self.motors: dict[str, Motor] = {}
        self.known: list[Element] = []  # models with plugins that are simulated

    def read(self, world: Element, without: Collection[str]) -> None:
        """Read a `<world>`, or an `<sdf>` that holds a model."""
        xml = self._xml
        self._includes.expand(xml, world)
        stretch_models(xml, world)
        scope, moved = Scope(xml, world, "world"), moved_models(xml, world)
        self._held = world_joints(xml, world, scope)
        for model in world.findall("model"):
            if model.get("name", "").strip() in without:
                world.remove(model)
        for name, model in robots_of(xml, self._includes, world).items():
            self.known.append(model)
            option = f"--robot {xml.path.name}#{name}"
            text = f"model '{name}': is a robot, but stands here as a thing; {option} drives it"
            xml.note(text, NoteKind.IGNORED)
        for element in world:
            name = element.get("name", "")
            with leaving_out(xml, f"{element.tag} '{name}'"):
                if element.tag == "model":
                    pose = moved.get(name) or scope.pose(element, f"model '{name}'")
                    self._top(element, pose, placed=name in moved)
                elif element.tag == "actor":
                    pose = raw_pose(xml, element, "an actor")
                    self.actors.append(read_actor(xml, element, pose, self._models))
                elif element.tag == "light":
                    self.lights += read_light(xml, element, scope.pose(element, f"light '{name}'"))
                elif element.tag not in _PASSIVE:
                    xml.note(f"<{element.tag}>: not simulated", NoteKind.IGNORED)

    def note_missing(self) -> None:
        """Note how to get models that are not there, first where nothing is without them."""
        missing = self._includes.missing
        if not missing:
            return
        of_fuel = [uri for uri in missing if uri.startswith(("http://", "https://"))]
        models = f"{len(missing)} model{'s' * (len(missing) > 1)}"
        text = f"{models} of Fuel" if len(of_fuel) == len(missing) else models
        text += f" {'are' if len(missing) > 1 else 'is'} not on this machine;"
        text += f" 'gz fuel download -u {of_fuel[0]}' fetches one, or" if of_fuel else ""
        text += " --model-path DIR finds them below DIR"
        if all(body.model == GROUND for body in self.bodies) and not self.actors:
            text = f"is an empty world now: {text}"
        self._xml.note(text, NoteKind.MISSING)

    def _top(self, model: Element, pose: Pose3, placed: bool) -> None:
        """Read a model of the world, under a name of its own."""
        xml = self._xml
        name = self._free_name(xml.attribute(model, "name", "a model"))
        links, joints = self._models.read(xml, model, pose, placed)
        joints += self._held.pop(name, [])
        names: list[str] = []
        is_robot = any(model is each for each in self.known)
        motors: dict[str, Motor] = {}
        belts: dict[str, tuple[Hinge, Motor]] = {}
        if not is_robot:
            motors = self._by_plugins(model, name, read_motors, joints)
            belts = self._by_plugins(model, name, read_belt, links)
        motors |= {link: motor for link, (_, motor) in belts.items()}
        driven = driven_joints(model, [joint.name for joint in joints], is_robot) - motors.keys()
        groups = rigid_groups(xml, f"model '{name}'", links, joints, driven)
        for group in with_belts(groups, {link: hinge for link, (hinge, _) in belts.items()}):
            solid = any(link.solid for link in group.links)
            moves = solid and not group.fast
            called = name
            is_whole = group.joint in belts and not names
            if (moves and name in self.movable) or (group.hinge is not None and not is_whole):
                called = self._free_name(f"{name}::{group.links[0].name}")
            names.append(called)
            if moves:
                floats = all(link.floats for link in group.links)
                on = "" if group.on is None else names[group.on]
                touches = any(link.self_collides for link in group.links)
                mass = self._mass(called, group)
                self.movable[called] = Movable(mass, group.hinge, floats, on, touches)
                if group.joint in motors:
                    self.motors[called] = motors[group.joint]
                if called == name and group.hinge is None:
                    self._moved(model, name, group.links[0].T_world)
            self._note_pieces(called, group, PIECES_OF_MOVING if moves else PIECES_MAX)
            self.lights += [light for link in group.links for light in link.lights]
            if moves and any(link.lights for link in group.links):
                self._xml.note(f"model '{called}': its light stays where it is at first")
            T_world = group.links[0].T_world if moves else pose
            self.sensors += read_fixtures(called, group.links, T_world)
            self.bodies += [
                Body(called, part, collides, T_world) for part, collides in parts_of(group.links)
            ]

    def _moved(self, model: Element, name: str, T_world: Pose3) -> None:
        """Keep what a model's plugin moves it by, which stands free."""
        with leaving_out(self._xml, f"plugin of model '{name}'"):
            if is_mover(model):
                self.movers[name] = read_mover(self._xml, model, name)
                self.known.append(model)
            elif (follower := read_follower(self._xml, model, name, T_world)) is not None:
                self.followers[name] = follower
                self.known.append(model)

    def _by_plugins(self, model: Element, name: str, read: Any, parts: Sequence[Any]) -> Any:
        """Return by name all that `read` finds in plugins of a model about links or joints."""
        found: dict[str, Any] = {}
        for plugin in model.iter("plugin"):
            with leaving_out(self._xml, f"plugin of model '{name}'"):
                if mine := read(self._xml, plugin, name, parts):
                    found |= mine
                    self.known.append(plugin)
        return found

    def _note_pieces(self, name: str, group: RigidGroup, most: int) -> None:
        """Note which meshes have contacts that differ from their surface."""
        for shape in (part.shape for link in group.links for part in link.solid):
            found = None if shape.mesh is None else shape.mesh.pieces(shape.size, most)
            if found is not None and shape.mesh is not None and found.within > 0.0:
                self._xml.note(
                    f"model '{name}': mesh '{shape.mesh.path.name}' is touched as"
                    f" {len(found.corners)} convex pieces, within {found.within:.2g} m of it"
                )

    def _free_name(self, name: str) -> str:
        if name in self._used:
            free = next(n for i in itertools.count(1) if (n := f"{name}_{i}") not in self._used)
            self._xml.note(f"model '{name}': is there twice; the second is called '{free}'")
            name = free
        self._used.add(name)
        return name

    def _mass(self, name: str, group: RigidGroup) -> float:
        """Return what links weigh: a link without a mass as much as its shapes hold [kg]."""
        total = sum(_MASS if link.mass is None else max(0.0, link.mass) for link in group.links)
        if total > MASS_MAX:
            self._xml.note(f"model '{name}': weighs {total:g} kg; it gets {MASS_MAX:g} kg")
        if total > 0.0:
            return min(total, MASS_MAX)
        guessed = estimated_inertial([part for link in group.links for part in link.solid])
        mass = _MASS if guessed is None else min(guessed.mass, MASS_MAX)
        self._xml.note(f"model '{name}': has no mass; it gets {mass:.3g} kg, by its shapes")
        return mass
