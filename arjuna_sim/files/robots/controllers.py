"""Reading the drive of a robot that ros2_control moves: its controllers' parameters.

A controller's parameters are put into the form of a drive plugin, which `plugins` reads.
"""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Iterator, Mapping
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element, SubElement  # nothing is parsed here

from arjuna_core.errors import InputFileError, RobotError
from arjuna_core.files.yaml_file import read_yaml
from arjuna_sim.files.robots.plugins import controller_kind, is_control
from arjuna_sim.files.tag_text import OWN, PATH, remappings, text_of, texts
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.notes import NoteKind
from arjuna_sim.model.settings import DriveKind

_SIDE = re.compile(
    r"((front|rear|back|mid|middle)_)?(?P<side>left|right)_(wheels?|(wheel_)?(command_)?joints?)(_names?)?"
)
"""Parameters that name wheels, as `left_wheel_names` and `rear_left_wheel_command_joint_name`."""
_AXLE = re.compile(r"(front|rear|back)_(left|right)_(axle|steering)_joint(_name)?")
"""Parameters of swerve controllers that name steering joints."""
_WHEELS = ("wheel_names", "traction_joints_names", "traction_joint_name", "rear_wheels_names")
_STEERING = ("steering_joints_names", "steering_joint_name", "front_wheels_names")
_RADII = tuple(f"{part}wheels_radius" for part in ("", "traction_", "rear_", "front_"))
_PREFIXING = ("diff_drive_controller", "omni_wheel_drive_controller")
_READ_LIMITS = ("velocity", "acceleration", "jerk")
_UNREAD = {
    **dict.fromkeys(("open_loop", "publish_limited_velocity"), False),
    **dict.fromkeys(("left_wheel_radius_multiplier", "right_wheel_radius_multiplier"), 1.0),
    **dict.fromkeys(("pose_covariance_diagonal", "twist_covariance_diagonal"), [0.0] * 6),
}
"""Parameters of diff_drive_controller and its like that nothing here does, by what changes none."""


def drive_of_controllers(xml: XmlFile, plugin: Element) -> Element | None:
    """Return the first drive of the controllers of a plugin, as a drive plugin.

    Returns:
        A plugin; None where no controller drives wheels.
    """
    for path, sections in _contents(xml, plugin):
        types = {_own(key): str(v["type"]) for key, v in sections if isinstance(v.get("type"), str)}
        for name, values in sections:
            lists = _joints(values)
            if lists:
                unread = ", ".join((*_unread_limits(values), *_unread(values)))
                if unread:
                    text = f"controller '{name or path.name}': not simulated: {unread}"
                    xml.note(text, NoteKind.IGNORED)
                return _as_plugin(plugin, name, types, values, lists)
    return None


def parameters_of_controllers(xml: XmlFile, plugin: Element) -> dict[str, dict[str, Any]]:
    """Return the parameters of the controllers of a plugin that have a `type`, by their names."""
    found: dict[str, dict[str, Any]] = {}
    for _, sections in _contents(xml, plugin) if is_control(plugin) else ():
        for section, values in sections:
            found.setdefault(_own(section), {}).update(values)
    return {
        name: each for name, each in found.items() if name and isinstance(each.get("type"), str)
    }


def broadcasts(xml: XmlFile, plugin: Element) -> dict[str, dict[str, Any]]:
    """Return the topics and frames of what controllers publish of sensors, by these' names."""
    return {
        str(values.get("sensor_name")): {
            "topic": _topic(plugin, name, "imu"),
            "frame": str(values.get("frame_id", "")),
        }
        for name, values in parameters_of_controllers(xml, plugin).items()
        if values["type"].endswith("IMUSensorBroadcaster")
    }


def below(values: Mapping[str, Any], *keys: str) -> Mapping[str, Any]:
    """Return the parameters below some keys, the first outermost; none where there are none."""
    for key in keys:
        inner = values.get(key)
        values = inner if isinstance(inner, dict) else {}
    return values


def wheels_of_controller(values: Mapping[str, Any]) -> Iterator[str]:
    """Yield the interfaces that a drive's controller claims, as `wheel/velocity`."""
    for side, joints in _joints(values).items():
        for joint in joints:
            yield f"{joint}/{'position' if side == 'steering' else 'velocity'}"


