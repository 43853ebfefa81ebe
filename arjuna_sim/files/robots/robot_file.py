"""Reading a robot: macros, links and joints, Gazebo's tags, and what they lack."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Mapping
from pathlib import Path

from arjuna_core.errors import RobotError
from arjuna_core.files.input_file import read_bytes
from arjuna_sim.files.robots.completion import (
    bound_inertias,
    complete_casters,
    complete_masses,
    complete_shapes,
    complete_wheels,
    friction_of,
)
from arjuna_sim.files.robots.drive_kinds import arranged, with_outputs_of
from arjuna_sim.files.robots.gazebo import TagReader
from arjuna_sim.files.robots.guess import guess_drive, guessed_wheels
from arjuna_sim.files.robots.joint_controllers import joint_control, with_mimics
from arjuna_sim.files.robots.rollers import on_whole_wheels
from arjuna_sim.files.robots.stand_up import stand_up, without_frames
from arjuna_sim.files.robots.undercarriage import on_rollers, on_tracks, strictest
from arjuna_sim.files.sdf.robot import read_sdf_robot
from arjuna_sim.files.search_path import SearchPath
from arjuna_sim.files.sensor_tag import Tags
from arjuna_sim.files.urdf.gazebo import read_tags
from arjuna_sim.files.urdf.links_and_joints import read_urdf
from arjuna_sim.files.urdf.written import urdf_text
from arjuna_sim.files.urdf.xacro_file import Expanded, expand, has_macros
from arjuna_sim.files.xml_file import BYTES_MAX, XmlFile, root_tag
from arjuna_sim.model.notes import Note, NoteKind
from arjuna_sim.model.robot import ANCHOR, RobotModel
from arjuna_sim.model.settings import DriveKind, DriveSettings, GazeboSettings
from arjuna_sim.model.urdf import Urdf
from arjuna_sim.model.wheels import eccentricity, freed, is_round, unlimited, wheel_sign

_MACRO = re.compile(rb"<xacro:macro\s[^>]*?name\s*=\s*[\"']([\w.-]+)")
_SIMULATES = re.compile(r"sim|gazebo|gz|ign", re.IGNORECASE)
_DRIVES = re.compile(
    rb"<plugin[^>]*(drive|control|planar|ackermann|steering|tracked)", re.IGNORECASE
)


def load_robot(
    path: str | Path,
    search: SearchPath | None = None,
    arguments: Mapping[str, str] | None = None,
) -> RobotModel:
    """Read a robot from a URDF or SDF file, which may have xacro macros.

    Args:
        path: The file; `world.sdf#name` names a model of an SDF world.
        search: Where to look for what it refers to; the environment's folders if None.

    Raises:
        RobotError: The file cannot be read or does not describe a robot.
    """
    path, model = split_model(path)
    text = read_bytes(path, BYTES_MAX, RobotError)
    expanded = Expanded(text)
    search = SearchPath.of() if search is None else search
    if has_macros(path, text):
        expanded = expand(path, search, arguments or {})
        macros = [name.decode("utf-8", "replace") for name in _MACRO.findall(text)]
        if macros and b"<link" not in expanded.text:
            problem = f"only defines macros ({', '.join(macros[:5])}) and makes no robot of them"
            raise RobotError(path, f"{problem}; give a file that calls <xacro:{macros[0]} .../>")
    try:
        return robot_of_text(path, expanded, search, model)
    except RobotError as error:
        missing = [note.text for note in expanded.notes if note.kind is NoteKind.MISSING]
        if not missing:
            raise
        where = f"{error.location}: " if error.location else ""
        problem = f"{'; '.join(missing[:3])}; so {where}{error.problem}"
        raise RobotError(error.path, problem) from error


def split_model(path: str | Path) -> tuple[Path, str]:
    """Return the file and the model of a world's robot, as in `world.sdf#name`; "" for no name."""
    file, _, name = str(path).rpartition("#")
    return (Path(file), name) if file and not Path(path).exists() else (Path(path), "")


def robot_of_text(
    path: Path, expanded: Expanded, search: SearchPath, model: str = ""
) -> RobotModel:
    """Read a robot from a URDF or SDF without macros.

    Args:
        path: The file, for messages and for what stands beside it.
        model: The robot's among those of an SDF world; "" for the one that drives.

    Raises:
        RobotError: It does not describe a robot.
    """
    tag = "sdf" if model else root_tag(expanded.text) or "robot"
    xml = XmlFile(path, tag, RobotError, expanded.text, search)
    xml.beside = (path, *expanded.files)
    xml.keep(*expanded.notes)
    if tag == "sdf":
        return robot_of(xml, *read_sdf_robot(xml, model))
    urdf = read_urdf(xml)
    robot = robot_of(xml, urdf, read_tags(xml, urdf))
    lacks = [
        *([] if robot.drive.plugin else ["drive plugin"]),
        *([] if robot.settings.sensors else ["sensors"]),
    ]
    if lacks and expanded.off:
        off = sorted(expanded.off, key=lambda name: _SIMULATES.search(name) is None)[:4]
        text = f"no {' and no '.join(lacks)}: {off[0]}:=true may bring what is missing"
        note = Note(NoteKind.CHANGED, f"{text}; false by default are {', '.join(off)}")
        robot = dataclasses.replace(robot, notes=(*robot.notes, note))
    return robot


def names_drive(text: bytes) -> bool:
    """Return whether a file has a plugin that drives or controls."""
    return _DRIVES.search(text) is not None


