"""Reading what drives a robot's joints beside its wheels: ros2_control and Gazebo's plug-ins.

Source: ros2_controllers and gz_ros2_control of Jazzy, gz-sim 8's system plug-ins.
"""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple
from xml.etree.ElementTree import Element  # types only; parsing is defusedxml's

from arjuna_sim.files.robots.controllers import (
    below,
    parameters_of_controllers,
    wheels_of_controller,
)
from arjuna_sim.files.robots.plugins import note_unread, types_of
from arjuna_sim.files.robots.rules import check_mimics
from arjuna_sim.files.tag_text import plain, text_of, texts, topic
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.joints import (
    COMMANDS,
    EFFORT,
    POSITION,
    VELOCITY,
    ControllerKind,
    ControllerSettings,
    DrivenJoint,
    Gains,
)
from arjuna_sim.model.notes import NoteKind
from arjuna_sim.model.settings import DriveSettings
from arjuna_sim.model.urdf import Mimic, Urdf

_FORWARD = ControllerKind.FORWARD
_TYPES = {
    "jointgrouppositioncontroller": (_FORWARD, POSITION),
    "jointgroupvelocitycontroller": (_FORWARD, VELOCITY),
    "jointgroupeffortcontroller": (_FORWARD, EFFORT),
    "forwardcommandcontroller": (_FORWARD, ""),
    "jointtrajectorycontroller": (ControllerKind.TRAJECTORY, POSITION),
    "gripperactioncontroller": (ControllerKind.GRIPPER, POSITION),
}
"""Kind and command of ros2_controllers' classes; "" where a parameter names the command."""
_PLUGINS = {
    "jointcontroller": (_FORWARD, VELOCITY, "cmd_vel"),
    "jointpositioncontroller": (_FORWARD, POSITION, "cmd_pos"),
    "applyjointforce": (_FORWARD, EFFORT, "cmd_force"),
    "jointtrajectorycontroller": (ControllerKind.TRAJECTORY, POSITION, "joint_trajectory"),
    "jointposetrajectory": (ControllerKind.TRAJECTORY, POSITION, "set_joint_trajectory"),
}
"""Kind, command and usual topic of Gazebo's plug-ins."""
_READ = {
    *("plugin", "jointname", "topic", "subtopic", "pgain", "igain", "dgain", "imax", "imin"),
    *("positionpgain", "positionigain", "positiondgain", "initialposition", "updaterate"),
    *("ros", "namespace", "robotnamespace", "remapping", "useheaderstampasreference"),
    *("usevelocitycommands", "useforcecommands", "jointindex", "initialvelocity"),
}


class JointControl(NamedTuple):
    """All that moves joints beside the drive; fields as `GazeboSettings` has them."""

    driven: tuple[DrivenJoint, ...]
    controllers: tuple[ControllerSettings, ...]
    hardware: tuple[str, str]


def is_joint_plugin(plugin: Element) -> bool:
    """Return whether a plugin of Gazebo drives joints."""
    return any(name in _PLUGINS for name in types_of(plugin))


def joint_control(
    xml: XmlFile, urdf: Urdf, plugins: Sequence[Element], drive: DriveSettings
) -> JointControl:
    """Return what drives joints that are no wheels of a drive and steer none.

    Raises:
        RobotError: A value is invalid.
    """
    hardware, joints = _hardware(xml)
    controllers: list[ControllerSettings] = []
    for plugin in plugins:
        if is_joint_plugin(plugin):
            found = tuple(j.name for j in urdf.joints.values() if j.has_position and not j.mimic)
            controllers.append(read_joint_plugin(xml, plugin, urdf.name, found, joints))
            continue
        for name, values in parameters_of_controllers(xml, plugin).items():
            controllers.append(_of_parameters(xml, name, values, joints))
    taken = {*drive.rolling, *drive.steering}
    for controller in controllers:
        _note_joints(xml, urdf, drive, controller)
        for name in controller.joints:
            joints.setdefault(name, DrivenJoint(name))
    driven = tuple(
        joint
        for name, joint in joints.items()
        if name in urdf.joints
        and name not in taken
        and urdf.joints[name].has_position
        and urdf.joints[name].mimic is None
    )
    return JointControl(driven, tuple(controllers), hardware)


