"""Finding a robot's wheels where its file names none, and standing up one that lies on its side."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Set
from html import escape
from pathlib import Path

import numpy as np

from arjuna_core.arrays import Floats
from arjuna_core.errors import InputFileError
from arjuna_sim.files.robots.drive_kinds import omni_drive, trails
from arjuna_sim.files.robots.plugins import NO_DRIVE, Sides, facing_ahead, torque_of
from arjuna_sim.files.robots.rollers import is_roller
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.settings import DriveSettings
from arjuna_sim.model.urdf import Urdf
from arjuna_sim.model.wheels import axis, center, effective_track, radius_of, wheel_radius
from arjuna_sim.model.wheels import wheel_separation as separation_of

_PASSIVE = re.compile(r"cast[eo]r|swivel|steer|idler|roller|gripper|finger|arm_|pan_|tilt", re.I)
_WHEEL = re.compile(r"wheel|tire|tyre|track|rueda|roue|rad_", re.I)
_LEFT = re.compile(r"left|(^|_)(l|fl|rl|bl|ml|lf|lr|lb)(_|\d|$)", re.I)
_RIGHT = re.compile(r"right|(^|_)(r|fr|rr|br|mr|rf|rb)(_|\d|$)", re.I)
# Tried on the robots of tests/sim/files/test_robots.py and on ten public ones.
_UPRIGHT = 0.9  # least part along z of the axis of a wheel that lies on its side
_TOLERANCE = 0.02  # between a left wheel and its partner, along the robot and in height [m]
_NONE: Set[str] = frozenset()
_LACKS = "neither a drive plugin nor wheels"

_GUESS = """<?xml version="1.0"?>
<robot name="{name}" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:include filename="{source}"/>
  <gazebo>
    <plugin name="guessed_drive" filename="libgazebo_ros_diff_drive.so">
      {joints}<wheel_separation>{drive.separation:.6g}</wheel_separation>
      <wheel_diameter>{drive.diameter:.6g}</wheel_diameter>
      <max_wheel_torque>{drive.torque:.6g}</max_wheel_torque>
      <effective_track_width>{drive.effective_track:.6g}</effective_track_width>
      <effective_wheel_radius>{drive.effective_radius:.6g}</effective_wheel_radius>
    </plugin>
  </gazebo>
