"""A robot of an SDF model: its links, joints and tags as those of a URDF.

Links keep their names, those of nested models as `model/link`.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from xml.etree.ElementTree import Element  # types only; parsing is defusedxml's

import numpy as np

from arjuna_core.errors import RobotError
from arjuna_core.pose3 import ORIGIN, Pose3
from arjuna_sim.files.robots.completion import CASTER_FRICTION
from arjuna_sim.files.robots.rules import (
    check_mimics,
    checked_joint,
    inertial_of,
    limit_of,
    root_of,
)
from arjuna_sim.files.sdf.frames import raw_pose
from arjuna_sim.files.sdf.includes import Includes
from arjuna_sim.files.sdf.model_tags import SWINGING, WORLD, ModelReader, SdfJoint, SdfLink
from arjuna_sim.files.sdf.robots_in_world import cut_out
from arjuna_sim.files.sensor_tag import PluginTag, SensorTag, Tags
from arjuna_sim.files.tag_text import is_true
from arjuna_sim.files.xml_file import UNLIMITED, XmlFile
from arjuna_sim.model.geometry.shapes import (
    Inertial,
    Kind,
    Part,
    Shape,
    inertial_of_parts,
)
from arjuna_sim.model.notes import NoteKind
from arjuna_sim.model.urdf import Joint, Link, Mimic, Urdf


@dataclass
class _Robot:
    """The robot as far as it is read: links and their poses in the robot, joints and tags."""

    frames: set[str] = field(default_factory=set)
    poses: dict[str, Pose3] = field(default_factory=dict)
    links: dict[str, Link] = field(default_factory=dict)
    joints: dict[str, Joint] = field(default_factory=dict)
    tags: Tags = field(default_factory=Tags)

    def add(self, xml: XmlFile, link: Link, pose: Pose3) -> None:
        if link.name in self.links:
            raise xml.fail(f"link '{link.name}'", "is there twice")
        self.links[link.name], self.poses[link.name] = link, pose

    def connect(self, name: str, kind: str, parent: str, child: str) -> Joint:
        """Add a joint between two links, where they stand."""
        T_parent_child = self.poses[parent].inverse() @ self.poses[child]
        self.joints[name] = Joint(name, kind, parent, child, T_parent_child)
        return self.joints[name]

    @property
    def carried(self) -> dict[str, str]:
        """The parents of links that a joint carries."""
        return {joint.child: joint.parent for joint in self.joints.values()}


def read_sdf_robot(xml: XmlFile, name: str = "") -> tuple[Urdf, Tags]:
    """Return links, joints and tags of the robot of a parsed SDF file; its text is empty.

    Args:
        name: Of a model of the file's world, which is the robot; "" for the one that drives.

    Raises:
        RobotError: It holds no model, or a value is invalid.
    """
    includes, world = Includes(xml), xml.root.find("world")
    held = xml.root if world is None else world
    includes.expand(xml, held)
    robot = _Robot()
    if name or world is not None:
        robot.tags.T_world = cut_out(xml, includes, held, name)
    model = xml.root.find("model")
    if model is None:
        raise RobotError(xml.path, "is no robot: <sdf> must hold a <model>")
    reader = ModelReader(includes, is_robot=True)
    links, joints = reader.read(xml, model, ORIGIN, placed=True)
    turning = {_called(j.child): j.T_world for j in joints if j.kind in SWINGING}
    for link in links:
        _add_link(robot, link, turning.get(_called(link.name)))
    for name, base, pose in reader.frames:
        name, base = _called(name), _called(base)
        base = base if base in robot.links else next(iter(robot.links), "")
        if name not in robot.links and base:
            robot.frames.add(name)
            robot.add(xml, Link(name, None, (), ()), pose)
            robot.connect(f"{name}_frame", "fixed", base, name)
    robot.tags.items += [PluginTag(plugin, None) for plugin in reader.plugins]
    for joint in joints:
        _add_joint(robot, joint)
    _join_roots(xml, robot)
    found = check_mimics(xml, robot.joints)
    root = root_of(xml, robot.links, found)
    robot.tags.T_model = robot.poses[root]
    name = xml.attribute(model, "name", "a model")
    return Urdf(xml.path, name, "", root, robot.links, found), robot.tags


def _called(name: str) -> str:
    return name.strip().replace("::", "/")


def _add_link(robot: _Robot, link: SdfLink, about: Pose3 | None) -> None:
    """Add a link; one that a joint turns lies where its joint is, as URDF wants it."""
    xml, name = link.file, _called(link.name)
    label = f"link '{name}'"
    pose = link.T_world if about is None else Pose3(about.position, link.T_world.quaternion)
    T_own = pose.inverse() @ link.T_world
    parts = {
        tag: tuple(_robot_parts(xml, found, pose, f"{label} {tag}"))
        for tag, found in (("collision", link.solid), ("visual", link.drawn))
    }
    shapes = parts["collision"] or parts["visual"]
    inertial = _inertial(xml, link, T_own, label, shapes)
    robot.add(xml, Link(name, inertial, parts["collision"], parts["visual"]), pose)
    mu = _friction(link.solid)
    if mu is not None:
        robot.tags.friction[name] = mu
    if link.lights:
        xml.note(f"{label}: its <light> is not drawn", NoteKind.IGNORED)
    for element, T_world in link.sensors:
        T = pose.inverse() @ T_world if element.find("pose") is not None or about else ORIGIN
        robot.tags.items.append(SensorTag(xml, element, name, T))


def _friction(solid: list[Part]) -> float | None:
    """Return the friction of a link's lowest shape, where the ground is; of several, a said one."""
    lows = [
        (
            round(float(part.points()[:, 2].min()), 4),
            part.friction is None,
            i,
        )
        for i, part in enumerate(solid)
        if part.shape.kind is not Kind.PLANE
    ]
    return solid[min(lows)[2]].friction if lows else None


