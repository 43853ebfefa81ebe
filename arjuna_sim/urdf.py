"""Reading a URDF: links, joints and shapes as plain values."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path
from xml.etree.ElementTree import Element  # types only; parsing is defusedxml's

import numpy as np
from numpy.typing import NDArray

from arjuna_core.errors import RobotError, nearest
from arjuna_sim.mesh_shape import mesh_shape
from arjuna_sim.pose3 import Pose3
from arjuna_sim.shapes import GREY, Kind, Part, Shape
from arjuna_sim.xml_file import XmlFile

JOINT_KINDS = ("fixed", "continuous", "revolute", "prismatic")
_SHAPES = {"box": ("size",), "cylinder": ("radius", "length"), "sphere": ("radius",)}


@dataclass(frozen=True)
class Inertial:
    """Mass properties of a link.

    Attributes:
        mass: [kg].
        center: Centre of mass in the link's frame [m].
        inertia: About the centre, along the link's axes, `(3, 3) float64` [kg m^2].
    """

    mass: float
    center: tuple[float, float, float]
    inertia: NDArray[np.float64]


@dataclass(frozen=True)
class Link:
    """A rigid part of the robot; shapes lie in its frame."""

    name: str
    inertial: Inertial | None
    collisions: tuple[Part, ...]
    visuals: tuple[Part, ...]


@dataclass(frozen=True)
class Joint:
    """A connection of two links.

    Attributes:
        name: Its name.
        kind: One of `JOINT_KINDS`.
        parent: The link it hangs on.
        child: The link it carries.
        T_parent_child: The child's pose in the parent's frame at joint position 0.
        axis: Axis in the child's frame, a unit vector.
        limits: Least and greatest position [rad or m], None where unlimited.
    """

    name: str
    kind: str
    parent: str
    child: str
    T_parent_child: Pose3
    axis: tuple[float, float, float] = (1.0, 0.0, 0.0)
    limits: tuple[float, float] | None = None

    def at(self, position: float) -> Pose3:
        """Return the child's pose in the parent's frame at a joint position [rad or m]."""
        x, y, z = self.axis
        if self.kind == "prismatic":
            return self.T_parent_child @ Pose3((x * position, y * position, z * position))
        c, s = math.cos(position / 2), math.sin(position / 2)
        return self.T_parent_child @ Pose3(quaternion=(c, s * x, s * y, s * z))


@dataclass(frozen=True)
class Urdf:
    """A robot description as it was read.

    Attributes:
        path: The file.
        name: The robot's name.
        text: The URDF itself, for `/robot_description`.
        root: Name of the link that no joint carries.
        links: By name, in the file's order.
        joints: By name, in the file's order.
    """

    path: Path
    name: str
    text: str
    root: str
    links: dict[str, Link] = field(default_factory=dict)
    joints: dict[str, Joint] = field(default_factory=dict)

    def T_root(self, link: str) -> Pose3:
        """Return a link's pose in the root's frame, all joints at position 0."""
        carrier = {joint.child: joint for joint in self.joints.values()}
        T = Pose3()
        while link in carrier:
            T = carrier[link].T_parent_child @ T
            link = carrier[link].parent
        return T


def read_urdf(xml: XmlFile) -> Urdf:
    """Read links and joints.

    Args:
        xml: The file with the root `<robot>`.

    Raises:
        RobotError: Something is missing, not finite, not physical or no tree.
    """
    colours = _colours(xml)
    links = {}
    for element in xml.root.findall("link"):
        link = _link(xml, element, colours)
        if link.name in links:
            raise xml.fail(f"link '{link.name}'", "is there twice")
        links[link.name] = link
    joints = {}
    for element in xml.root.findall("joint"):
        joint = _joint(xml, element, links)
        if joint.name in joints:
            raise xml.fail(f"joint '{joint.name}'", "is there twice")
        joints[joint.name] = joint
    root = _root(xml, links, joints)
    name = xml.root.get("name", "robot")
    return Urdf(xml.path, name, xml.text.decode("utf-8", "replace"), root, links, joints)


def _colours(xml: XmlFile) -> dict[str, tuple[float, ...]]:
    result = {}
    for element in xml.root.iter("material"):
        color = element.find("color")
        if color is not None:
            place = f"material '{element.get('name', '')}'"
            text = xml.attribute(color, "rgba", place)
            result[element.get("name", "")] = xml.numbers(text, 4, place)
    return result


def _link(xml: XmlFile, element: Element, colours: dict[str, tuple[float, ...]]) -> Link:
    name = xml.attribute(element, "name", "a link")
    place = f"link '{name}'"
    parts: dict[str, list[Part]] = {"collision": [], "visual": []}
    for tag, found in parts.items():
        for child in element.findall(tag):
            shape = _shape(xml, child, f"{place} {tag}")
            if shape is not None:
                material = child.find("material")
                colour = GREY if material is None else colours.get(material.get("name", ""), GREY)
                found.append(Part(shape, _origin(xml, child, f"{place} {tag}"), colour))
    inertial = _inertial(xml, element, place)
    return Link(name, inertial, tuple(parts["collision"]), tuple(parts["visual"]))


def _origin(xml: XmlFile, element: Element, place: str) -> Pose3:
    origin = element.find("origin")
    if origin is None:
        return Pose3()
    xyz = xml.numbers(origin.get("xyz", "0 0 0"), 3, f"{place} origin xyz")
    return Pose3.from_rpy(xyz, xml.numbers(origin.get("rpy", "0 0 0"), 3, f"{place} origin rpy"))


def _inertial(xml: XmlFile, link: Element, place: str) -> Inertial | None:
    element = link.find("inertial")
    if element is None:
        return None
    place = f"{place} inertial"
    mass_text = xml.attribute(xml.child(element, "mass", place), "value", place)
    mass = xml.positive(mass_text, 1, f"{place} mass")[0]
    tensor = xml.child(element, "inertia", place)
    xx, yy, zz = (
        xml.positive(xml.attribute(tensor, key, place), 1, f"{place} {key}")[0]
        for key in ("ixx", "iyy", "izz")
    )
    xy, xz, yz = (
        xml.numbers(tensor.get(key, "0"), 1, f"{place} {key}")[0] for key in ("ixy", "ixz", "iyz")
    )
    origin = _origin(xml, element, place)
    turn = origin.rotation()
    inertia = turn @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ turn.T
    if np.linalg.eigvalsh(inertia)[0] <= 0.0:
        raise xml.fail(place, "inertia is not positive definite")
    return Inertial(mass, origin.position, inertia)


def _shape(xml: XmlFile, element: Element, place: str) -> Shape | None:
    """Read a shape; None (and a note) for a mesh of a format that is not simulated."""
    geometry = xml.child(element, "geometry", place)
    if len(geometry) != 1:
        raise xml.fail(place, f"<geometry> must hold one of {', '.join([*_SHAPES, 'mesh'])}")
    item = geometry[0]
    if item.tag == "mesh":
        name = xml.attribute(item, "filename", place)
        return mesh_shape(xml, name, item.get("scale", "1 1 1"), place)
    if item.tag not in _SHAPES:
        raise xml.fail(place, f"<{item.tag}> is unknown; {nearest(item.tag, [*_SHAPES, 'mesh'])}")
    size: tuple[float, ...] = ()
    for key in _SHAPES[item.tag]:
        count = 3 if key == "size" else 1
        size += xml.positive(xml.attribute(item, key, place), count, f"{place} {key}")
    return Shape(Kind(item.tag), size)


def _joint(xml: XmlFile, element: Element, links: dict[str, Link]) -> Joint:
    name = xml.attribute(element, "name", "a joint")
    place = f"joint '{name}'"
    kind = xml.attribute(element, "type", place)
    if kind not in JOINT_KINDS:
        raise xml.fail(place, f"type '{kind}' is not simulated; valid: {', '.join(JOINT_KINDS)}")
    ends = []
    for tag in ("parent", "child"):
        link = xml.attribute(xml.child(element, tag, place), "link", place)
        if link not in links:
            raise xml.fail(place, f"{tag} link '{link}' does not exist; {nearest(link, links)}")
        ends.append(link)
    pose = _origin(xml, element, place)
    if kind == "fixed":
        return Joint(name, kind, ends[0], ends[1], pose)
    axis_element, limits = element.find("axis"), None
    text = "1 0 0" if axis_element is None else xml.attribute(axis_element, "xyz", place)
    axis = np.array(xml.numbers(text, 3, f"{place} axis"))
    if not np.linalg.norm(axis) > 0.0:
        raise xml.fail(place, "axis must not be zero")
    axis /= np.linalg.norm(axis)
    if kind != "continuous":
        limits = _limits(xml, element, place)
    unit = (float(axis[0]), float(axis[1]), float(axis[2]))
    return Joint(name, kind, ends[0], ends[1], pose, unit, limits)


def _limits(xml: XmlFile, element: Element, place: str) -> tuple[float, float]:
    limit = xml.child(element, "limit", place)
    lower, upper = (
        xml.numbers(limit.get(key, "0"), 1, f"{place} {key}")[0] for key in ("lower", "upper")
    )
    if lower > upper:
        raise xml.fail(place, f"limit lower {lower} is above upper {upper}")
    return lower, upper


def _root(xml: XmlFile, links: dict[str, Link], joints: dict[str, Joint]) -> str:
    """Return the one root of the tree that the joints span."""
    if not links:
        raise RobotError(xml.path, "has no links")
    parents: dict[str, str] = {}
    for joint in joints.values():
        if joint.child in parents:
            raise xml.fail(f"joint '{joint.name}'", f"link '{joint.child}' has two parents")
        parents[joint.child] = joint.parent
    roots = [name for name in links if name not in parents]
    if len(roots) != 1:
        found = ", ".join(roots) or "none, the joints form a loop"
        raise RobotError(xml.path, f"must have one root link; it has: {found}")
    for start in links:
        link, steps = start, 0
        while link in parents:
            link, steps = parents[link], steps + 1
            if steps > len(links):
                raise xml.fail(f"link '{start}'", "the joints form a loop")
    return roots[0]
