"""Standing up a robot that its file lays on its side, or turns away from +x."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from html import escape
from xml.etree.ElementTree import tostring  # parsing is defusedxml's

import numpy as np
from defusedxml.ElementTree import fromstring

from arjuna_core.arrays import Floats
from arjuna_core.pose3 import Pose3
from arjuna_sim.files.robots.guess import guess_sides
from arjuna_sim.files.robots.plugins import LEFT, RIGHT, Sides
from arjuna_sim.files.sensor_tag import Tags
from arjuna_sim.files.tag_text import text_of, texts
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.geometry.shapes import Kind
from arjuna_sim.model.urdf import Joint, Link, Urdf
from arjuna_sim.model.wheels import axis, center, radius_of

_ACROSS = 0.5  # least part of that line along y, or greatest along z: within 60 degrees
_UPRIGHT = 0.995  # least part of a root's z axis along its model's: within 6 degrees
_STANDS_OUT = 0.005  # from which one side counts as lower than another; files round to mm [m]
_NAMES = ("base_footprint", "base_upright", "base_standing")


def stand_up(xml: XmlFile, urdf: Urdf, tags: Tags) -> Urdf:
    """Give a robot whose wheels' axes do not lie across a new root that stands and faces ahead.

    So does one whose root leans in its SDF model.
    """
    rows = tags.T_model.rotation()
    if rows[2, 2] < _UPRIGHT:
        urdf = _turned(xml, urdf, rows, f"link '{urdf.root}' leans in its model")
    left, right = _named_sides(tags, urdf) or guess_sides(xml, urdf, tags.controlled)
    if not left or not right:
        return urdf
    across = _mean(urdf, left) - _mean(urdf, right)
    length = float(np.linalg.norm(across))
    if length < 1e-6 or abs(across[1]) > _ACROSS * length:
        return urdf
    across = across / length
    # The axis is within 26 degrees of the line to the other side.
    if abs(float(axis(urdf, left[0]) @ across)) < 0.9:
        return urdf
    up = _up(urdf, across, left + right)
    rows = np.array([np.cross(across, up), across, up])  # maps the old root's frame into the new
    return _turned(xml, urdf, rows, "its wheels do not turn across")


def without_frames(xml: XmlFile, urdf: Urdf, tags: Tags) -> Urdf:
    """Return a robot without roots that are frames in which it moves, as `odom` or `map`.

    A robot that its file fixes to its odometry's frame would stand still there.
    """
    named = {"map", "odom", *(text_of(plugin, "odometryframe") for plugin in tags.plugins)}
    while urdf.root in named:
        link = urdf.links[urdf.root]
        held = [joint for joint in urdf.joints.values() if joint.parent == urdf.root]
        if link.inertial or link.collisions or link.visuals or len(held) != 1:
            return urdf
        joint = held[0]
        if joint.has_position:
            return urdf
        problem = f"is a frame in which the robot moves: '{joint.child}' is the root in its place"
        xml.note(f"link '{urdf.root}': {problem}")
        tags.T_model = tags.T_model @ joint.T_parent_child
        urdf = dataclasses.replace(
            urdf,
            text=_without(urdf.text, urdf.root, joint.name),
            root=joint.child,
            links={name: each for name, each in urdf.links.items() if name != urdf.root},
            joints={name: each for name, each in urdf.joints.items() if name != joint.name},
        )
    return urdf


def _without(text: str, link: str, joint: str) -> str:
    """Return a URDF without a link and a joint; "" for none."""
    if not text:
        return text
    root = fromstring(text)
    for child in (*root.findall("link"), *root.findall("joint")):
        if (child.tag, child.get("name", "").strip()) in (("link", link), ("joint", joint)):
            root.remove(child)
    return tostring(root, encoding="unicode")


def _turned(xml: XmlFile, urdf: Urdf, rows: Floats, reason: str) -> Urdf:
    """Return a robot below a new root, into whose frame `rows` turn that of the old one."""
    name = next((n for n in _NAMES if n not in urdf.links), None)
    if name is None:
        return urdf
    rpy = " ".join(f"{angle:.9g}" for angle in _rpy(rows))
    xml.note(f"{reason}: the new root '{name}' carries it turned by {rpy}")
    return _with_root(urdf, name, rpy)


def _named_sides(tags: Tags, urdf: Urdf) -> Sides | None:
    for plugin in tags.plugins:
        left, right = tuple(texts(plugin, *LEFT)), tuple(texts(plugin, *RIGHT))
        if left and right and all(name in urdf.joints for name in left + right):
            return left, right
    return None


def _mean(urdf: Urdf, names: Iterable[str]) -> Floats:
    mean: Floats = np.mean([center(urdf, name) for name in names], axis=0)
    return mean


def _up(urdf: Urdf, left: Floats, wheels: tuple[str, ...]) -> Floats:
    """Return the direction that is up: z, or of a robot on its side the one its wheels stand on."""
    if abs(left[2]) < _ACROSS:
        up = np.array([0.0, 0.0, 1.0]) - left[2] * left
        upright: Floats = up / float(np.linalg.norm(up))
        return upright
    # Y is up in the CAD programs that export such robots; others must keep the weight lower.
    directions = [
        np.array(direction)
        for direction in ((0.0, 1.0, 0.0), (0.0, -1.0, 0.0), (1.0, 0, 0), (-1.0, 0, 0))
    ]
    directions = [direction - float(direction @ left) * left for direction in directions]
    weight = _weight(urdf) - _mean(urdf, wheels)
    best, least = directions[0], np.inf
    for up in (direction / float(np.linalg.norm(direction)) for direction in directions):
        ground = min(float(center(urdf, n) @ up) - radius_of(urdf, n) for n in wheels)
        stands = _lowest(urdf, up, wheels) > ground - _STANDS_OUT
        if stands and float(weight @ up) < least - _STANDS_OUT:
            best, least = up, float(weight @ up)
    return best


def _weight(urdf: Urdf) -> Floats:
    """Return the centre of mass in the root's frame [m]."""
    total, moment = 1e-9, np.zeros(3)
    for link in urdf.links.values():
        if link.inertial is not None:
            center = urdf.T_root(link.name).apply(np.array([link.inertial.center]))[0]
            total, moment = total + link.inertial.mass, moment + link.inertial.mass * center
    return moment / total


