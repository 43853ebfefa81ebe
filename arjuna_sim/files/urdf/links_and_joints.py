"""Reading a URDF: links, joints and shapes as plain values.

Ours, not yourdfpy: it imports trimesh (0.8 s or more), and checks neither numbers nor the tree, so
that all that follows here would stay; of 130 lines it would save the reading of 20 attributes.
"""

from __future__ import annotations

from collections.abc import Collection
from xml.etree.ElementTree import Element  # types only; parsing is defusedxml's

import numpy as np

from arjuna_core.errors import RobotError, nearest
from arjuna_core.pose3 import Pose3
from arjuna_sim.files.meshes import mesh_shape
from arjuna_sim.files.pictures import dressed
from arjuna_sim.files.robots.rules import (
    check_mimics,
    checked_joint,
    inertial_of,
    limit_of,
    root_of,
)
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.geometry.shapes import GREY, Inertial, Kind, Part, Shape
from arjuna_sim.model.notes import NoteKind
from arjuna_sim.model.robot import ANCHOR
from arjuna_sim.model.urdf import JOINT_KINDS, Joint, Link, Mimic, Urdf

_READ = ("link", "joint", "material", "gazebo", "transmission", "ros2_control")
_READ_OF_JOINT = ("origin", "parent", "child", "axis", "limit", "mimic", "dynamics")
_READ_OF_PART = ("origin", "geometry", "material", "verbose")
_LINKS_MAX = 2000
_SHAPES = {
    "box": ("size",),
    "cylinder": ("radius", "length"),
    "sphere": ("radius",),
    "capsule": ("radius", "length"),
}


def read_urdf(xml: XmlFile) -> Urdf:
    """Read links and joints of a file with the root `<robot>`.

    Raises:
        RobotError: Something is missing, not finite, not physical or no tree.
    """
    colours = _colours(xml)
    links: dict[str, Link] = {}
    for tag in sorted({element.tag for element in xml.root} - set(_READ)):
        xml.note(f"<{tag}>: not simulated", NoteKind.IGNORED)
    if len(xml.root) > _LINKS_MAX * 4 or len(xml.root.findall("link")) > _LINKS_MAX:
        raise RobotError(xml.path, f"has too many parts; valid: up to {_LINKS_MAX} links")
    _note_unread(xml)
    for element in xml.root.findall("link"):
        link = _link(xml, element, colours)
        if link.name in links:
            raise xml.fail(f"link '{link.name}'", "is there twice; each name is valid once")
        links[link.name] = link
    joints: dict[str, Joint] = {}
    for element in xml.root.findall("joint"):
        joint = read_joint(xml, element, links)
        if joint.name in joints:
            raise xml.fail(f"joint '{joint.name}'", "is there twice; each name is valid once")
        joints[joint.name] = joint
    joints = check_mimics(xml, joints)
    _set_free(links, joints)
    root, name = root_of(xml, links, joints), xml.root.get("name", "robot")
    return Urdf(xml.path, name, xml.text.decode("utf-8", "replace"), root, links, joints)


def _note_unread(xml: XmlFile) -> None:
    """Note tags of links and of their shapes that no URDF has, as those of SDF."""
    unread: dict[str, list[str]] = {}
    for link in xml.root.findall("link"):
        name = link.get("name", "?")
        for child in link:
            if child.tag not in ("inertial", "visual", "collision"):
                unread.setdefault(f"<{child.tag}>", []).append(name)
            for inner in child if child.tag != "inertial" else ():
                if inner.tag not in _READ_OF_PART:
                    unread.setdefault(f"<{child.tag}><{inner.tag}>", []).append(name)
    for tag, names in unread.items():
        first, where = names[0], ", ".join(dict.fromkeys(names))
        remedy = f"<gazebo reference='{first}'> holds Gazebo's"
        if tag in ("<origin>", "<pose>"):
            remedy = "the <origin> of a link's joint places it"
        text = f"link {tag} (at {where}): no tag of a URDF, and left out, as Gazebo does; {remedy}"
        xml.note(text, NoteKind.IGNORED)


