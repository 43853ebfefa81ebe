"""Reading drive plugins of Gazebo and ROS, in all their spellings."""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Collection
from typing import Any
from xml.etree.ElementTree import Element  # types only; parsing is defusedxml's

from arjuna_core.errors import nearest
from arjuna_core.geodesy import GRAVITY
from arjuna_sim.files.tag_text import flag, plain, text_of, texts, topic, value
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.notes import NoteKind
from arjuna_sim.model.settings import DriveKind, DriveSettings
from arjuna_sim.model.urdf import Urdf
from arjuna_sim.model.wheels import (
    center,
    effective_track,
    is_upright,
    span,
    wheel_radius,
    wheel_separation,
    with_followers,
)

_FILE = re.compile(
    r"(lib)?((gz|ignition)[-_](sim|gazebo)\d*[-_])?(gazebo[-_]ros[-_])?(?P<type>.+?)"
    r"([-_]system)?(\.so)?"
)
_SPELLINGS = {
    DriveKind.SIDES: ("diffdrive", "diffdrivecontroller", "skidsteerdrive", "skidsteer"),
    DriveKind.MECANUM: ("mecanumdrive", "mecanumdrivecontroller"),
    DriveKind.OMNI: ("omnidrive", "omni3wddrive", "omniwheeldrivecontroller"),
    DriveKind.TRACKED: ("trackedvehicle", "simpletrackedvehicleplugin"),
    DriveKind.PLANAR: ("planarmove", "velocitycontrol", "forcebasedmove"),
    DriveKind.STEERED: (
        *("ackermanndrive", "ackermansteering", "ackerman", "ackermannsteering", "ackermann"),
        *("ackermannsteeringcontroller", "ackermanncontroller", "steeringcontrollerslibrary"),
        *("tricycledrive", "tricyclecontroller", "tricyclesteeringcontroller", "steeringdrive"),
        *("bicycledrive", "bicyclesteeringcontroller", "fourwheelsteeringcontroller"),
        *("fourwidsdrive", "swervedrive", "swervedrivecontroller", "swervecontroller"),
    ),
}
"""Types of plugins and classes of controllers that drive, as `_plain` writes them."""
_DRIVES = {name: kind for kind, names in _SPELLINGS.items() for name in names}
_SENSORS = {
    **dict.fromkeys(("raysensor", "laser", "blocklaser", "velodynelaser", "range"), "ray"),
    **dict.fromkeys(("gpulaser", "velodynegpulaser"), "gpu_ray"),
    **dict.fromkeys(("camera", "prosilica"), "camera"),
    **dict.fromkeys(("depthcamera", "opennikinect"), "depth"),
    "multicamera": "multicamera",
    "imusensor": "imu",
    "gpssensor": "gps",
    "bumper": "contact",
}
_CONTROLS = ("control", "ros2control", "gzros2control", "ignros2control", "gazeboros2control")
_CONTROL_CLASSES = tuple(f"{p}ros2controlplugin" for p in ("gazebosim", "ignition", "gazebo"))
_DONE = re.compile(
    r"(?i)\b(physics|sensors|imu|magnetometer|altimeter|nav-?sat|contact|user-?commands"
    r"|scene-?broadcaster)(-system)?\b|libgazebo_ros_(init|factory|state)\b"
)
"""Gazebo's systems whose work the simulator does by itself."""
BATTERY = "linearbatteryplugin"
"""Type of gz-sim's plugin that is a battery."""
TORQUE = 5.0
"""Least torque of a wheel whose file names none, as in Gazebo [N m]."""
NO_DRIVE = DriveSettings((), (), 1.0, 1.0, TORQUE, 1.0, 1.0)
"""Of a robot that has no wheels."""
_ENDS = ("front", "rear", "middle", "back")
WHEEL = ("wheeljoint", "actuatedwheeljoint")
STEERING = (
    *(f"{end}{side}steeringjoint" for end in ("", *_ENDS) for side in ("left", "right")),
    *(f"{end}{side}wheelsteering" for end in _ENDS for side in ("left", "right")),
    *(f"swerve{side}{end}joint" for end in _ENDS for side in ("left", "right")),
    "steeringjoint",
)
"""Plain names of tags that hold the joints of wheels without sides, and those that steer."""
_JOINT = ("", "joint", "jointname")
LEFT, RIGHT = (
    (
        *(n for e in _ENDS for n in (f"{side}{e}joint", f"{e}{side}joint", f"{side}{e}")),
        *(f"{e}{side}wheel{part}" for e in ("", *_ENDS) for part in _JOINT if e or part),
        f"{side}joint",
    )
    for side in ("left", "right")
)
_BACK_WHEEL = "backjoint"  # of three omni wheels
_ACCELERATION = (
    *("maxwheelacceleration", "wheelacceleration", "maxlinearacceleration", "maxacceleration"),
)
_SPEED = ("maxlinearvelocity", "maxvelocity", "maxlinearspeed", "maxspeed")
_BACK = ("minlinearvelocity", "minvelocity")
_TURN = ("maxangularvelocity", "maxvelocity", "maxangularspeed")
_TURN_ACCELERATION = ("maxangularacceleration", "maxacceleration")
_BRAKING = ("minlinearacceleration", "minacceleration")
_TURN_BRAKING = ("minangularacceleration", "minacceleration")
_JERK = tuple(f"{side}{part}jerk" for side in ("max", "min") for part in ("", "linear", "angular"))
_DIAMETER = ("wheeldiameter", "actuatedwheeldiameter")
_TORQUES = ("wheeltorque", "maxwheeltorque")
_RATE = ("odometryrate", "publishrate", "odompublishfrequency", "updaterate")
_TIMEOUT = ("cmdveltimeout", "commandtimeout", "velocitycommandtimeout")
_LIMIT = ("steeringlimit", "maxsteer")
_OUTPUTS = {
    "odom": (True, ("publishodom",)),
    "odom_tf": (True, ("publishodomtf", "publishodometrytf", "broadcasttf", "publishtf")),
    "wheel_tf": (False, ("publishwheeltf",)),
    "joint_states": (False, ("publishwheeljointstate",)),
}
_READ = {
    *LEFT,
    *RIGHT,
    _BACK_WHEEL,
    *(name for _, names in _OUTPUTS.values() for name in names),
    *("wheelseparation", "wheelradius", "effectivetrackwidth", *_DIAMETER),
    *(*_ACCELERATION, *_BACK, *_TURN, *_TURN_ACCELERATION, *_TIMEOUT),
    *(*_BRAKING, *_TURN_BRAKING, *_JERK),
    *("effectivewheelradius", "torque", *_TORQUES),
    *(*WHEEL, *STEERING, *_LIMIT, "kingpinwidth", "wheelbase", "minsteer", "steeringwheeljoint"),
    *(*_SPEED, *_RATE, "tricyclejoint"),
    *("commandtopic", "topic", "odometrytopic", "odomtopic"),
    *("odometryframe", "frameid", "robotbaseframe", "childframeid", "odometrysource"),
    *("robotnamespace", "namespace", "ros", "remapping", "argument", "numwheelpairs", "plugin"),
    # what changes nothing here
    *("stamped", "alwayson", "legacymode", "rosdebuglevel", "tftopic"),
    *("encoderwheelleftjoint", "encoderwheelrightjoint", "encoderwheelseparation"),
    *("encoderwheeldiameter", "wheeljointleft", "wheeljointright"),
}
Sides = tuple[tuple[str, ...], tuple[str, ...]]
"""Names of the joints of the left and of the right wheels."""