def _sprung(urdf: Urdf, tags: Tags) -> Urdf:
    """Return a robot whose joints have the springs of its Gazebo tags."""
    joints = {
        name: dataclasses.replace(joint, **tags.springs.get(name, {}))
        for name, joint in urdf.joints.items()
    }
    return dataclasses.replace(urdf, joints=joints)


def robot_of(xml: XmlFile, urdf: Urdf, tags: Tags) -> RobotModel:
    """Make a robot of its links, joints and tags: complete what they lack, and find its drive.

    Raises:
        RobotError: They do not describe a robot.
    """
    urdf = _sprung(without_frames(xml, urdf, tags), tags)
    root, urdf = urdf.root, stand_up(xml, with_mimics(xml, urdf), tags)
    T_model = tags.T_model @ urdf.T_root(root).inverse()
    start = None if tags.T_world is None else (tags.T_world @ T_model).planar()
    if not urdf.text:
        urdf = dataclasses.replace(urdf, text=urdf_text(urdf, tags))
    urdf, grips = on_whole_wheels(xml, complete_masses(xml, complete_shapes(xml, urdf)))
    tags.grips = {**grips, **tags.grips}
    read = TagReader(xml, urdf, tags)
    sensors, (urdf, drive, reported) = read.sensors(), _driven(xml, urdf, read, tags)
    if read.drive is None and read.wheelless is not None:
        drive = strictest(with_outputs_of(read.wheelless, drive), vars(drive))
    own = drive.odometry_topic.lstrip("/")
    if own in read.truths:  # Gazebo's drives publish below /model where their tags say nothing
        drive = dataclasses.replace(drive, from_world=True, odometry_frame=read.truths[own])
    if drive.from_world:  # what else publishes on its odometry's topic says the same
        sensors = tuple(s for s in sensors if s.topic.lstrip("/") != own)
    if not drive.grips:
        for text in tags.uneven:
            xml.note(text)
    _check_wheels(xml, urdf, drive)
    urdf = complete_wheels(xml, complete_casters(xml, urdf, drive), drive)
    # ODE's motors, whose speed Gazebo Classic's drives set, know no <limit velocity>.
    urdf = unlimited(urdf, drive.wheels if read.is_classic else ())
    urdf = freed(urdf, (*drive.wheels, *drive.steering))
    control = joint_control(xml, urdf, tags.plugins, drive)
    friction = friction_of(xml, urdf, tags.friction, drive, read.kind)
    urdf = bound_inertias(xml, urdf, drive)
    if urdf.root == ANCHOR and drive.wheels:
        xml.note(f"link '{ANCHOR}': fixes it to the world, as in Gazebo: it does not drive")
    settings = GazeboSettings(
        *(sensors, friction, tags.colours, tags.stiffness),
        reported=reported,
        report_rate=read.report_rate,
        poses=read.poses,
        **control._asdict(),
    )
    return RobotModel(urdf, settings, drive, tuple(xml.notes), start)


def _check_wheels(xml: XmlFile, urdf: Urdf, drive: DriveSettings) -> None:
    """Refuse wheels that cannot drive, and note those that drive otherwise than in Gazebo."""
    backward: list[str] = []
    for name in drive.wheels:
        if urdf.joints[name].kind != "continuous":
            raise xml.fail(f"joint '{name}'", "drives a wheel, so its type must be 'continuous'")
        if drive.kind is not DriveKind.OMNI and wheel_sign(urdf, name) < 0.0 and drive.plugin:
            backward.append(name)
        if not is_round(urdf, name):
            off = eccentricity(urdf, name)
            xml.note(f"joint '{name}': is {off:.2g} m off the middle of its wheel, which so limps")
    if backward:
        turns = "axes point to the right: Gazebo would roll them backward; here they roll ahead"
        xml.note(f"joint {', '.join(map(repr, backward))}: {turns}")


def _driven(
    xml: XmlFile, urdf: Urdf, read: TagReader, tags: Tags
) -> tuple[Urdf, DriveSettings, tuple[str, ...]]:
    """Return a robot with its drive, and the joints whose states are published.

    It drives by its own wheels, or by those that its tracks or base lack.
    """
    own = tuple(joint.name for joint in urdf.joints.values() if joint.has_position)
    named, made = tuple(read.reported), None
    if named:  # a broadcaster publishes those of ros2_control beside them
        tags_of = (joint for each in xml.root.iter("ros2_control") for joint in each.iter("joint"))
        held = (name for joint in tags_of if (name := joint.get("name", "")) in own)
        named = tuple(dict.fromkeys((*named, *held)))
    if any(read.tracks):
        urdf, made, tags.friction = on_tracks(xml, urdf, read.tracks, tags)
    elif read.drive is None and read.kind is DriveKind.PLANAR:
        if (guessed := guessed_wheels(xml, urdf, tags.controlled, True)) is not None:
            drive = arranged(xml, urdf, guessed, read.kind, tags.grips)
            hinged = {j.child for j in urdf.joints.values() if j.kind in ("continuous", "revolute")}
            # Wheels on forks would turn the forks.
            if drive.grips and not any(urdf.joints[n].parent in hinged for n in drive.wheels):
                return urdf, drive, named
        urdf, made = on_rollers(xml, urdf)
    if made is not None:  # wheels that no file names are in no message
        return urdf, made, named or own
    drive = read.drive or guess_drive(xml, urdf, tags.controlled, read.kind is not None)
    drive = arranged(xml, urdf, drive, read.kind, tags.grips)
    if named and {"wheel_tf", "joint_states"}.intersection(drive.publishes):
        named = tuple(dict.fromkeys((*named, *drive.wheels, *drive.steering)))
    return urdf, drive, named
