"""Reading the drive of a robot that ros2_control moves: its controllers' parameters.

A controller's parameters are put into the form of a drive plugin, which `plugins` reads.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element, SubElement  # nothing is parsed here

from arjuna_core.errors import InputFileError, RobotError
from arjuna_core.files.yaml_file import read_yaml
from arjuna_sim.files.urdf.gazebo_text import plain, texts
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.notes import NoteKind

_SIDES = {
    side: (
        *(f"{side}_wheel_names", f"{side}_wheel_name", f"{side}_wheel", f"{side}_wheels"),
        *(f"{end}_{side}_wheel_command_joint_name" for end in ("front", "rear")),
    )
    for side in ("left", "right")
}
_WHEELS = ("wheel_names", "traction_joints_names", "traction_joint_name", "rear_wheels_names")
_STEERING = ("steering_joints_names", "steering_joint_name", "front_wheels_names")
_SECTIONS_MAX = 1000
_BYTES_MAX = 1_000_000


def is_control(plugin: Element) -> bool:
    """Tell whether a plugin runs ros2_control's or ros_control's controllers."""
    name = plain(plugin.get("filename", "") + plugin.get("name", ""))
    return "ros2control" in name or "roscontrol" in name


def drive_of_controllers(xml: XmlFile, plugin: Element) -> Element | None:
    """Return the first drive of the controllers of a plugin, as a drive plugin.

    Args:
        xml: The robot's file.
        plugin: What runs the controllers, and names the files of their parameters.

    Returns:
        A plugin; None where no controller drives wheels.
    """
    for path in _files(xml, plugin):
        try:
            content = read_yaml(path, RobotError)
        except InputFileError as error:
            xml.note(f"controllers of '{path.name}' are left out: {error.problem}", NoteKind.BROKEN)
            continue
        for name, values in _sections(content):
            sides = {side: _names(values, keys) for side, keys in _SIDES.items()}
            if all(sides.values()):
                return _as_plugin(plugin, name, values, sides)
            lists = {"wheel": _names(values, _WHEELS), "steering": _names(values, _STEERING)}
            if values.get("front_steering") is False and "rear_wheels_names" in values:
                lists = {"wheel": lists["steering"], "steering": lists["wheel"]}
            if lists["wheel"] and (lists["steering"] or "wheel_names" in values):
                return _as_plugin(plugin, name, values, lists)
    return None


def _files(xml: XmlFile, plugin: Element) -> Iterator[Path]:
    """Yield the files of parameters; what does not exist is noted."""
    for text in texts(plugin, "parameters"):
        path = xml.find(text, "plugin <parameters>")
        if path is None:
            xml.note(f"controllers: '{text}' does not exist, so it is left out", NoteKind.MISSING)
        elif path.stat().st_size <= _BYTES_MAX:
            yield path


def _sections(content: Any) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield the named parameters of each node, however deep namespaces hold them."""
    queue: list[tuple[str, Any]] = [("", content)]
    for _ in range(_SECTIONS_MAX):
        if not queue:
            return
        name, values = queue.pop(0)
        if isinstance(values, dict):
            yield name, values
            queue += [
                (name if key == "ros__parameters" else str(key), inner)
                for key, inner in values.items()
            ]


def _names(values: dict[str, Any], keys: tuple[str, ...]) -> list[str]:
    """Return the joints that parameters of any of these names hold."""
    found = [values[key] for key in keys if key in values]
    lists = [value if isinstance(value, list) else [value] for value in found]
    return [name for names in lists for name in names if isinstance(name, str)]


def _as_plugin(
    plugin: Element, name: str, values: dict[str, Any], sides: dict[str, list[str]]
) -> Element:
    """Return a controller as a drive plugin, with the topics that it has below its own name.

    Source: ros2_controllers, diff_drive_controller, parameters of Humble and Jazzy.
    """
    kind, command, odometry = _kind(sides, values)
    made = Element("plugin", name=name, filename=kind)
    for side, joints in sides.items():
        for joint in joints:
            SubElement(made, f"{side}_joint").text = joint
    limits = values.get("linear", {})
    limit = limits.get("x", {}) if isinstance(limits, dict) else {}
    stamped = values.get("use_stamped_vel", True) is not False
    command = f"/{name}/{command}" + ("" if stamped else "_unstamped")
    told = {
        "wheel_separation": _product(values, "wheel_separation"),
        "wheel_radius": _product(values, "wheel_radius"),
        "max_linear_velocity": _number(limit, "max_velocity"),
        "max_linear_acceleration": _number(limit, "max_acceleration"),
        "update_rate": _number(values, "publish_rate"),
        "odometry_frame": values.get("odom_frame_id"),
        "robot_base_frame": values.get("base_frame_id"),
        "publish_odom_tf": str(values.get("enable_odom_tf", True)).lower(),
        "command_topic": _remapped(plugin, command),
        "odometry_topic": _remapped(plugin, f"/{name}/{odometry}"),
        "stamped": str(stamped).lower(),
    }
    for tag, value in told.items():
        if value is not None:
            SubElement(made, tag).text = str(value)
    return made


def _kind(sides: dict[str, list[str]], values: dict[str, Any]) -> tuple[str, str, str]:
    """Return what a controller is, and its topics of commands and of odometry.

    Source: ros2_controllers of Jazzy: diff_drive, tricycle and omni_wheel_drive_controller have
    `cmd_vel` and `odom`, mecanum_drive and the steering controllers `reference` and `odometry`.
    """
    if "wheel" not in sides:
        if any(key.startswith("front_left_wheel") for key in values):
            return "mecanum_drive_controller", "reference", "odometry"
        return "diff_drive_controller", "cmd_vel", "odom"
    if not sides["steering"]:
        return "omni_wheel_drive_controller", "cmd_vel", "odom"
    if "traction_joint_name" in values:
        return "tricycle_controller", "cmd_vel", "odom"
    return "steering_controllers_library", "reference", "odometry"


def _number(values: Any, key: str) -> float | None:
    """Return a positive number; None where there is none."""
    value = values.get(key) if isinstance(values, dict) else None
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    return float(value) if is_number and value > 0.0 else None  # type: ignore[arg-type,operator]


def _product(values: dict[str, Any], key: str) -> float | None:
    """Return a length times its calibrated multiplier."""
    length = _number(values, key)
    return None if length is None else length * (_number(values, f"{key}_multiplier") or 1.0)


def _remapped(plugin: Element, topic: str) -> str:
    """Return a topic after the plugin's remappings."""
    for text in (*texts(plugin, "remapping"), *texts(plugin, "argument")):
        source, _, target = text.partition(":=")
        if source.strip().lstrip("/~").removeprefix("/") == topic.lstrip("/") and target.strip():
            return target.strip()
    return topic
