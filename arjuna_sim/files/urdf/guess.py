"""Finding a robot's wheels where its file names none, and standing up one that lies on its side."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement, tostring  # nothing is parsed here
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import NDArray

from arjuna_core.errors import InputFileError
from arjuna_sim.files.urdf.gazebo_text import texts
from arjuna_sim.files.urdf.links_and_joints import read_urdf
from arjuna_sim.files.urdf.plugins import LEFT, RIGHT, TORQUE
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.settings import DriveSettings
from arjuna_sim.model.shapes import Kind, corners
from arjuna_sim.model.urdf import Urdf
from arjuna_sim.model.wheels import axis, center, effective_track, radius_of, wheel_radius
from arjuna_sim.model.wheels import wheel_separation as separation_of

_PASSIVE = re.compile(r"cast[eo]r|swivel|steer|idler|roller|gripper|finger|arm_|pan_|tilt", re.I)
_WHEEL = re.compile(r"wheel|tire|tyre|track|rueda|roue|rad_", re.I)
_LEFT = re.compile(r"left|(^|_)(l|fl|rl|bl|ml|lf|lr|lb)(_|\d|$)", re.I)
_RIGHT = re.compile(r"right|(^|_)(r|fr|rr|br|mr|rf|rb)(_|\d|$)", re.I)
_PARALLEL = 0.9
_ACROSS = 0.5
_TOLERANCE = 0.02  # between a left wheel and its partner [m]
_STANDS_OUT = 0.005  # from which one side counts as lower than another [m]
_NAMES = ("base_footprint", "base_upright", "base_standing")
NO_DRIVE = DriveSettings((), (), 1.0, 1.0, TORQUE, 1.0, 1.0)
"""Of a robot that has no wheels."""

Sides = tuple[tuple[str, ...], tuple[str, ...]]


def guess_drive(xml: XmlFile, urdf: Urdf) -> DriveSettings:
    """Return the drive of a robot without a drive plugin, by its wheels; `NO_DRIVE` without any."""
    left, right = guess_sides(xml, urdf)
    if not left or not right:
        xml.note("has no drive: neither a drive plugin nor wheels on both sides; it stands still")
        return NO_DRIVE
    radius, separation = wheel_radius(urdf, left + right), separation_of(urdf, left, right)
    if not radius > 0.0 or not separation > 0.0:
        raise xml.fail("drive", "the wheels' radius is unknown; <wheel_diameter> gives it")
    track = effective_track(urdf, left, right)
    torque = max(TORQUE, 2.0 * 9.81 * _mass(urdf) * radius / len(left + right))
    xml.note(
        f"no drive plugin: guessed are the wheels {', '.join(left)} (left) and {', '.join(right)}"
        f" (right), separation {separation:.4g} m, radius {radius:.4g} m"
    )
    return DriveSettings(left, right, separation, radius, torque, track, radius)


def snippet(source: Path, name: str, drive: DriveSettings) -> str:
    """Return a xacro file that adds a guessed drive to the robot it was guessed for.

    Args:
        source: The robot's file.
        name: The robot's name.
        drive: The guess.
    """
    joints = [f"      <left_joint>{name}</left_joint>" for name in drive.left]
    joints += [f"      <right_joint>{name}</right_joint>" for name in drive.right]
    return "\n".join(
        [
            '<?xml version="1.0"?>',
            f'<robot name={quoteattr(name)} xmlns:xacro="http://www.ros.org/wiki/xacro">',
            f"  <xacro:include filename={quoteattr(str(source.resolve()))}/>",
            "  <gazebo>",
            '    <plugin name="guessed_drive" filename="libgazebo_ros_diff_drive.so">',
            *joints,
            f"      <wheel_separation>{drive.separation:.6g}</wheel_separation>",
            f"      <wheel_diameter>{2.0 * drive.radius:.6g}</wheel_diameter>",
            f"      <max_wheel_torque>{drive.torque:.6g}</max_wheel_torque>",
            f"      <effective_track_width>{drive.effective_track:.6g}</effective_track_width>",
            f"      <effective_wheel_radius>{drive.effective_radius:.6g}</effective_wheel_radius>",
            "    </plugin>",
            "  </gazebo>",
            "</robot>",
            "",
        ]
    )


def guess_sides(xml: XmlFile, urdf: Urdf) -> Sides:
    """Return the joints of the left and right wheels, by names, axes and symmetry."""
    names = _candidates(urdf, set(_controlled(xml.root)))
    if not names:
        return (), ()
    left = _left(urdf, names)
    names = [n for n in names if abs(float(axis(urdf, n) @ left)) > _PARALLEL]
    along = {n: float(center(urdf, n) @ left) for n in names}
    middle = (max(along.values()) + min(along.values())) / 2
    sides = (
        [n for n in names if along[n] > middle + _TOLERANCE / 4],
        [n for n in names if along[n] < middle - _TOLERANCE / 4],
    )
    kept = [
        [n for n in side if any(_partners(urdf, n, m, left) for m in other)]
        for side, other in (sides, sides[::-1])
    ]
    for name in sorted({*sides[0], *sides[1]} - {*kept[0], *kept[1]}):
        xml.note(f"joint '{name}': turns freely: it has no partner on the other side")
    return tuple(kept[0]), tuple(kept[1])


def stand_up(xml: XmlFile, urdf: Urdf) -> Urdf:
    """Give a robot whose wheels' axes do not lie across a new root that stands and faces ahead."""
    left, right = _named_sides(xml.root, urdf) or guess_sides(xml, urdf)
    if not left or not right:
        return urdf
    across = _mean(urdf, left) - _mean(urdf, right)
    length = float(np.linalg.norm(across))
    if length < 1e-6 or abs(across[1]) > _ACROSS * length:
        return urdf
    across = across / length
    if abs(float(axis(urdf, left[0]) @ across)) < _PARALLEL:
        return urdf
    up = _up(urdf, across, left + right)
    rows = np.array([np.cross(across, up), across, up])  # maps the old root's frame into the new
    name = next((n for n in _NAMES if n not in urdf.links), None)
    if name is None:
        return urdf
    rpy = " ".join(f"{angle:.9g}" for angle in _rpy(rows))
    xml.note(f"its wheels do not turn across: the new root '{name}' carries it turned by {rpy}")
    _add_root(xml.root, urdf.root, name, rpy)
    xml.text = tostring(xml.root, encoding="utf-8")
    return read_urdf(xml)