def _lowest(urdf: Urdf, up: Floats, wheels: tuple[str, ...]) -> float:
    """Return how low the robot reaches apart from its wheels [m]."""
    children = {urdf.joints[name].child for name in wheels}
    heights = [np.inf]
    for link in urdf.links.values():
        for part in link.collisions or link.visuals:
            if link.name not in children and part.shape.kind is not Kind.PLANE:
                heights.append(float((part.points(urdf.T_root(link.name)) @ up).min()))
    return min(heights)


def _rpy(rows: Floats) -> tuple[float, float, float]:
    """Return fixed-axis angles of a rotation matrix [rad]."""
    pitch = float(np.arcsin(np.clip(-rows[2, 0], -1.0, 1.0)))
    if abs(rows[2, 0]) > 1.0 - 1e-9:
        return 0.0, pitch, float(np.arctan2(-rows[0, 1], rows[1, 1]))
    roll = float(np.arctan2(rows[2, 1], rows[2, 2]))
    return roll, pitch, float(np.arctan2(rows[1, 0], rows[0, 0]))


def _with_root(urdf: Urdf, name: str, rpy: str) -> Urdf:
    """Return a robot below a new root, turned by angles, in its values and in its text."""
    turn = Pose3.from_rpy((0.0, 0.0, 0.0), tuple(map(float, rpy.split())))
    joint = Joint(f"{name}_joint", "fixed", name, urdf.root, turn)
    before, _, after = urdf.text.rpartition("</robot>")
    link = f'<link name="{name}"/><joint name="{joint.name}" type="fixed"><parent link="{name}"/>'
    link += f'<child link="{escape(urdf.root)}"/><origin xyz="0 0 0" rpy="{rpy}"/></joint>'
    return dataclasses.replace(
        urdf,
        text=f"{before}{link}</robot>{after}" if urdf.text else "",
        root=name,
        links={**urdf.links, name: Link(name, None, (), ())},
        joints={**urdf.joints, joint.name: joint},
    )
