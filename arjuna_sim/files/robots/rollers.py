"""Wheels whose file has their rollers one by one: each becomes a wheel that grips as they do."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from arjuna_core.pose3 import Pose3
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.geometry.shapes import Kind, Part, Shape, corners
from arjuna_sim.model.urdf import Urdf
from arjuna_sim.model.wheels import axis

_LEAST = 4  # rollers of a wheel


def rollers_of(urdf: Urdf, wheel: str) -> tuple[str, ...]:
    """Return the joints of the rollers that a wheel's joint carries; none for a plain wheel.

    They turn about other axes than the wheel, which lies: a base that turns carries wheels.
    Fixed joints may lie between: a hub in parts.
    """
    if urdf.joints[wheel].kind != "continuous":
        return ()
    turning = (joint for joint in urdf.joints.values() if joint.kind == "continuous")
    found = tuple(joint.name for joint in turning if _turns(urdf, joint.parent) == wheel)
    if len(found) < _LEAST or abs(float(axis(urdf, wheel)[2])) > 0.5:
        return ()
    own = axis(urdf, wheel)
    return found if all(abs(float(axis(urdf, name) @ own)) < 0.9 for name in found) else ()


def is_roller(urdf: Urdf, joint: str) -> bool:
    """Return whether a joint is that of a wheel's roller."""
    wheel = _turns(urdf, urdf.joints[joint].parent)
    return wheel is not None and joint in rollers_of(urdf, wheel)


def _turns(urdf: Urdf, link: str) -> str | None:
    """Return the joint that moves a link, past fixed ones; None where nothing does."""
    return next((joint.name for joint in urdf.above(link) if joint.kind != "fixed"), None)


def on_whole_wheels(xml: XmlFile, urdf: Urdf) -> tuple[Urdf, dict[str, tuple[float, float]]]:
    """Return a robot whose wheels with rollers are round, and how they grip, by link.

    A wheel grips along the axis of its lowest roller, and rolls across it.
    """
    links, grips = dict(urdf.links), dict[str, tuple[float, float]]()
    for wheel, joint in urdf.joints.items():
        rollers = rollers_of(urdf, wheel)
        solid = [name for name in rollers if urdf.links[urdf.joints[name].child].collisions]
        if len(solid) < _LEAST:
            continue
        rim = _rim(urdf, wheel, solid)
        links[joint.child] = dataclasses.replace(links[joint.child], collisions=(rim,))
        for name in rollers:
            child = urdf.joints[name].child
            links[child] = dataclasses.replace(links[child], collisions=())
        lowest = min(rollers, key=lambda name: urdf.T_root(urdf.joints[name].child).position[2])
        x, y, _ = axis(urdf, lowest).tolist()
        if (length := math.hypot(x, y)) > 0.0:
            grips[joint.child] = (x / length, y / length)
        xml.note(f"link '{joint.child}': rolls as one wheel that grips as its rollers do")
    return dataclasses.replace(urdf, links=links), grips


def _rim(urdf: Urdf, wheel: str, rollers: list[str]) -> Part:
    """Return a cylinder about a wheel's axis that reaches as far as its rollers."""
    joint = urdf.joints[wheel]
    along = np.array(joint.axis)
    T_wheel_root, radius, width = urdf.T_root(joint.child).inverse(), 0.0, 0.0
    for name in rollers:
        child = urdf.joints[name].child
        for part in urdf.links[child].collisions:
            T = T_wheel_root @ urdf.T_root(child) @ part.pose
            middle = np.array(T.position)
            out = float(np.linalg.norm(middle - along * float(middle @ along)))
            round_one = part.shape.kind in (Kind.CYLINDER, Kind.SPHERE)
            points = T.apply(corners(part.shape))
            across = np.linalg.norm(points - np.outer(points @ along, along), axis=1)
            reach = out + part.shape.size[0] if round_one else float(across.max())
            radius = max(radius, reach)
            width = max(width, 2.0 * float(np.abs(points @ along).max()))
    return Part(Shape(Kind.CYLINDER, (radius, width)), turned_to(along))


def turned_to(along: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> Pose3:
    """Return a pose whose z axis is along a unit vector."""
    x, y, z = along.tolist()
    pitch, yaw = math.atan2(math.hypot(x, y), z), math.atan2(y, x)
    return Pose3.from_rpy((0.0, 0.0, 0.0), (0.0, pitch, yaw))
