"""Reading a robot: macros, links and joints, Gazebo's tags, and what they lack."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Mapping
from pathlib import Path

from arjuna_core.errors import RobotError
from arjuna_core.files.whole_file import read_bytes
from arjuna_sim.files.sdf.robot_as_urdf import robot_as_urdf
from arjuna_sim.files.search_path import SearchPath
from arjuna_sim.files.urdf.completion import (
    bound_inertias,
    complete_masses,
    complete_shapes,
    friction_of,
)
from arjuna_sim.files.urdf.drive_kinds import arranged, told_by
from arjuna_sim.files.urdf.gazebo import read_gazebo
from arjuna_sim.files.urdf.guess import guess_drive
from arjuna_sim.files.urdf.links_and_joints import read_urdf
from arjuna_sim.files.urdf.stand_up import stand_up
from arjuna_sim.files.urdf.xacro_file import Expanded, expand, has_macros
from arjuna_sim.files.xml_file import BYTES_MAX, XmlFile
from arjuna_sim.model.robot import ANCHOR, Robot
from arjuna_sim.model.settings import DriveKind
from arjuna_sim.model.wheels import eccentricity, is_round, wheel_sign

_DRIVES = re.compile(rb"<plugin[^>]*(drive|control|planar|ackermann|steering)", re.IGNORECASE)
_ROOT = re.compile(rb"<\s*(sdf|robot)\b")


def load_robot(
    path: str | Path,
    search: SearchPath | None = None,
    arguments: Mapping[str, str] | None = None,
) -> Robot:
    """Read a robot from a URDF or SDF file, which may have xacro macros.

    Args:
        path: The file.
        search: Where to look for what it refers to; the environment's folders if None.
        arguments: Values of its xacro arguments.

    Raises:
        RobotError: The file cannot be read or does not describe a robot.
    """
    path = Path(path)
    text = read_bytes(path, BYTES_MAX, RobotError)
    expanded = Expanded(text)
    search = SearchPath.of() if search is None else search
    if has_macros(path, text):
        expanded = expand(path, search, arguments or {})
    return robot_of_text(path, expanded, search)


def robot_of_text(path: Path, expanded: Expanded, search: SearchPath) -> Robot:
    """Read a robot from a URDF or SDF without macros.

    Args:
        path: The file, for messages and for what stands beside it.
        expanded: Its text.
        search: Where to look for what it refers to.

    Raises:
        RobotError: It does not describe a robot.
    """
    text, notes = expanded.text, expanded.notes
    if is_sdf(text):
        sdf = XmlFile(path, "sdf", RobotError, text, search)
        text = robot_as_urdf(sdf)
        notes += tuple(sdf.notes)
    xml = XmlFile(path, "robot", RobotError, text, search)
    xml.beside = (path, *expanded.files)
    xml.keep(*notes)
    return read_robot(xml)


def names_drive(text: bytes) -> bool:
    """Tell whether a file has a plugin that drives or controls."""
    return _DRIVES.search(text) is not None


def is_sdf(text: bytes) -> bool:
    """Tell whether a file's root is `<sdf>` rather than `<robot>`."""
    root = _ROOT.search(text)
    return root is not None and root.group(1) == b"sdf"


def read_robot(xml: XmlFile) -> Robot:
    """Read a robot from a parsed URDF.

    Raises:
        RobotError: It does not describe a robot.
    """
    urdf = complete_shapes(xml, stand_up(xml, read_urdf(xml)))
    settings = read_gazebo(xml, urdf)
    drive = settings.drive or guess_drive(xml, urdf)
    drive = arranged(xml, urdf, drive, settings.kind, settings.grips)
    if settings.drive is None and settings.told is not None:
        drive = told_by(settings.told, drive)
    if not drive.grips:
        for text in settings.uneven:
            xml.note(text)
    for name in drive.wheels:
        if urdf.joints[name].kind != "continuous":
            raise xml.fail(f"joint '{name}'", "drives a wheel, so its type must be 'continuous'")
        if drive.kind is not DriveKind.OMNI:
            wheel_sign(urdf, name)
        if not is_round(urdf, name):
            off = eccentricity(urdf, name)
            xml.note(f"joint '{name}': is {off:.2g} m off the middle of its wheel, which so limps")
    settings = dataclasses.replace(settings, friction=friction_of(xml, urdf, settings, drive))
    urdf = complete_masses(xml, bound_inertias(xml, urdf, drive))
    if urdf.root == ANCHOR and drive.wheels:
        xml.note(f"link '{ANCHOR}': fixes it to the world, as in Gazebo: it does not drive")
    return Robot(urdf, settings, drive, tuple(xml.notes))