def _candidates(urdf: Urdf, controlled: set[str]) -> list[str]:
    """Return the joints that may drive, the likeliest kind only."""
    names = [
        name
        for name, joint in urdf.joints.items()
        if joint.kind == "continuous"
        and joint.mimic is None
        and not _PASSIVE.search(f"{name} {joint.child}")
        and radius_of(urdf, name) > 0.0
    ]
    by_name = [n for n in names if _WHEEL.search(f"{n} {urdf.joints[n].child}")]
    by_control = [n for n in names if n in controlled]
    return next((group for group in (by_control, by_name, names) if len(group) > 1), [])


def _controlled(root: Element) -> Iterator[str]:
    """Yield the joints that a file hands to a velocity controller."""
    for transmission in root.iter("transmission"):
        for joint in transmission.iter("joint"):
            if any("Velocity" in text for text in texts(transmission, "hardwareinterface")):
                yield joint.get("name", "")
    for control in root.iter("ros2_control"):
        for joint in control.iter("joint"):
            if joint.find("command_interface[@name='velocity']") is not None:
                yield joint.get("name", "")


def _left(urdf: Urdf, names: list[str]) -> NDArray[np.float64]:
    """Return the unit vector along the wheels' axes that points to the robot's left."""
    line = axis(urdf, names[0])
    sums = [float(center(urdf, n) @ line) * _side_of(urdf, n) for n in names]
    sides = [_side_of(urdf, n) for n in names]
    if 1 in sides and -1 in sides and abs(sum(sums)) > 1e-6:
        return line if sum(sums) > 0.0 else -line
    # Without names it faces the way that turns it least: ahead +x, else +y.
    wanted = np.array([-1e-3, 1.0, -1e-6])
    return line if float(line @ wanted) >= 0.0 else -line


def _side_of(urdf: Urdf, name: str) -> int:
    """Return 1 for a name that says left, -1 for right, else 0."""
    text = (name, urdf.joints[name].child)
    is_left, is_right = (any(p.search(t) for t in text) for p in (_LEFT, _RIGHT))
    return int(is_left) - int(is_right)


def _partners(urdf: Urdf, name: str, other: str, left: NDArray[np.float64]) -> bool:
    """Tell whether two wheels are as large and stand opposite each other."""
    gap = center(urdf, name) - center(urdf, other)
    gap = gap - float(gap @ left) * left
    sizes = radius_of(urdf, name), radius_of(urdf, other)
    near = float(np.linalg.norm(gap)) < max(_TOLERANCE, 0.3 * sizes[0])
    return near and abs(sizes[0] - sizes[1]) < 0.1 * sizes[0]


