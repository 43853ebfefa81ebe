"""Robots and worlds, by what parameters and the command line say of them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from arjuna_core.errors import RobotError
from arjuna_core.files.shipped import shipped_file
from arjuna_sim.devices.drive import DriveConfig
from arjuna_sim.devices.driving.bases import SidesBase
from arjuna_sim.devices.driving.controller import Ramp, limited
from arjuna_sim.devices.driving.steered import SteeredBase
from arjuna_sim.devices.sensors.camera import CameraSettings
from arjuna_sim.devices.sensors.imu import ImuSettings
from arjuna_sim.devices.sensors.lidar import CloudSettings, LidarSettings, level_lidars
from arjuna_sim.files.robots.robot_file import load_robot
from arjuna_sim.files.sdf.robot import read_sdf_robot
from arjuna_sim.files.sensor_tag import Tags
from arjuna_sim.files.urdf.links_and_joints import read_urdf
from arjuna_sim.files.urdf.written import urdf_text
from arjuna_sim.files.urdf.xacro_file import split
from arjuna_sim.files.world_file import load_world
from arjuna_sim.files.xml_file import XmlFile, root_tag
from arjuna_sim.model.robot import RobotModel, extent, footprint
from arjuna_sim.model.settings import WHEEL_ODOMETRY, DriveKind
from arjuna_sim.model.urdf import Urdf
from arjuna_sim.model.world import World

_BASES = {"base_footprint", "base_link"}
_DESCRIPTION = Path("robot_description")  # a text's, in messages


def named_robot(path: str, arguments: str) -> RobotModel:
    """Return the robot of the parameters `robot` and `robot_arguments`.

    Args:
        path: A URDF, xacro or SDF file, or a world's robot as `world.sdf#name`; the shipped one's
            if empty.
        arguments: Arguments of the xacro file, each `name:=value`, as in a shell.

    Raises:
        RobotError: The file cannot be read or does not describe a robot.
        ConfigError: An argument is none.
    """
    return load_robot(path or shipped_file("urdf/arjuna.urdf"), arguments=split(arguments))


def described(text: str) -> Urdf:
    """Return the links and joints of the text of a URDF or an SDF model, which need not drive.

    Raises:
        RobotError: It does not describe links and joints.
    """
    given = text.encode()
    if root_tag(given) == "sdf":
        return replace(_of_sdf(given)[0], text=text)
    return read_urdf(XmlFile(_DESCRIPTION, "robot", RobotError, given))


def as_urdf(text: str) -> str:
    """Return the text of a robot as a URDF: that of an SDF model is written anew.

    Raises:
        RobotError: The SDF does not describe links and joints.
    """
    given = text.encode()
    return urdf_text(*_of_sdf(given)) if root_tag(given) == "sdf" else text


def _of_sdf(text: bytes) -> tuple[Urdf, Tags]:
    return read_sdf_robot(XmlFile(_DESCRIPTION, "sdf", RobotError, text))


def names_of(robot: RobotModel, is_fused: bool = False) -> dict[str, str]:
    """Return what a robot's file calls its topics and frames, where that is not the standard.

    Args:
        is_fused: Whether a filter of wheels and gyro publishes its odometry.

    Returns:
        By name; scans and clouds of several sensors are words, the one that maps the first.
    """
    drive, imu = robot.drive, robot.settings.first(ImuSettings)
    names = {
        ("scan_topic", "scan"): " ".join(_scans(robot)) or "scan",
        ("cloud_topic", "depth/points"): " ".join(_clouds(robot)) or "depth/points",
        ("imu", ImuSettings.TOPIC): imu.topic if imu is not None else ImuSettings.TOPIC,
        ("odom_topic", "odom"): drive.fused_topic if is_fused else drive.odometry_topic,
        ("cmd_vel_topic", "cmd_vel"): drive.command_topic,
        ("odom_frame", "odom"): drive.odometry_frame,
    }
    found = {key: name for (key, usual), name in names.items() if name.lstrip("/") != usual}
    if not is_fused and drive.odometry_topic.lstrip("/") == WHEEL_ODOMETRY:
        found[WHEEL_ODOMETRY] = f"{drive.odometry_topic}/unfused"  # not what the robot publishes
    if not robot.urdf.links.keys() >= _BASES:
        found["base_frame"] = robot.urdf.root
    return found


def frames_and_topics(robot: RobotModel) -> dict[str, frozenset[str]]:
    """Return what a robot's file gives of what `names_of` names; nothing where it has none."""
    drive, sensors = robot.drive, robot.settings.sensors
    clouds = frozenset(_clouds(robot))
    scans = {s.topic for s in sensors if isinstance(s, LidarSettings)}
    found = {
        "scan_topic": scans,
        "cloud_topic": clouds | scans if clouds else (),
        "odom_topic": (drive.odometry_topic, drive.fused_topic),
        "base_frame": {*robot.urdf.links, *(s.frame for s in sensors), drive.base_frame},
        "odom_frame": (drive.odometry_frame,),
    }
    return {key: frozenset(name.strip("/") for name in names) for key, names in found.items()}