</robot>
"""


def guess_drive(
    xml: XmlFile, urdf: Urdf, controlled: Set[str] = _NONE, has_plugin: bool = False
) -> DriveSettings:
    """Return the drive of a robot whose file names no wheels of one; `NO_DRIVE` without any.

    Args:
        controlled: Names of the joints that a velocity controller moves.
        has_plugin: Whether a drive plugin is there.
    """
    if (found := guessed_wheels(xml, urdf, controlled, has_plugin)) is not None:
        return found
    lacks = "its drive plugin names no wheels, and there are none" if has_plugin else _LACKS
    xml.note(f"has no drive: {lacks} on both sides; it stands still")
    for i, line in ((0, "x, as joints without <axis> do"), (2, "the vertical")):
        lying = [n for n in _candidates(urdf, controlled) if abs(axis(urdf, n)[i]) > _UPRIGHT]
        if lying:
            xml.note(f"{', '.join(lying)}: turn about {line}, as no wheel does that drives")
    return NO_DRIVE


def guessed_wheels(
    xml: XmlFile, urdf: Urdf, controlled: Set[str], has_plugin: bool
) -> DriveSettings | None:
    """Return a drive by the wheels that a robot seems to have; None where it has none."""
    why = "the drive plugin names no wheels" if has_plugin else "no drive plugin"
    omni = omni_drive(urdf, tuple(_candidates(urdf, controlled)))
    if omni is not None:
        xml.note(f"{why}: guessed are the omni wheels {', '.join(omni.wheels)}")
        return dataclasses.replace(omni, is_guessed=True)
    left, right = guess_sides(xml, urdf, controlled)
    left, right = facing_ahead(xml, "its wheels' names", urdf, left, right)
    if not left or not right:
        return None
    radius, separation = wheel_radius(urdf, left + right), separation_of(urdf, left, right)
    if not radius > 0.0 or not separation > 0.0:
        raise xml.fail("drive", "the wheels' radius is unknown; <wheel_diameter> gives it")
    track = effective_track(urdf, left, right)
    torque = torque_of(urdf, radius, len(left + right))
    xml.note(
        f"{why}: guessed are the wheels {', '.join(left)} (left) and {', '.join(right)}"
        f" (right), separation {separation:.4g} m, radius {radius:.4g} m"
    )
    sizes = separation, radius, torque, track, radius
    return DriveSettings(left, right, *sizes, is_guessed=True)


def guess_sides(xml: XmlFile, urdf: Urdf, controlled: Set[str] = _NONE) -> Sides:
    """Return the joints of the left and right wheels, by names, axes and symmetry."""
    names = _candidates(urdf, controlled)
    if not names or omni_drive(urdf, tuple(names)) is not None:
        return (), ()
    left = _left_direction(urdf, names)
    # Wheels that drive together have axes within 26 degrees of each other.
    names = [n for n in names if abs(float(axis(urdf, n) @ left)) > 0.9]
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


def _candidates(urdf: Urdf, controlled: Set[str]) -> list[str]:
    names = [
        name
        for name, joint in urdf.joints.items()
        if joint.kind == "continuous"
        and joint.mimic is None
        and not _PASSIVE.search(f"{name} {joint.child}")
        and not is_roller(urdf, name)
        and radius_of(urdf, name) > 0.0
    ]
    leading = [name for name in names if not trails(urdf, name)]
    names = leading if len(leading) > 1 else names
    by_name = [n for n in names if _WHEEL.search(f"{n} {urdf.joints[n].child}")]
    by_control = [n for n in names if n in controlled]
    return next((group for group in (by_control, by_name, names) if len(group) > 1), [])


def _left_direction(urdf: Urdf, names: list[str]) -> Floats:
    line = axis(urdf, names[0])
    sums = [float(center(urdf, n) @ line) * _side_of(urdf, n) for n in names]
    sides = [_side_of(urdf, n) for n in names]
    if 1 in sides and -1 in sides and abs(sum(sums)) > 1e-6:
        return line if sum(sums) > 0.0 else -line
    # Without names it faces where it turns least: ahead +x, else +y.
    wanted = np.array([-1e-3, 1.0, -1e-6])
    return line if float(line @ wanted) >= 0.0 else -line


def _side_of(urdf: Urdf, name: str) -> int:
    """Return 1 for a name that says left, -1 for right, else 0."""
    text = (name, urdf.joints[name].child)
    is_left, is_right = (any(p.search(t) for t in text) for p in (_LEFT, _RIGHT))
    return int(is_left) - int(is_right)


def _partners(urdf: Urdf, name: str, other: str, left: Floats) -> bool:
    gap = center(urdf, name) - center(urdf, other)
    gap = gap - float(gap @ left) * left
    sizes = radius_of(urdf, name), radius_of(urdf, other)
    # Partners stand opposite within 0.3 of a radius, and their radii differ by less than a tenth.
    near = float(np.linalg.norm(gap)) < max(_TOLERANCE, 0.3 * sizes[0])
    return near and abs(sizes[0] - sizes[1]) < 0.1 * sizes[0]


def save_guess(path: Path, source: Path, name: str, drive: DriveSettings) -> None:
    """Write a xacro file that adds a guessed drive to the robot it was guessed for.

    Raises:
        InputFileError: The file cannot be written.
    """
    sides = (("left", drive.left), ("right", drive.right))
    joints = "".join(
        f"<{side}_joint>{escape(n)}</{side}_joint>\n      " for side, names in sides for n in names
    )
    text = _GUESS.format(
        name=escape(name), source=escape(str(source.resolve())), joints=joints, drive=drive
    )
    try:
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise InputFileError(path, f"cannot be written: {error.strerror}") from error