def _plain(text: str) -> str:
    return re.sub(r"[-_]", "", text).lower()


def types_of(plugin: Element) -> tuple[str, str]:
    """Return a plugin's type by its file's name, and by its class if its name is one."""
    file = _FILE.fullmatch(plugin.get("filename", "").rpartition("/")[2].strip())
    _, is_class, name = plugin.get("name", "").rpartition("::")
    return _plain(file["type"]) if file else "", _plain(name) if is_class else ""


def drive_kind(plugin: Element) -> DriveKind | None:
    """Return the kind of drive that a plugin is; None for no drive, or one of unknown type.

    A maker's name may stand before, as in `libridgeback_ros_force_based_move.so`.
    """
    names = (n for name in types_of(plugin) for n in (name, name.rpartition("ros")[2]))
    return next((_DRIVES[name] for name in names if name in _DRIVES), None)


def sensor_type(plugin: Element) -> str:
    """Return the type of the `<sensor>` that a plugin belongs into; "" for another plugin."""
    return _SENSORS.get(types_of(plugin)[0], "")


def is_classic(plugin: Element) -> bool:
    """Return whether a plugin is one of Gazebo Classic's for ROS, as `libgazebo_ros_x.so`."""
    return "gazebo_ros" in plugin.get("filename", "").replace("-", "_")