def _contents(
    xml: XmlFile, plugin: Element
) -> Iterator[tuple[Path, list[tuple[str, dict[str, Any]]]]]:
    """Yield the files of a plugin's controllers and their sections; broken ones are noted."""
    for path in _files(xml, plugin):
        try:
            sections = list(_sections(read_yaml(path, RobotError)))
            types = ((_own(name), str(values.get("type"))) for name, values in sections)
            chained = {name for name, kind in types if name and kind.endswith("PidController")}
            yield path, [(name, _in_model(values, plugin, chained)) for name, values in sections]
        except InputFileError as error:
            xml.note(f"controllers of '{path.name}' are left out: {error.problem}", NoteKind.BROKEN)


def _in_model(values: Any, plugin: Element, chained: Collection[str]) -> Any:
    """Return parameters with the paths of joints of the nested model that the plugin is of.

    A joint that a drive turns through a `chained` controller, as `pid/wheel`, is named by itself.
    """
    if isinstance(values, dict):
        return {key: _in_model(value, plugin, chained) for key, value in values.items()}
    if isinstance(values, list):
        return [_in_model(value, plugin, chained) for value in values]
    if isinstance(values, str) and (parts := values.partition("/"))[0] in chained:
        values = parts[2] or values
    is_own = isinstance(values, str) and values in plugin.get(OWN, "").split("\n")
    return f"{plugin.get(PATH, '')}{values}" if is_own and values else values


def _joints(values: Mapping[str, Any]) -> dict[str, list[str]]:
    keys = {key: _SIDE.fullmatch(key) for key in map(str, values)}
    sides = {
        side: _names(
            values, tuple(k for k, found in keys.items() if found and found["side"] == side)
        )
        for side in ("left", "right")
    }
    if all(sides.values()):
        steering = _names(values, tuple(key for key in keys if _AXLE.fullmatch(key)))
        return {**sides, "steering": steering} if steering else sides
    lists = {"wheel": _names(values, _WHEELS), "steering": _names(values, _STEERING)}
    if values.get("front_steering") is False and "rear_wheels_names" in values:
        lists = {"wheel": lists["steering"], "steering": lists["wheel"]}
    return lists if lists["wheel"] and (lists["steering"] or "wheel_names" in values) else {}


def _files(xml: XmlFile, plugin: Element) -> Iterator[Path]:
    for text in texts(plugin, "parameters"):
        path = xml.find(text, "plugin <parameters>")
        if path is None:
            xml.note(f"controllers: '{text}' does not exist, so it is left out", NoteKind.MISSING)
        elif path.stat().st_size <= 1_000_000:
            yield path


def _sections(content: Any) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield the parameters of each node, by its name, however deep namespaces hold them.

    Dotted keys are as nested ones; the name is "" where it is a wildcard's.
    """
    queue: list[tuple[str, Any]] = [("", _nested(content))]
    # A hostile file may nest sections without end.
    for _ in range(1000):
        if not queue:
            return
        name, values = queue.pop(0)
        if isinstance(values, dict):
            yield name, values
            queue += [
                (name if key == "ros__parameters" else _node(str(key)), inner)
                for key, inner in values.items()
            ]


def _node(key: str) -> str:
    """Return a section's node without wildcards: `/**/base` is `base`, and `/**` is ""."""
    return "/".join(part for part in key.split("/") if part.strip("*"))


def _own(node: str) -> str:
    """Return a node's name without its namespace, as the controller manager knows it."""
    return node.rpartition("/")[2]


def _nested(content: Any, depth: int = 0) -> Any:
    """Return values with `a.b` as `b` in `a`."""
    if not isinstance(content, dict) or depth > 50:
        return content
    made: dict[str, Any] = {}
    for key, value in content.items():
        *above, last = str(key).split(".") if "/" not in str(key) else [str(key)]
        inside = made
        for part in above:
            inner = inside.get(part)
            inside[part] = inside = dict(inner) if isinstance(inner, dict) else {}
        value = _nested(value, depth + 1)
        held = inside.get(last)
        if isinstance(held, dict) and isinstance(value, dict):
            value = {**held, **value}
        inside[last] = value
    return made