def _note_joints(
    xml: XmlFile, urdf: Urdf, drive: DriveSettings, controller: ControllerSettings
) -> None:
    """Note which joints of a controller are none, and which are wheels."""
    label, wheels = f"controller '{controller.name}'", list[str]()
    does, until = "turns", " from its first command on; until then cmd_vel does"
    if controller.is_push:
        does, until = "pushes", ", which cmd_vel does not turn then"
    for name in dict.fromkeys(controller.joints):
        if name not in urdf.joints:
            xml.note(
                f"{label}: joint '{name}' does not exist, so it does not move", NoteKind.MISSING
            )
        elif name in (*drive.rolling, *drive.steering) and controller.kind is _FORWARD:
            if controller.turns_wheels(drive.plugin, name in drive.steering):
                wheels.append(name)
                continue
            text = f"{label}: joint '{name}' is the drive's, which alone turns it"
            xml.note(text, NoteKind.IGNORED)
    if wheels:
        names = ", ".join(wheels)
        xml.note(f"{label}: {does} {names}{until}")


def with_mimics(xml: XmlFile, urdf: Urdf) -> Urdf:
    """Return a robot of whose joints those follow another that do so in ros2_control alone.

    Raises:
        RobotError: They follow each other in a circle, or a factor is no number.
    """
    joints = dict(urdf.joints)
    for tag in xml.root.iterfind(".//ros2_control/joint"):
        name, label = tag.get("name", ""), f"ros2_control joint '{tag.get('name')}' mimic"
        given = {param.get("name"): param.text or "" for param in tag.findall("param")}
        if "mimic" in given and name in joints and joints[name].mimic is None:
            factor = xml.numbers(given.get("multiplier", "1"), 1, label)[0]
            offset = xml.numbers(given.get("offset", "0"), 1, label)[0]
            mimic = Mimic(given["mimic"].strip(), factor, offset)
            joints[name] = dataclasses.replace(joints[name], mimic=mimic)
    return dataclasses.replace(urdf, joints=check_mimics(xml, joints))


def _hardware(xml: XmlFile) -> tuple[tuple[str, str], dict[str, DrivenJoint]]:
    """Return name and class of ros2_control's hardware, and its joints that take commands."""
    found, joints = ("", ""), {}
    for control in xml.root.iter("ros2_control"):
        found = control.get("name", ""), text_of(control, "plugin")
        for joint in control.findall("joint"):
            name = joint.get("name", "")
            commands = tuple(i.get("name", "") for i in joint.findall("command_interface"))
            states = tuple(i.get("name", "") for i in joint.findall("state_interface"))
            if name and any(command in COMMANDS for command in commands):
                label = f"ros2_control joint '{name}' initial_value"
                text = joint.findtext("state_interface[@name='position']/param") or "0"
                value = xml.numbers(text, 1, label)[0]
                joints[name] = DrivenJoint(name, commands, states, value)
    return found, joints


def read_joint_plugin(
    xml: XmlFile,
    plugin: Element,
    model: str,
    every: tuple[str, ...],
    joints: dict[str, DrivenJoint],
) -> ControllerSettings:
    """Return a plugin as a controller, and note in `joints` what it says of its joints.

    Args:
        model: The name of its model.
        every: The joints of a trajectory whose plugin names none.

    Raises:
        InputFileError: A value is no number.
    """
    type_ = next(name for name in types_of(plugin) if name in _PLUGINS)
    kind, command, usual = _PLUGINS[type_]
    label = f"plugin '{plugin.get('name') or plugin.get('filename') or '?'}'"
    names = tuple(texts(plugin, "jointname"))
    is_trajectory = kind is ControllerKind.TRAJECTORY
    if not names and is_trajectory:
        names = every
    lists = {
        tag: [xml.numbers(text, 1, f"{label} <{tag}>")[0] for text in texts(plugin, *tags)]
        for tag, tags in (
            ("initial", ("initialposition",)),
            ("p", ("pgain", "positionpgain")),
            ("i", ("igain", "positionigain")),
            ("d", ("dgain", "positiondgain")),
            ("clamp", ("imax",)),
        )
    }
    for i, name in enumerate(names):
        mine = {key: values[min(i, len(values) - 1)] for key, values in lists.items() if values}
        initial = mine.pop("initial", 0.0)
        gains = Gains(**{"p": 1.0, **mine}) if mine and command == POSITION else None
        joints[name] = DrivenJoint(name, initial=initial, gains=gains)
    model = f"/model/{model}"
    if type_ == "jointpositioncontroller":  # the index is that of the joint's axis
        usual = f"{text_of(plugin, 'jointindex') or 0}/{usual}"
    default = f"{model}/{usual}" if is_trajectory else f"{model}/joint/{names[:1][0]}/{usual}"
    if type_ == "jointposetrajectory":
        default = usual
    below = text_of(plugin, "subtopic")
    takes_topic = type_ != "applyjointforce"  # its topic is always the usual one
    note_unread(xml, plugin, label, _READ if takes_topic else _READ - {"topic"})
    return ControllerSettings(
        *(f"{label} of {' '.join(names)}", type_, kind, names, command),
        tuple(f"{name}/{command}" for name in names),
        topic=topic(
            plugin, f"{model}/{below}" if below else default, usual, *("topic",) * takes_topic
        ),
        is_managed=False,
        partial=True,
        goal_tolerance=(),
    )