def _clouds(robot: RobotModel) -> dict[str, float]:
    """Return the topics of a robot's clouds, depth cameras' first; how their points scatter [m]."""
    sensors = robot.settings.sensors
    cameras = [s.cloud_topic for s in sensors if isinstance(s, CameraSettings) and s.cloud_topic]
    rows = {s.topic: s.noise for s in sensors if type(s) is CloudSettings}
    return dict.fromkeys(cameras, 0.0) | rows


def _scans(robot: RobotModel) -> dict[str, None]:
    """Return the topics of a robot's scans, of the one that maps first.

    Where one looks at the ground, what it sees there is no obstacle: it is left out.
    """
    return dict.fromkeys(s.topic for s in level_lidars(robot.settings.sensors, robot.urdf))


def sight_of(robot: RobotModel) -> float:
    """Return how far the lidar sees that a robot maps by; 0 where it has none [m]."""
    lidars = level_lidars(robot.settings.sensors, robot.urdf)
    return lidars[0].range_max if lidars else 0.0


class Heights(NamedTuple):
    """Heights in the frame of a robot's root.

    Attributes:
        ground: Of the ground that its wheels stand on [m].
        top: Of its body's highest point [m].
        scatter: Standard deviation of the points that its clouds show, at most [m].
    """

    ground: float
    top: float
    scatter: float


def heights_of(robot: RobotModel) -> Heights:
    """Return the heights between which a robot can touch things, and how sharply it sees them."""
    urdf = robot.urdf
    wheels = [urdf.T_root(urdf.joints[name].child).position[2] for name in robot.drive.rolling]
    ground = min(wheels, default=robot.drive.radius) - robot.drive.radius
    top = float(extent(robot, urdf.root)[:, 2].max(initial=ground))
    return Heights(ground, top, max(_clouds(robot).values(), default=0.0))


def needs_fusion(robot: RobotModel) -> bool:
    """Return whether a robot's wheels tell where it is, and an IMU how it turns."""
    return robot.settings.first(ImuSettings) is not None and not robot.drive.tells_truth


def turning_radius_of(robot: RobotModel) -> float:
    """Return the radius of a steered robot's tightest bend; 0 of one that turns on the spot [m]."""
    if robot.drive.kind is not DriveKind.STEERED:
        return 0.0
    return SteeredBase.of(robot.urdf, robot.drive).turning_radius


def ramps_of(robot: RobotModel) -> tuple[Ramp, Ramp]:
    """Return how fast a robot's speed and turn rate change by its file, inf for at once."""
    limits = limited(DriveConfig(), robot.drive)
    return limits.linear, limits.angular


def axle_of(robot: RobotModel, frame: str) -> float:
    """Return where along x of a frame the wheels' line is about whose points a robot turns [m].

    It is 0 of one that moves sideways, or has no wheels.

    Args:
        frame: As in `footprint_of`.
    """
    if moves_sideways(robot) or not robot.drive.rolling:
        return 0.0
    if robot.drive.kind is DriveKind.STEERED:
        axle = SteeredBase.of(robot.urdf, robot.drive).axle
    else:
        axle = SidesBase.of(robot, DriveConfig()).axle
    return axle - float(robot.urdf.T_root(_link(robot, frame)).position[0])


def moves_sideways(robot: RobotModel) -> bool:
    """Return whether a robot's drive takes speeds to the left and right."""
    return robot.drive.kind not in (DriveKind.SIDES, DriveKind.STEERED)


def footprint_of(robot: RobotModel, frame: str) -> str:
    """Return a robot's outline as the costmaps' `footprint`; "" where it has none.

    Args:
        frame: The costmaps' `robot_base_frame`; the root link where it is none of the robot's.
    """
    outline = footprint(robot, _link(robot, frame))
    return str(outline.tolist()) if len(outline) else ""


def _link(robot: RobotModel, frame: str) -> str:
    return frame if frame in robot.urdf.links else robot.urdf.root


def named_world(path: str, robots: Iterable[RobotModel] = ()) -> World:
    """Return the world of the parameter `world`: an SDF file's, a map's, or the shipped room.

    Args:
        robots: Those that drive; one that the file holds is no part of the world.

    Raises:
        WorldError: The file cannot be read or does not describe a world.
        MapError: The map cannot be read.
    """
    file = Path(path) if path else shipped_file("worlds/arjuna_room.world")
    held = [robot.urdf for robot in robots if robot.start is not None]
    own = {urdf.name for urdf in held if urdf.path.resolve() == file.resolve()}
    return load_world(file, without=own)