def _names(values: Mapping[str, Any], keys: tuple[str, ...]) -> list[str]:
    found = [values[key] for key in keys if key in values]
    lists = [value if isinstance(value, list) else [value] for value in found]
    return [name for names in lists for name in names if isinstance(name, str)]


def _as_plugin(
    plugin: Element,
    name: str,
    types: dict[str, str],
    values: dict[str, Any],
    lists: dict[str, list[str]],
) -> Element:
    """Return a controller as a drive plugin, with the topics that it has below its own name.

    Source: ros2_controllers, diff_drive_controller, parameters of Humble and Jazzy.
    """
    kind, command, odometry = _kind(lists, values, types.get(_own(name), ""))
    if not name:  # all nodes have these parameters: the one that needs them has a type of its own
        drives = (key for key, each in types.items() if key and controller_kind(each))
        name = next(drives, kind)
    made = Element("plugin", name=name, filename=kind)
    for side, joints in lists.items():
        for joint in joints:
            SubElement(made, f"{side}_joint").text = joint
    stamped = values.get("use_stamped_vel", True) is not False
    command += "" if stamped else "_unstamped"
    before = _frame_prefix(plugin, values) if kind in _PREFIXING else ""
    radii = (_number(v, key) for v in (values, below(values, "kinematics")) for key in _RADII)
    found = {
        "wheel_separation": _product(values, "wheel_separation"),
        "wheel_radius": _product(values, "wheel_radius") or next(filter(None, radii), None),
        "update_rate": _number(values, "publish_rate"),
        "odometry_frame": before + str(values.get("odom_frame_id", "odom")),
        "robot_base_frame": before + str(values.get("base_frame_id", before and "base_link")),
        "publish_odom_tf": str(values.get("enable_odom_tf", "tricycle" not in kind)).lower(),
        "command_topic": _topic(plugin, name, command),
        "odometry_topic": _topic(plugin, name, odometry),
        "stamped": str(stamped).lower(),
        **_limits(values, kind),
    }
    for tag, value in found.items():
        if value is not None:
            SubElement(made, tag).text = str(value)
    return made


def _limits(values: dict[str, Any], kind: str) -> dict[str, float | None]:
    """Return a controller's limits and time-out, by the tags of a drive plugin.

    One whose `has_velocity_limits` is false, or others' like it, counts for nothing. Those
    of a tricycle are of its wheel [rad/s], and its time-out is in whole ms.
    """
    linear, angular = below(values, "linear", "x"), below(values, "angular", "z")
    back = _number(linear, "min_velocity", -1.0) if _has(linear, "velocity") else None
    limits = {
        "max_linear_velocity": _limit(linear, "velocity"),
        "min_linear_velocity": None if back is None else -back,
        "max_linear_acceleration": _limit(linear, "acceleration"),
        "max_angular_velocity": _limit(angular, "velocity"),
        "max_angular_acceleration": _limit(angular, "acceleration"),
        "max_linear_jerk": _limit(linear, "jerk"),
        "max_angular_jerk": _limit(angular, "jerk"),
    }
    names = ("cmd_vel_timeout", "reference_timeout", "cmd_vel_timeout_seconds")
    timeout = next((values[name] for name in names if name in values), None)
    if isinstance(timeout, int | float) and not isinstance(timeout, bool) and timeout >= 0:
        is_in_ms = kind == "tricycle_controller" and isinstance(timeout, int)
        limits["cmd_vel_timeout"] = 1e-3 * timeout if is_in_ms else float(timeout)
    radius, turning = _number(values, "wheel_radius"), below(values, "traction")
    if kind == "tricycle_controller" and radius:
        for tag in ("velocity", "acceleration"):
            most = _number(turning, f"max_{tag}")
            limits[f"max_linear_{tag}"] = None if most is None else radius * most
    for part in ("linear", "angular"):  # which hold both ways where nothing else is said
        most = limits[f"max_{part}_acceleration"]
        limits[f"min_{part}_acceleration"] = None if most is None else -most
    return limits