def is_control(plugin: Element) -> bool:
    """Return whether a plugin runs ros2_control's or ros_control's controllers."""
    file, name = types_of(plugin)
    return file in _CONTROLS or name in _CONTROL_CLASSES


def is_done(plugin: Element) -> bool:
    """Return whether a plugin is a system of Gazebo's whose work the simulator does by itself."""
    return bool(_DONE.search(f"{plugin.get('filename')} {plugin.get('name')}"))


def controller_kind(kind: str) -> DriveKind | None:
    """Return the drive of a controller's type, as `diff_drive_controller/DiffDriveController`."""
    return _DRIVES.get(_plain(re.split(r"/|::", kind)[-1]))


def read_drive(xml: XmlFile, plugin: Element, urdf: Urdf) -> DriveSettings | None:
    """Read a plugin that names wheels, of two sides or without; None for another.

    One of unknown type drives no joints that turn about the vertical, as a car's front ones.

    Raises:
        RobotError: It names a joint that does not exist, or a value is invalid.
    """
    left, right = tuple(texts(plugin, *LEFT)), tuple(texts(plugin, *RIGHT))
    label = f"plugin '{name_of(plugin)}'"
    back = tuple(texts(plugin, _BACK_WHEEL)) if drive_kind(plugin) is DriveKind.OMNI else ()
    if back or not left or not right:
        left, right = (*left, *right, *back) if back else tuple(texts(plugin, *WHEEL)), ()
        if not left:
            return None
    left, right = _sides(xml, label, urdf, left, right)
    if drive_kind(plugin) is None and any(is_upright(urdf, name) for name in (*left, *right)):
        return None
    left, right = with_followers(urdf, left), with_followers(urdf, right)
    # Gazebo's drive of two sides reads no <torque>, which its page and many files have.
    torques = _TORQUES if types_of(plugin)[0] == "diffdrive" else ("torque", *_TORQUES)
    note_unread(xml, plugin, label, _READ)
    separation, radius, track, rolling = _kinematics(xml, plugin, label, urdf, (left, right))
    steering = tuple(dict.fromkeys(texts(plugin, *STEERING)))
    _check_joints(xml, label, urdf, steering)
    steering = with_followers(urdf, steering)
    drive = DriveSettings(
        left,
        right,
        separation,
        radius,
        torque=value(xml, plugin, label, 0.0, *torques)
        or torque_of(urdf, radius, len(left + right)),
        effective_track=track,
        effective_radius=rolling,
        steering=steering,
        steering_limit=value(xml, plugin, label, 0.0, *_LIMIT),
    )
    return with_outputs(xml, plugin, drive)


def torque_of(urdf: Urdf, radius: float, wheels: int) -> float:
    """Return the greatest torque of each of some wheels whose file names none [N m].

    The heaviest robot climbs and turns by it; Gazebo's own drives know no limit, or `TORQUE`.
    """
    # Together the wheels pull twice the robot's weight.
    return max(TORQUE, 2.0 * GRAVITY * urdf.mass * radius / wheels)


def name_of(plugin: Element) -> str:
    """Return what a plugin is called."""
    return plugin.get("name") or plugin.get("filename") or "?"


def with_outputs(xml: XmlFile, plugin: Element, drive: DriveSettings) -> DriveSettings:
    """Return a drive with a plugin's name, limits, topics and frames.

    Raises:
        RobotError: A value is invalid.
    """
    label = f"plugin '{name_of(plugin)}'"
    source = text_of(plugin, "odometrysource").lower()
    linear, angular = (plugin.find(f"{part}_velocity") for part in ("linear", "angular"))
    if linear is None and angular is None:  # else TrackedVehicle's, which limits no part unnamed
        linear = angular = plugin

    return dataclasses.replace(
        drive,
        plugin=name_of(plugin),
        **limits_of(xml, label, linear, angular),
        command_timeout=_timeout(xml, plugin, label),
        rate=value(xml, plugin, label, 0.0, *_RATE),
        command_topic=topic(plugin, "cmd_vel", "cmd_vel", "commandtopic", "topic"),
        odometry_topic=topic(plugin, "odom", "odom", "odometrytopic", "odomtopic"),
        odometry_frame=text_of(plugin, "odometryframe", "frameid", default="odom").lstrip("/"),
        base_frame=text_of(plugin, "robotbaseframe", "childframeid").lstrip("/"),
        from_world=source in ("1", "world"),
        begins_in_world=not source and is_classic(plugin),
        stamped=flag(plugin, False, "stamped"),
        publishes=tuple(key for key, (on, names) in _OUTPUTS.items() if flag(plugin, on, *names)),
        is_bridged="::systems::" in plugin.get("name", ""),
    )