def _of_parameters(
    xml: XmlFile, name: str, values: Mapping[str, Any], joints: dict[str, DrivenJoint]
) -> ControllerSettings:
    """Return a controller of ros2_control, and note in `joints` its gains."""
    type_ = str(values["type"])
    kind, command = _TYPES.get(
        plain(re.split(r"/|::", type_)[-1]), (ControllerKind.OTHER, VELOCITY)
    )
    if kind is ControllerKind.OTHER:
        claims = tuple(wheels_of_controller(values))
        if type_.endswith("PidController"):
            text = "is not simulated; wheels that a drive turns through it follow at once"
            xml.note(f"controller '{name}': {type_} {text}", NoteKind.IGNORED)
        return ControllerSettings(name, type_, kind, claims=claims)
    if type_.startswith(tuple(f"{command}_controllers" for command in COMMANDS)):
        command = type_.partition("_")[0]
    names = tuple(_texts(values.get("joints", values.get("joint"))))
    interfaces = _texts(values.get("command_interfaces", values.get("interface_name")))
    command = next((one for one in COMMANDS if one in interfaces), command or POSITION)
    if not names:
        xml.note(f"controller '{name}': names no joints, so it moves none", NoteKind.BROKEN)
    gains = below(values, "gains")
    for joint in names if command == EFFORT else ():
        given = below(gains, joint)
        if _number(given, "p"):
            clamp = _number(given, "i_clamp") or math.inf
            p, i, d = (_number(given, key) for key in "pid")
            mine = Gains(p, i, d, clamp)
            known = joints.get(joint, DrivenJoint(joint))
            joints[joint] = dataclasses.replace(known, gains=mine)
    limits = below(values, "constraints")
    tolerance = _number(values, "goal_tolerance", 0.01)
    is_gripper = kind is ControllerKind.GRIPPER
    return ControllerSettings(
        *(name, type_, kind, names, command),
        tuple(f"{joint}/{one}" for joint in names for one in interfaces or [command]),
        partial=values.get("allow_partial_joints_goal") is True,
        path_tolerance=tuple(_number(below(limits, joint), "trajectory") for joint in names),
        goal_tolerance=tuple(
            tolerance if is_gripper else _number(below(limits, joint), "goal") for joint in names
        ),
        goal_time=_number(limits, "goal_time"),
        stopped_velocity=_number(limits, "stopped_velocity_tolerance", 0.01),
        stall_timeout=_number(values, "stall_timeout", 1.0),
        allow_stalling=values.get("allow_stalling") is True,
    )


def _texts(value: Any) -> list[str]:
    return [
        item
        for item in (value if isinstance(value, list) else [value])
        if item and isinstance(item, str)
    ]


def _number(values: Mapping[str, Any], key: str, default: float = 0.0) -> float:
    """Return a number from 0; a default for anything else."""
    value = values.get(key)
    if isinstance(value, bool) or not isinstance(value, int | float):
        return default
    return float(value) if 0.0 <= value < math.inf else default
