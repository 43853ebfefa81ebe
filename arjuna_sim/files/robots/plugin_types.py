"""Which drive or sensor a plugin or controller is, by its type exactly, in all spellings.

Sources: gazebo_plugins of ROS 1 and 2, the systems of Gazebo Fortress to Harmonic, ros_controllers
and ros2_controllers up to Jazzy, gz_ros2_control, and AgileX' ugv_gazebo_sim.
"""

from __future__ import annotations

import re
from xml.etree.ElementTree import Element  # types only; parsing is defusedxml's

from arjuna_sim.model.settings import DriveKind

_FILE = re.compile(
    r"(lib)?((gz|ignition)[-_](sim|gazebo)\d*[-_])?(gazebo[-_]ros[-_])?(?P<type>.+?)"
    r"([-_]system)?(\.so)?"
)
_DRIVES: dict[str, DriveKind] = {
    **dict.fromkeys(("diffdrive", "skidsteerdrive", "skidsteer"), DriveKind.SIDES),
    "diffdrivecontroller": DriveKind.SIDES,
    **dict.fromkeys(("mecanumdrive", "mecanumdrivecontroller"), DriveKind.MECANUM),
    **dict.fromkeys(("omnidrive", "omniwheeldrivecontroller"), DriveKind.OMNI),
    **dict.fromkeys(("planarmove", "velocitycontrol", "forcebasedmove"), DriveKind.PLANAR),
    **dict.fromkeys(("ackermanndrive", "ackermansteering", "ackerman"), DriveKind.STEERED),
    **dict.fromkeys(("ackermannsteering", "ackermann", "tricycledrive"), DriveKind.STEERED),
    **dict.fromkeys(("tricyclecontroller", "steeringcontrollerslibrary"), DriveKind.STEERED),
    **dict.fromkeys(("ackermannsteeringcontroller", "ackermanncontroller"), DriveKind.STEERED),
    **dict.fromkeys(("bicyclesteeringcontroller", "bicycledrive"), DriveKind.STEERED),
    **dict.fromkeys(("tricyclesteeringcontroller", "steeringdrive"), DriveKind.STEERED),
    "fourwheelsteeringcontroller": DriveKind.STEERED,
}
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
_CONTROL_CLASSES = (
    *("gazebosimros2controlplugin", "ignitionros2controlplugin", "gazeboros2controlplugin"),
)


def _plain(text: str) -> str:
    return re.sub(r"[-_]", "", text).lower()


def _types(plugin: Element) -> tuple[str, str]:
    """Return a plugin's type by its file's name, and by its class if its name is one."""
    file = _FILE.fullmatch(plugin.get("filename", "").rpartition("/")[2].strip())
    _, is_class, name = plugin.get("name", "").rpartition("::")
    return _plain(file["type"]) if file else "", _plain(name) if is_class else ""


def drive_kind(plugin: Element) -> DriveKind | None:
    """Return the kind of drive that a plugin is; None for no drive, or one of unknown type."""
    found = (_DRIVES.get(name) for name in _types(plugin))
    return next((kind for kind in found if kind is not None), None)


def sensor_type(plugin: Element) -> str:
    """Return the type of the `<sensor>` that a plugin belongs into; "" for another plugin."""
    return _SENSORS.get(_types(plugin)[0], "")


def is_control(plugin: Element) -> bool:
    """Return whether a plugin runs ros2_control's or ros_control's controllers."""
    file, name = _types(plugin)
    return file in _CONTROLS or name in _CONTROL_CLASSES


def controller_kind(kind: str) -> DriveKind | None:
    """Return the drive of a controller's type, as `diff_drive_controller/DiffDriveController`."""
    return _DRIVES.get(_plain(re.split(r"/|::", kind)[-1]))