def limits_of(
    xml: XmlFile, label: str, linear: Element | None, angular: Element | None = None
) -> dict[str, Any]:
    """Return the fields of a drive that are limits, from the tags of its speed and its turn rate.

    Those of Gazebo Sim's systems hold in one direction: who names no least acceleration brakes at
    once.

    Raises:
        RobotError: A value is invalid.
    """

    def most(tag: Element | None, *names: str) -> float:
        return 0.0 if tag is None else value(xml, tag, label, 0.0, *names)

    def least(tag: Element | None, *names: str) -> float:
        """Return a limit backwards, which files write as a least value below 0."""
        text = "" if tag is None else text_of(tag, *names)
        return max(0.0, -xml.numbers(text, 1, f"{label} <{names[0]}>")[0]) if text else 0.0

    def down(tag: Element | None, names: tuple[str, ...], part: str) -> float:
        ups = (f"max_{part}_acceleration", "max_acceleration")  # as Gazebo Sim writes them
        is_theirs = tag is not None and any(tag.find(up) is not None for up in ups)
        return least(tag, *names) or (math.inf if is_theirs else 0.0)

    def jerk(tag: Element | None, part: str) -> float:
        found = most(tag, f"max{part}jerk", "maxjerk"), least(tag, f"min{part}jerk", "minjerk")
        return min((each for each in found if each > 0.0), default=0.0)

    return {
        "max_velocity": most(linear, *_SPEED),
        "max_reverse": least(linear, *_BACK),
        "max_acceleration": most(linear, *_ACCELERATION),
        "max_deceleration": down(linear, _BRAKING, "linear"),
        "max_jerk": jerk(linear, "linear"),
        "max_turn": most(angular, *_TURN),
        "max_turn_acceleration": most(angular, *_TURN_ACCELERATION),
        "max_turn_deceleration": down(angular, _TURN_BRAKING, "angular"),
        "max_turn_jerk": jerk(angular, "angular"),
    }


def _timeout(xml: XmlFile, plugin: Element, label: str) -> float | None:
    if not text_of(plugin, *_TIMEOUT):
        return None
    return value(xml, plugin, label, 0.0, *_TIMEOUT)


def read_tracks(xml: XmlFile, plugin: Element, urdf: Urdf) -> Sides:
    """Return the links that are a plugin's left and right tracks; none for another plugin.

    Raises:
        RobotError: It names a link that does not exist.
    """
    left, right = (
        tuple((tag.findtext("link") or tag.text or "").strip() for tag in plugin.findall(name))
        for name in ("left_track", "right_track")
    )
    for link in (*left, *right):
        if link not in urdf.links:
            problem = f"track '{link}' is no link; {nearest(link, urdf.links)}"
            raise xml.fail(f"plugin '{name_of(plugin)}'", problem)
    return left, right


def read_wheelless(xml: XmlFile, plugin: Element, kind: DriveKind) -> DriveSettings:
    """Return a plugin's topics, frames and limits as a drive without wheels.

    One that moves a robot in the plane reports its true motion.

    Raises:
        RobotError: A value is invalid.
    """
    outputs = with_outputs(xml, plugin, NO_DRIVE)
    return dataclasses.replace(outputs, from_world=outputs.from_world or kind is DriveKind.PLANAR)


def _sides(
    xml: XmlFile, label: str, urdf: Urdf, left: tuple[str, ...], right: tuple[str, ...]
) -> Sides:
    _check_joints(xml, label, urdf, left + right)
    if both := set(left) & set(right):
        raise xml.fail(label, f"has '{min(both)}' on both sides")
    once = tuple(dict.fromkeys(left)), tuple(dict.fromkeys(right))
    if once != (left, right):
        xml.note(f"{label}: names a joint twice: it counts once")
        left, right = once
    return facing_ahead(xml, label, urdf, left, right)


def facing_ahead(
    xml: XmlFile, label: str, urdf: Urdf, left: tuple[str, ...], right: tuple[str, ...]
) -> Sides:
    """Return the wheels of two sides, exchanged where the left ones stand on the right."""
    if right and _mean_y(urdf, left) < _mean_y(urdf, right):
        xml.note(f"{label}: its left wheels stand on the right, so left and right are exchanged")
        return right, left
    return left, right