def _named_sides(root: Element, urdf: Urdf) -> Sides | None:
    """Return the wheels that a plugin names."""
    for plugin in root.iterfind("gazebo/plugin"):
        left, right = tuple(texts(plugin, *LEFT)), tuple(texts(plugin, *RIGHT))
        if left and right and all(name in urdf.joints for name in left + right):
            return left, right
    return None


def _mean(urdf: Urdf, names: Iterable[str]) -> NDArray[np.float64]:
    mean: NDArray[np.float64] = np.mean([center(urdf, name) for name in names], axis=0)
    return mean


def _up(urdf: Urdf, left: NDArray[np.float64], wheels: tuple[str, ...]) -> NDArray[np.float64]:
    """Return the direction that is up: z, or of a robot on its side the one its wheels stand on."""
    if abs(left[2]) < _ACROSS:
        up = np.array([0.0, 0.0, 1.0]) - left[2] * left
        upright: NDArray[np.float64] = up / float(np.linalg.norm(up))
        return upright
    # Y is up in the CAD programs that export such robots; others must keep the weight lower.
    ways = [np.array(way) for way in ((0.0, 1.0, 0.0), (0.0, -1.0, 0.0), (1.0, 0, 0), (-1.0, 0, 0))]
    ways = [way - float(way @ left) * left for way in ways]
    weight = _weight(urdf) - _mean(urdf, wheels)
    best, least = ways[0], np.inf
    for up in (way / float(np.linalg.norm(way)) for way in ways):
        ground = min(float(center(urdf, n) @ up) - radius_of(urdf, n) for n in wheels)
        stands = _lowest(urdf, up, wheels) > ground - _STANDS_OUT
        if stands and float(weight @ up) < least - _STANDS_OUT:
            best, least = up, float(weight @ up)
    return best


def _weight(urdf: Urdf) -> NDArray[np.float64]:
    """Return the centre of mass in the root's frame [m]."""
    total, moment = 1e-9, np.zeros(3)
    for link in urdf.links.values():
        if link.inertial is not None:
            place = urdf.T_root(link.name).apply(np.array([link.inertial.center]))[0]
            total, moment = total + link.inertial.mass, moment + link.inertial.mass * place
    return moment / total


def _lowest(urdf: Urdf, up: NDArray[np.float64], wheels: tuple[str, ...]) -> float:
    """Return how low the robot reaches apart from its wheels [m]."""
    children = {urdf.joints[name].child for name in wheels}
    heights = [np.inf]
    for link in urdf.links.values():
        for part in link.collisions or link.visuals:
            if link.name not in children and part.shape.kind is not Kind.PLANE:
                points = (urdf.T_root(link.name) @ part.pose).apply(corners(part.shape))
                heights.append(float((points @ up).min()))
    return min(heights)


def _rpy(rows: NDArray[np.float64]) -> tuple[float, float, float]:
    """Return fixed-axis angles of a rotation matrix [rad]."""
    pitch = float(np.arcsin(np.clip(-rows[2, 0], -1.0, 1.0)))
    if abs(rows[2, 0]) > 1.0 - 1e-9:
        return 0.0, pitch, float(np.arctan2(-rows[0, 1], rows[1, 1]))
    roll = float(np.arctan2(rows[2, 1], rows[2, 2]))
    return roll, pitch, float(np.arctan2(rows[1, 0], rows[0, 0]))


def _add_root(root: Element, old: str, new: str, rpy: str) -> None:
    SubElement(root, "link", name=new)
    joint = SubElement(root, "joint", name=f"{new}_joint", type="fixed")
    SubElement(joint, "parent", link=new)
    SubElement(joint, "child", link=old)
    SubElement(joint, "origin", xyz="0 0 0", rpy=rpy)


def _mass(urdf: Urdf) -> float:
    return sum(link.inertial.mass for link in urdf.links.values() if link.inertial is not None)


def write_snippet(path: Path, source: Path, name: str, drive: DriveSettings) -> None:
    """Write what `snippet` returns.

    Raises:
        InputFileError: The file cannot be written.
    """
    try:
        path.write_text(snippet(source, name, drive), encoding="utf-8")
    except OSError as error:
        raise InputFileError(path, f"cannot be written: {error.strerror}") from error