def _robot_parts(xml: XmlFile, parts: list[Part], pose: Pose3, label: str) -> Iterator[Part]:
    """Yield parts of the world as those of a link; what is ground is left out with a note."""
    for part in parts:
        shape = part.shape
        if shape.kind in (Kind.PLANE, Kind.TERRAIN):
            problem = f"<{shape.kind.value}> is left out of a robot"
            xml.note(f"{label}: {problem}", NoteKind.UNSUPPORTED)
            continue
        if shape.kind is Kind.CAPSULE:
            xml.note(f"{label}: the <capsule> is taken to be a cylinder")
            shape = Shape(Kind.CYLINDER, shape.size)
        yield dataclasses.replace(part, shape=shape, pose=pose.inverse() @ part.pose, friction=None)


def _inertial(
    xml: XmlFile, link: SdfLink, T_own: Pose3, label: str, parts: tuple[Part, ...]
) -> Inertial | None:
    """Read an `<inertial>` of a link whose own frame is at a pose; None for no mass."""
    inertial, label = link.element.find("inertial"), f"{label} inertial"
    if inertial is not None and is_true(inertial.get("auto")) and link.mass is not None:
        return inertial_of_parts(parts, link.mass)
    if inertial is None or link.mass is None:
        return None
    mass, tensor = link.mass, inertial.find("inertia")
    given = None
    if tensor is not None:
        keys = ("ixx", "ixy", "ixz", "ixy", "iyy", "iyz", "ixz", "iyz", "izz")
        given = np.array([xml.number(tensor, key, 0.0, label) for key in keys]).reshape(3, 3)
    pose = T_own @ raw_pose(xml, inertial, label)
    return inertial_of(xml, label, mass, pose, given, parts)