def _set_free(links: dict[str, Link], joints: dict[str, Joint]) -> None:
    """Drop a world in which the robot floats, as Gazebo does: it is free as without one."""
    held = [joint for joint in joints.values() if joint.parent == ANCHOR]
    if len(held) == 1 and held[0].kind == "floating" and ANCHOR in links:
        del links[ANCHOR], joints[held[0].name]


def read_origin(xml: XmlFile, element: Element, label: str) -> Pose3:
    """Return the pose of an element's `<origin>`.

    Raises:
        RobotError: It is no pose, or too far.
    """
    origin = element.find("origin")
    if origin is None:
        return Pose3()
    xyz = xml.position(origin.get("xyz", "0 0 0"), f"{label} origin xyz")
    return Pose3.from_rpy(xyz, xml.numbers(origin.get("rpy", "0 0 0"), 3, f"{label} origin rpy"))


def _colours(xml: XmlFile) -> dict[str, tuple[float, ...]]:
    """Return the colours by name; a visual's own that is none leaves it grey, as in urdfdom."""
    result, shared = {}, xml.root.findall("material")
    for element in xml.root.iter("material"):
        color = element.find("color")
        if color is not None:
            label = f"material '{element.get('name', '')}'"
            try:
                text = xml.attribute(color, "rgba", label)
                result[element.get("name", "")] = xml.numbers(text, 4, label)
            except RobotError as error:
                if element in shared:
                    raise
                xml.note(f"{error.location}: {error.problem}; it is left out", NoteKind.BROKEN)
    return result


def _link(xml: XmlFile, element: Element, colours: dict[str, tuple[float, ...]]) -> Link:
    name = xml.attribute(element, "name", "a link")
    label = f"link '{name}'"
    parts: dict[str, list[Part]] = {"collision": [], "visual": []}
    for tag, found in parts.items():
        for child in element.findall(tag):
            shape = (_look if tag == "visual" else _shape)(xml, child, f"{label} {tag}")
            if shape is not None:
                material = child.find("material")
                colour = GREY if material is None else colours.get(material.get("name", ""), GREY)
                part = Part(shape, read_origin(xml, child, f"{label} {tag}"), colour)
                found += dressed(xml, part, child, f"{label} {tag}")
    shapes = tuple(parts["collision"] or parts["visual"])
    inertial = read_inertial(xml, element, label, shapes)
    return Link(name, inertial, tuple(parts["collision"]), tuple(parts["visual"]))


def _look(xml: XmlFile, element: Element, label: str) -> Shape | None:
    try:
        return _shape(xml, element, label)
    except RobotError as error:
        xml.note(f"{error.location}: {error.problem}; it is left out", NoteKind.BROKEN, "visual")
        return None


def _shape(xml: XmlFile, element: Element, label: str) -> Shape | None:
    """Read a shape; None (and a note) for a mesh that is not simulated, or a shape of no size."""
    geometry = xml.child(element, "geometry", label)
    if len(geometry) != 1:
        raise xml.fail(label, f"<geometry> must hold one of {', '.join([*_SHAPES, 'mesh'])}")
    item = geometry[0]
    if item.tag == "mesh":
        name = xml.attribute(item, "filename", label)
        return mesh_shape(xml, name, item.get("scale", "1 1 1"), label)
    if item.tag not in _SHAPES:
        raise xml.fail(label, f"<{item.tag}> is unknown; {nearest(item.tag, [*_SHAPES, 'mesh'])}")
    size: tuple[float, ...] = ()
    for key in _SHAPES[item.tag]:
        count = 3 if key == "size" else 1
        text = xml.attribute(item, key, label)
        if 0.0 in xml.numbers(text, count, f"{label} {key}"):
            xml.note(f"{label}: a <{item.tag}> of no size is left out", NoteKind.BROKEN)
            return None
        size += xml.sizes(text, count, f"{label} {key}")
    if item.tag == "capsule":
        xml.note(f"{label}: the <capsule> is taken to be a cylinder")
        return Shape(Kind.CYLINDER, size)
    return Shape(Kind(item.tag), size)


