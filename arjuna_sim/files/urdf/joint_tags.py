"""Reading a URDF's joints."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Collection
from xml.etree.ElementTree import Element  # types only; parsing is defusedxml's

import numpy as np

from arjuna_core.errors import nearest
from arjuna_core.pose3 import Pose3
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.joints import JOINT_KINDS, Joint, Mimic
from arjuna_sim.model.notes import NoteKind

_LOOSE = ("floating", "planar")
_UNLIMITED = 100.0 * math.pi  # a revolute joint that may turn so far has no stop [rad]
_FACTOR_MAX = 1e6
_READ = ("origin", "parent", "child", "axis", "limit", "mimic", "dynamics")


def read_origin(xml: XmlFile, element: Element, place: str) -> Pose3:
    """Return the pose that an element's `<origin>` gives it.

    Raises:
        RobotError: It is no pose, or too far.
    """
    origin = element.find("origin")
    if origin is None:
        return Pose3()
    xyz = xml.position(origin.get("xyz", "0 0 0"), f"{place} origin xyz")
    return Pose3.from_rpy(xyz, xml.numbers(origin.get("rpy", "0 0 0"), 3, f"{place} origin rpy"))


def read_joint(xml: XmlFile, element: Element, links: Collection[str]) -> Joint:
    """Read a joint.

    Args:
        xml: The file.
        element: The `<joint>`.
        links: Names of the links there are.

    Raises:
        RobotError: Something is missing, unknown or invalid.
    """
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
    for tag in sorted({child.tag for child in element} - set(_READ)):
        xml.note(f"joint <{tag}>: not simulated", NoteKind.IGNORED)
    pose = read_origin(xml, element, place)
    if kind == "fixed":
        return Joint(name, kind, ends[0], ends[1], pose)
    if kind in _LOOSE:
        xml.note(f"{place}: moves freely as a {kind} joint; its position is not published")
    limits = _limits(xml, element, place) if kind in ("revolute", "prismatic") else None
    if kind == "revolute" and limits is not None and limits[1] - limits[0] > _UNLIMITED:
        kind, limits = "continuous", None
    dynamics = element.find("dynamics")
    damping, friction = (
        0.0 if dynamics is None else _at_least_zero(xml, dynamics, key, place)
        for key in ("damping", "friction")
    )
    axis, mimic = _axis(xml, element, place), _mimic(xml, element, place)
    speed = _max_speed(element)
    return Joint(name, kind, ends[0], ends[1], pose, axis, limits, mimic, damping, friction, speed)


def check_mimics(xml: XmlFile, joints: dict[str, Joint]) -> dict[str, Joint]:
    """Return joints of which none follows one that does not exist; that is noted.

    Raises:
        RobotError: A joint follows one that does not move, or itself.
    """
    joints = {name: _free_if_alone(xml, joint, joints) for name, joint in joints.items()}
    for joint in joints.values():
        place, followed, steps = f"joint '{joint.name}' mimic", joint, 0
        while followed.mimic is not None:
            followed, steps = joints[followed.mimic.joint], steps + 1
            if steps > len(joints):
                raise xml.fail(place, "the joints follow each other in a circle")
        if joint.mimic is not None and not (joint.has_position and followed.has_position):
            raise xml.fail(place, "only joints with one position can follow each other")
    return joints


def _free_if_alone(xml: XmlFile, joint: Joint, joints: dict[str, Joint]) -> Joint:
    """Return a joint, without what it follows where that does not exist."""
    if joint.mimic is None or joint.mimic.joint in joints:
        return joint
    name = joint.mimic.joint
    problem = f"joint '{name}' does not exist; {nearest(name, joints)}; it moves freely"
    xml.note(f"joint '{joint.name}' mimic: {problem}", NoteKind.MISSING)
    return dataclasses.replace(joint, mimic=None)


def _axis(xml: XmlFile, element: Element, place: str) -> tuple[float, float, float]:
    axis_element = element.find("axis")
    text = "1 0 0" if axis_element is None else xml.attribute(axis_element, "xyz", place)
    axis = np.array(xml.numbers(text, 3, f"{place} axis"))
    length = math.hypot(*axis.tolist())
    if not 0.0 < length < math.inf:
        raise xml.fail(place, "axis must not be zero")
    axis /= length
    return float(axis[0]), float(axis[1]), float(axis[2])


def _limits(xml: XmlFile, element: Element, place: str) -> tuple[float, float]:
    limit = xml.child(element, "limit", place)
    lower, upper = (xml.attribute_number(limit, key, "0", place) for key in ("lower", "upper"))
    if lower > upper:
        raise xml.fail(place, f"limit lower {lower} is above upper {upper}")
    return lower, upper


def _max_speed(element: Element) -> float:
    """Return a joint's greatest speed; what is no number above 0, as exporters write, is none."""
    limit = element.find("limit")
    try:
        speed = 0.0 if limit is None else float(limit.get("velocity", "0"))
    except ValueError:
        return 0.0
    return speed if 0.0 < speed < math.inf else 0.0


def _mimic(xml: XmlFile, element: Element, place: str) -> Mimic | None:
    mimic = element.find("mimic")
    if mimic is None:
        return None
    place = f"{place} mimic"
    multiplier = xml.attribute_number(mimic, "multiplier", "1", place)
    offset = xml.attribute_number(mimic, "offset", "0", place)
    if max(abs(multiplier), abs(offset)) > _FACTOR_MAX:
        raise xml.fail(place, f"multiplier and offset may reach {_FACTOR_MAX:g}")
    return Mimic(xml.attribute(mimic, "joint", place), multiplier, offset)


def _at_least_zero(xml: XmlFile, dynamics: Element, name: str, place: str) -> float:
    number = xml.attribute_number(dynamics, name, "0", place)
    if not 0.0 <= number <= _FACTOR_MAX:
        raise xml.fail(f"{place} {name}", f"is {number:g}; valid: 0 to {_FACTOR_MAX:g}")
    return number