def _add_joint(robot: _Robot, joint: SdfJoint) -> None:
    xml, element = joint.file, joint.element
    name = _called(joint.name)
    label = f"joint '{name}'"
    kind = xml.attribute(element, "type", label)
    parent, child = _called(joint.parent), _called(joint.child)
    if parent == WORLD and WORLD not in robot.links:
        robot.add(xml, Link(WORLD, None, (), ()), ORIGIN)
    for end in (parent, child):
        if end.rpartition("/")[0] in robot.frames and end not in robot.links:
            # The frame stands for an include that was left out.
            xml.note(f"{label}: is left out, as '{end}' is", NoteKind.MISSING)
            return
        if end not in robot.links:
            raise xml.fail(label, f"link '{end}' does not exist")
    if name in robot.joints:
        raise xml.fail(label, "is there twice")
    if child in robot.carried:
        xml.note(f"{label}: closes a loop of links, so it is left out", NoteKind.UNSUPPORTED)
        return
    if kind == "ball" and _is_ball(robot, child, joint.T_world.position):
        robot.tags.friction[child] = CASTER_FRICTION  # it rolls, whatever its surface
    elif kind not in (*SWINGING, "fixed"):
        xml.note(f"{label}: type '{kind}' is held fast", NoteKind.UNSUPPORTED)
    if kind not in SWINGING:
        robot.connect(name, "fixed", parent, child)
        return
    fixed = robot.connect(name, kind, parent, child)
    T_child = robot.poses[child].inverse()
    robot.joints[name] = checked_joint(xml, _moving(joint, fixed, T_child, label))


def _is_ball(robot: _Robot, link: str, center: tuple[float, float, float]) -> bool:
    """Return whether all that a link touches with are spheres about a point of the world."""
    parts = robot.links[link].collisions
    return bool(parts) and all(
        part.shape.kind is Kind.SPHERE
        and math.dist((robot.poses[link] @ part.pose).position, center) < 1e-3  # [m]
        for part in parts
    )


def _moving(joint: SdfJoint, fixed: Joint, T_child: Pose3, label: str) -> Joint:
    """Return a joint with its axis, limits, damping and what it follows, in its child's frame."""
    xml = joint.file
    axis = xml.child(joint.element, "axis", label)
    numbers = xml.numbers(xml.child(axis, "xyz", label).text or "", 3, f"{label} <xyz>")
    x, y, z = ((T_child @ joint.T_axes[0]).rotation() @ numbers).tolist()
    low = xml.limit(axis.findtext("limit/lower"), -UNLIMITED, f"{label} <lower>")
    high = xml.limit(axis.findtext("limit/upper"), UNLIMITED, f"{label} <upper>")
    kind = fixed.kind
    if kind == "revolute" and low <= -UNLIMITED and high >= UNLIMITED:
        kind = "continuous"
    return dataclasses.replace(
        fixed,
        kind=kind,
        axis=(x, y, z),
        limits=None if kind == "continuous" else (low, high),
        mimic=_mimic(joint, axis, label),
        max_speed=limit_of(axis.findtext("limit/velocity")),
        max_effort=limit_of(axis.findtext("limit/effort")),
        **joint.dynamics(axis),
    )


def _mimic(joint: SdfJoint, axis: Element, label: str) -> Mimic | None:
    mimic = axis.find("mimic")
    if mimic is None:
        return None
    xml = joint.file
    multiplier = xml.number(mimic, "multiplier", 1.0, label)
    offset = xml.number(mimic, "offset", 0.0, label)
    offset -= multiplier * xml.number(mimic, "reference", 0.0, label)
    name = xml.attribute(mimic, "joint", f"{label} mimic")
    return Mimic(_called(joint.prefix + name), multiplier, offset)


def _join_roots(xml: XmlFile, robot: _Robot) -> None:
    """Fix links that no joint carries to the one that carries most."""
    carried = robot.carried
    roots = [name for name in robot.links if name not in carried]
    count = dict.fromkeys(roots, 0)
    for name in robot.links:
        for top in _above(carried, name):
            if top in count:
                count[top] += 1
    root = max(roots, key=lambda name: (name == WORLD, count[name]), default="")
    for other in roots:
        if other != root:
            xml.note(f"link '{other}': no joint carries it: it is fixed to '{root}'")
            robot.connect(f"{other}_fixed", "fixed", root, other)


def _above(carried: dict[str, str], name: str) -> Iterator[str]:
    """Yield a link and those that carry it, as far as they form no circle."""
    for _ in range(len(carried) + 1):
        yield name
        if name not in carried:
            return
        name = carried[name]