def _unread_limits(values: dict[str, Any]) -> Iterator[str]:
    """Yield the limits that no drive here has; a least one that mirrors the greatest is honoured.

    Such as those of deceleration where it differs.
    """
    for keys in (("linear", "x"), ("linear", "y"), ("angular", "z"), ("traction",), ("steering",)):
        inner = below(values, *keys)
        for key, value in inner.items():
            is_number = isinstance(value, int | float) and not isinstance(value, bool)
            side, _, kind = key.partition("_")
            is_read = keys[-1] in ("x", "z", "traction") and side == "max" and kind in _READ_LIMITS
            is_read |= (keys[-1], key) == ("x", "min_velocity")
            opposite = inner.get(f"max_{kind}")
            mirrors = side == "min" and isinstance(opposite, int | float) and value == -opposite
            if is_number and math.isfinite(value) and not is_read and not mirrors:
                yield f"{'.'.join(keys)}.{key}"


def _unread(values: dict[str, Any]) -> Iterator[str]:
    """Yield the parameters beside limits that ask for what is not done here."""
    return (key for key, none in _UNREAD.items() if values.get(key, none) != none)


def _has(values: Mapping[str, Any], kind: str) -> bool:
    return values.get(f"has_{kind}_limits", True) is not False


def _limit(values: Mapping[str, Any], kind: str) -> float | None:
    return _number(values, f"max_{kind}") if _has(values, kind) else None


def _kind(lists: dict[str, list[str]], values: dict[str, Any], named: str) -> tuple[str, str, str]:
    """Return what a controller is, and its topics of commands and of odometry.

    By its type where that is a drive's, else by what it has.

    Source: ros2_controllers of Jazzy: diff_drive, tricycle and omni_wheel_drive_controller have
    `cmd_vel` and `odom`, mecanum_drive and the steering controllers `reference` and `odometry`.
    Other controllers of mecanum wheels, with other parameters, are made after diff_drive's.
    """
    found = controller_kind(named)
    has_sides = "wheel" not in lists
    is_jazzys = "front_left_wheel_command_joint_name" in values
    if found is DriveKind.MECANUM or (has_sides and found is None and is_jazzys):
        topics = ("reference", "odometry") if is_jazzys else ("cmd_vel", "odom")
        return "mecanum_drive_controller", *topics
    if found is DriveKind.SIDES or (has_sides and found is None):
        return "diff_drive_controller", "cmd_vel", "odom"
    if found is DriveKind.OMNI or (not has_sides and not lists["steering"]):
        return "omni_wheel_drive_controller", "cmd_vel", "odom"
    if "swerve" in named.lower():
        return "swerve_drive_controller", "cmd_vel", "odom"
    if "traction_joint_name" in values:
        return "tricycle_controller", "cmd_vel", "odom"
    return "steering_controllers_library", "reference", "odometry"


def _number(values: Mapping[str, Any], key: str, sign: float = 1.0) -> float | None:
    value = values.get(key)
    if not isinstance(value, int | float) or isinstance(value, bool):
        return None
    return sign * value if 0.0 < sign * value < math.inf else None


def _product(values: dict[str, Any], key: str) -> float | None:
    length = _number(values, key)
    return None if length is None else length * (_number(values, f"{key}_multiplier") or 1.0)


def _frame_prefix(plugin: Element, values: Mapping[str, Any]) -> str:
    """Return what stands before a controller's frames: its namespace, or what the file says.

    Source: ros2_controllers, diff_drive_controller, Humble to Jazzy.
    """
    if values.get("tf_frame_prefix_enable", True) is False:
        return ""
    named = values.get("tf_frame_prefix") or text_of(plugin, "robotnamespace", "namespace")
    return f"{str(named).strip('/')}/".lstrip("/")


def _topic(plugin: Element, node: str, topic: str) -> str:
    """Return a topic of a controller in the plugin's namespace, as the plugin remaps it."""
    space = text_of(plugin, "robotnamespace", "namespace").strip("/")
    own = f"{node}/{topic}".removeprefix(f"{space}/")
    for source, target in remappings(plugin):
        if source.lstrip("/~").removeprefix(f"{space}/") == own:
            return f"/{space}/{target}" if space and not target.startswith("/") else target
    return f"/{space}/{own}" if space else f"/{own}"