def _check_joints(xml: XmlFile, label: str, urdf: Urdf, joints: tuple[str, ...]) -> None:
    for joint in joints:
        if joint not in urdf.joints:
            problem = f"joint '{joint}' does not exist; {nearest(joint, urdf.joints)}"
            raise xml.fail(label, problem)


def _mean_y(urdf: Urdf, joints: tuple[str, ...]) -> float:
    return float(sum(center(urdf, name)[1] for name in joints) / len(joints))


def _kinematics(
    xml: XmlFile, plugin: Element, label: str, urdf: Urdf, sides: Sides
) -> tuple[float, float, float, float]:
    """Return separation and radius as the file says, and track and radius that the robot drives by.

    Where the file's own numbers contradict its wheels, the robot drives by its wheels.
    """
    left, right = sides
    by_shape = (
        wheel_separation(urdf, left, right) if right else span(urdf, left),
        wheel_radius(urdf, left + right),
    )
    diameters = (tag for tag in plugin.iter() if plain(tag.tag) in _DIAMETER)  # one a pair
    radius = max((value(xml, tag, label, 0.0, *_DIAMETER) for tag in diameters), default=0.0) / 2
    radius = radius or value(xml, plugin, label, 0.0, "wheelradius") or by_shape[1]
    separation = value(xml, plugin, label, 0.0, "wheelseparation") or by_shape[0]
    if not radius > 0.0:
        raise xml.fail(label, "the wheels' radius is unknown; <wheel_diameter> gives it")
    if not separation > 0.0:
        raise xml.fail(label, "the wheels' separation is unknown; <wheel_separation> gives it")
    _note_defaults(xml, plugin, label, by_shape)
    track = value(xml, plugin, label, 0.0, "effectivetrackwidth")
    rolling = value(xml, plugin, label, 0.0, "effectivewheelradius")
    for name, said, seen in (
        ("wheel_separation", separation, by_shape[0] if right else 0.0),
        ("wheel radius", radius, by_shape[1]),
    ):
        # From 5 % on the file and the wheels' shapes contradict each other.
        if seen > 0.0 and abs(said - seen) > 0.05 * seen and not (track or rolling):
            xml.note(
                f"{label}: {name} is {said:g}, but the wheels have {seen:g}: it drives by that"
            )
    return (
        separation,
        radius,
        track or (right and effective_track(urdf, left, right)) or separation,
        rolling or by_shape[1] or radius,
    )


def _note_defaults(
    xml: XmlFile, plugin: Element, label: str, by_shape: tuple[float, float]
) -> None:
    """Note numbers that gz-sim's drives assume, as their tags lack, and that the wheels contradict.

    Source: gz-sim 8's DiffDrive, MecanumDrive and AckermannSteering.
    """
    if not re.match(r"(lib)?(gz|ignition)-", plugin.get("filename", "")):
        return
    defaults = ("wheel_separation", 1.0), ("wheel_radius", 0.2)
    for (name, assumed), seen in zip(defaults, by_shape, strict=True):
        if not text_of(plugin, plain(name)) and abs(assumed - seen) > 0.05 * seen > 0.0:
            xml.note(
                f"{label}: without <{name}> Gazebo takes {assumed:g}, but the wheels have"
                f" {seen:g}: it drives by that"
            )


def note_unread(xml: XmlFile, plugin: Element, label: str, read: Collection[str]) -> None:
    """Note which tags of a plugin have no effect here.

    Args:
        read: Plain names of those that have one.
    """
    given = {plain(child.tag): (child.text or "").strip() for child in plugin.iter()}
    unread = sorted(
        {
            child.tag
            for child in plugin.iter()
            if plain(child.tag) not in read and not _mirrors(given, plain(child.tag))
        }
    )
    if unread:
        xml.note(
            f"{label}: not simulated: {', '.join(f'<{tag}>' for tag in unread)}", NoteKind.IGNORED
        )


def _mirrors(given: dict[str, str], tag: str) -> bool:
    """Return whether a least value is the greatest one below 0, and so says nothing more."""
    most = given.get(f"max{tag.removeprefix('min')}", "") if tag.startswith("min") else ""
    try:
        return bool(most) and float(given[tag]) == -float(most)
    except ValueError:
        return False