def read_inertial(
    xml: XmlFile, link: Element, label: str, parts: tuple[Part, ...]
) -> Inertial | None:
    """Read a link's `<inertial>`; None where it has none, or one without mass.

    Raises:
        RobotError: The mass is missing, not finite, negative or too great.
    """
    element = link.find("inertial")
    if element is None:
        return None
    label, tensor = f"{label} inertial", element.find("inertia")
    mass = xml.attribute(xml.child(element, "mass", label), "value", label)
    given = None
    if tensor is not None:
        xx, yy, zz = (
            xml.numbers(xml.attribute(tensor, key, label), 1, f"{label} {key}")[0]
            for key in ("ixx", "iyy", "izz")
        )
        xy, xz, yz = (xml.attribute_number(tensor, k, "0", label) for k in ("ixy", "ixz", "iyz"))
        given = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    number = xml.numbers(mass, 1, f"{label} mass")[0]
    return inertial_of(xml, label, number, read_origin(xml, element, label), given, parts)


def read_joint(xml: XmlFile, element: Element, links: Collection[str]) -> Joint:
    """Read a joint between links that there are.

    Raises:
        RobotError: Something is missing, unknown or invalid.
    """
    name = xml.attribute(element, "name", "a joint")
    label = f"joint '{name}'"
    kind = xml.attribute(element, "type", label)
    if kind not in JOINT_KINDS:
        raise xml.fail(label, f"type '{kind}' is not simulated; valid: {', '.join(JOINT_KINDS)}")
    ends = []
    for tag in ("parent", "child"):
        link = xml.attribute(xml.child(element, tag, label), "link", label)
        if link not in links:
            raise xml.fail(label, f"{tag} link '{link}' does not exist; {nearest(link, links)}")
        ends.append(link)
    for tag in sorted({child.tag for child in element} - set(_READ_OF_JOINT)):
        xml.note(f"joint <{tag}>: not simulated", NoteKind.IGNORED)
    pose = read_origin(xml, element, label)
    if kind == "fixed":
        return Joint(name, kind, ends[0], ends[1], pose)
    limits, dynamics, limit = None, element.find("dynamics"), element.find("limit")
    if kind in ("revolute", "prismatic"):
        if limit is None:
            raise xml.fail(label, "lacks <limit>; valid: its lower and upper, or type 'continuous'")
        low, high = (xml.limit(limit.get(k), 0.0, f"{label} {k}") for k in ("lower", "upper"))
        limits = low, high
    damping, friction = (
        0.0 if dynamics is None else xml.attribute_number(dynamics, key, "0", label)
        for key in ("damping", "friction")
    )
    axis = element.find("axis")
    text = "1 0 0" if axis is None else xml.attribute(axis, "xyz", label)
    x, y, z = xml.numbers(text, 3, f"{label} axis")
    return checked_joint(
        xml,
        Joint(
            *(name, kind, ends[0], ends[1], pose, (x, y, z), limits),
            *(_mimic(xml, element, label), damping, friction),
            max_speed=0.0 if limit is None else limit_of(limit.get("velocity")),
            max_effort=0.0 if limit is None else limit_of(limit.get("effort")),
        ),
    )


def _mimic(xml: XmlFile, element: Element, label: str) -> Mimic | None:
    mimic = element.find("mimic")
    if mimic is None:
        return None
    label = f"{label} mimic"
    multiplier = xml.attribute_number(mimic, "multiplier", "1", label)
    offset = xml.attribute_number(mimic, "offset", "0", label)
    return Mimic(xml.attribute(mimic, "joint", label), multiplier, offset)
