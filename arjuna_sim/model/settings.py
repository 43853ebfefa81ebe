"""Settings of a robot's drive and sensors; each file of `devices/sensors` registers its kinds."""

from __future__ import annotations

import importlib
import pkgutil
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, fields, replace
from enum import Enum
from functools import cache
from typing import Any, ClassVar, NamedTuple, TypeVar

from arjuna_core.pose3 import ORIGIN, Pose3
from arjuna_sim.model.joints import ControllerSettings, DrivenJoint
from arjuna_sim.model.urdf import Urdf

OUTPUTS = (
    *("plugin", "max_acceleration", "max_velocity", "max_reverse", "max_turn"),
    *("max_deceleration", "max_jerk", "max_turn_deceleration", "max_turn_jerk"),
    *("max_turn_acceleration", "command_timeout", "rate", "command_topic", "odometry_topic"),
    *("odometry_frame", "base_frame", "from_world", "begins_in_world", "stamped", "publishes"),
    "is_bridged",
)
"""Fields of a drive that do not depend on its wheels."""
WHEEL_ODOMETRY = "wheel_odom"
"""The topic on which a filter of wheels and gyro hears the wheels."""
BRIDGES = "/_bridges"
"""A topic that each bridge to Gazebo Sim's topics advertises; below it `/tf`, if it hands that on.
"""
S = TypeVar("S", bound="SensorSettings")


def spelled(topic: str) -> str:
    """Return a topic of Gazebo Sim's as ROS can spell it: of `/eye-1/0/scan` `/eye_1/_0/scan`."""
    return re.sub(r"(^|/)(?=\d)", r"\1_", re.sub(r"[^A-Za-z0-9_/~{}]+", "_", topic))


class DriveKind(Enum):
    """The principle by which wheels move a robot."""

    SIDES = "differential or skid-steer"
    MECANUM = "mecanum wheels"
    OMNI = "omni wheels"
    STEERED = "steered wheels"
    SWERVE = "wheels that each steer"
    TRACKED = "tracks"
    PLANAR = "moved in the plane"
    """Asked for by a file, as tracks are; wheels of another kind stand for them."""


@dataclass(frozen=True)
class DriveSettings:
    """A drive: its wheels, limits, topics and frames.

    Attributes:
        left: Names of the left wheels' joints; of wheels without sides all of them.
        right: Names of the right wheels' joints.
        separation: Distance between left and right wheels [m].
        radius: Wheels' radius [m].
        torque: Greatest torque of each wheel [N m].
        effective_track: Track of the two-wheeled robot that turns like this one [m].
        effective_radius: Radius that makes wheel turns into distance [m].
        plugin: Name of the plugin that was read; "" for a guess.
        max_acceleration: Greatest change of the wheels' speed at the ground, 0 for none [m/s^2].
        max_deceleration: The same of a change backwards, 0 for `max_acceleration` [m/s^2].
        max_jerk: Greatest change of the acceleration, 0 for none [m/s^3].
        max_velocity: Greatest speed, 0 for none [m/s].
        max_reverse: Greatest speed backwards, 0 for `max_velocity` [m/s].
        max_turn: Greatest turn rate, 0 for none [rad/s].
        max_turn_acceleration: Greatest change of the turn rate, 0 for none [rad/s^2].
        max_turn_deceleration: The same clockwise, 0 for `max_turn_acceleration` [rad/s^2].
        max_turn_jerk: Greatest change of the turn's acceleration, 0 for none [rad/s^3].
        command_timeout: A command holds so long, 0 for ever; None where the file says none [s].
        rate: Rate of the odometry, 0 for each tick [Hz].
        base_frame: Its child frame; "" for the root link.
        from_world: Whether odometry is the truth rather than the encoders' sum.
        begins_in_world: Whether odometry begins at the robot's pose in the world, of a Gazebo that
            launch files start: Classic's drives take it from there unless told otherwise.
        stamped: Whether commands are TwistStamped.
        publishes: Which outputs are on, by name (`odom`, `odom_tf`, `wheel_tf`, `joint_states`).
        is_bridged: Whether it is Gazebo Sim's, whose transform ROS sees where a bridge hands it on.
        kind: How the wheels move the robot.
        grips: For each wheel, where wheels have rollers, the unit vector along which they grip, in
            the root's frame; across it they roll.
        steering: Names of the joints that steer wheels.
        steering_limit: How far they turn at most [rad].
        free: Names of the joints of wheels that nothing drives.
        is_guessed: Whether no file names its wheels.
    """

    left: tuple[str, ...]
    right: tuple[str, ...]
    separation: float
    radius: float
    torque: float
    effective_track: float
    effective_radius: float
    plugin: str = ""
    max_acceleration: float = 0.0
    max_velocity: float = 0.0
    max_reverse: float = 0.0
    max_turn: float = 0.0
    max_turn_acceleration: float = 0.0
    max_deceleration: float = 0.0
    max_jerk: float = 0.0
    max_turn_deceleration: float = 0.0
    max_turn_jerk: float = 0.0
    command_timeout: float | None = None
    rate: float = 0.0
    command_topic: str = "cmd_vel"
    odometry_topic: str = "odom"
    odometry_frame: str = "odom"
    base_frame: str = ""
    from_world: bool = False
    begins_in_world: bool = False
    stamped: bool = False
    publishes: tuple[str, ...] = ("odom", "odom_tf")
    is_bridged: bool = False
    kind: DriveKind = DriveKind.SIDES
    grips: tuple[tuple[float, float], ...] = ()
    steering: tuple[str, ...] = ()
    steering_limit: float = 0.0
    free: tuple[str, ...] = ()
    is_guessed: bool = False

    @property
    def wheels(self) -> tuple[str, ...]:
        """Names of all driven joints, left ones first."""
        return self.left + self.right

    @property
    def rolling(self) -> tuple[str, ...]:
        """Names of the joints of all wheels, driven ones first."""
        return self.wheels + self.free

    @property
    def diameter(self) -> float:
        """The wheels' diameter [m]."""
        return 2.0 * self.radius

    @property
    def tells_truth(self) -> bool:
        """True where its file asks for the true odometry, and leaves its frame to no filter."""
        return self.from_world and "odom_tf" in self.publishes

    @property
    def fused_topic(self) -> str:
        """The topic on which a filter of wheels and gyro publishes the odometry."""
        own = self.odometry_topic
        return "odom" if own.lstrip("/") == WHEEL_ODOMETRY else own

    def standard(self) -> DriveSettings:
        """Return it with the standard topics and the transform `odom` to the robot's root."""
        return replace(
            self,
            command_topic="cmd_vel",
            stamped=False,
            odometry_topic="odom",
            odometry_frame="odom",
            is_bridged=False,
            publishes=tuple(dict.fromkeys((*self.publishes, "odom", "odom_tf"))),
        )


@dataclass(frozen=True, kw_only=True)
class SensorSettings:
    """Settings that all sensors have; each kind in `devices/sensors` adds its own.

    Attributes:
        TITLE: Name of the kind.
        IS_PRIMARY: Whether the first of this kind serves the rest of the robot.
        IS_OPTICAL: Whether its messages are in an optical frame (REP 103).
        TOPIC: The standard topic of a primary kind.
        link: The link that carries it.
        frame: The frame that its messages name.
        rate: [Hz].
        name: Its name in the file.
        pose: Its pose in the link.
        serves: Whether it may be the first of a primary kind.
        is_named: Whether its file names its topic, which is its own then, wherever it stands.
    """

    TITLE: ClassVar[str] = "sensor"
    IS_PRIMARY: ClassVar[bool] = False
    IS_OPTICAL: ClassVar[bool] = False
    TOPIC: ClassVar[str] = ""

    link: str
    frame: str
    rate: float
    topic: str
    name: str = ""
    pose: Pose3 = ORIGIN
    serves: bool = True
    is_named: bool = False

    def __post_init__(self) -> None:
        """Spell its topics as ROS can."""
        for name in (each.name for each in fields(self) if each.name.endswith("topic")):
            if isinstance(topic := getattr(self, name), str):
                object.__setattr__(self, name, spelled(topic))

    @property
    def site(self) -> str:
        """Name of its MuJoCo site: the link's, where it sits at the link's origin."""
        return self.link if self.pose == ORIGIN else f"{self.link}//{self.name}"

    @property
    def is_first(self) -> bool:
        """True for the one of a primary kind that serves the rest of the robot."""
        return self.IS_PRIMARY and self.serves

    @property
    def title(self) -> str:
        """The kind's name, as a person reads it."""
        return self.TITLE

    def details(self) -> str:
        """Return the kind's own values for a person; "" for none."""
        return ""

    def standard(self: S) -> S:
        """Return it with its kind's standard topics."""
        return replace(self, topic=self.TOPIC)


class PublishedPoses(NamedTuple):
    """Which poses gz-sim's PosePublisher publishes of a robot: its own, those of its links."""

    of_model: bool = True
    of_links: bool = False


@dataclass(frozen=True)
class GazeboSettings:
    """A robot's Gazebo tags, but for its drive.

    Attributes:
        sensors: The primary ones first: the planar lidar that sees most, the first colour camera
            and the first IMU; then the others in the file's order.
        friction: By link, the friction of its shapes.
        colours: By link, the colour of its material.
        stiffness: By link, `kp` and `kd` as the file has them; contacts keep the simulator's own.
        driven: The joints that have a motor, beside wheels and their steering.
        controllers: What commands them, in the file's order.
        hardware: Name and class of what ros2_control calls the hardware; "" for none.
        reported: The joints whose states are published; none for all that move.
        report_rate: How often, 0 for each tick [Hz].
        poses: Which are published on `/model/NAME/pose`.
    """

    sensors: tuple[SensorSettings, ...] = ()
    friction: dict[str, float] = field(default_factory=dict)
    colours: dict[str, tuple[float, ...]] = field(default_factory=dict)
    stiffness: dict[str, dict[str, float]] = field(default_factory=dict)
    driven: tuple[DrivenJoint, ...] = ()
    controllers: tuple[ControllerSettings, ...] = ()
    hardware: tuple[str, str] = ("", "")
    reported: tuple[str, ...] = ()
    report_rate: float = 0.0
    poses: PublishedPoses = field(default_factory=PublishedPoses)

    def first(self, kind: type[S]) -> S | None:
        """Return the first sensor of just this kind that serves the robot, None for none."""
        return next((s for s in self.sensors if type(s) is kind and s.serves), None)

    @property
    def further(self) -> tuple[SensorSettings, ...]:
        """The sensors that are not the first of a primary kind, in the file's order."""
        return tuple(sensor for sensor in self.sensors if not sensor.is_first)

    def standard(self) -> GazeboSettings:
        """Return them with the first sensors on the standard topics, which no other one has."""
        taken = {sensor.TOPIC for sensor in self.sensors if sensor.is_first}
        sensors = (
            sensor.standard()
            if sensor.is_first
            else replace(sensor, topic=f"{sensor.name}/{sensor.topic.lstrip('/')}")
            if sensor.topic.lstrip("/") in taken
            else sensor
            for sensor in self.sensors
        )
        return replace(self, sensors=tuple(sensors))


Reader = Callable[[Any], Sequence[SensorSettings]]
"""Returns the settings of the sensors that a `SensorTag` describes."""
Choice = Callable[[Sequence[SensorSettings], Urdf], SensorSettings | None]
"""Returns which of all sensors, or what of one, serves the rest of the robot; None for none."""
R = TypeVar("R", bound=Reader)
C = TypeVar("C", bound=Choice)
_PACKAGE = ".".join((*__name__.split(".")[:-2], "devices", "sensors"))
_readers: dict[str, Reader] = {}
_choices: dict[int, Choice] = {}


class SensorKinds(NamedTuple):
    """All kinds: readers by the tags' types, and the choices of the primary sensors."""

    readers: dict[str, Reader]
    choices: tuple[Choice, ...]


def reads(*types: str) -> Callable[[R], R]:
    """Register the reader of `<sensor>` tags of some types."""

    def registered(reader: R) -> R:
        _readers.update(dict.fromkeys(types, reader))
        return reader

    return registered


def chooses(rank: int) -> Callable[[C], C]:
    """Register the choice of a kind's primary sensor; those of lower rank come first."""

    def registered(choice: C) -> C:
        _choices[rank] = choice
        return choice

    return registered


@cache
def sensor_kinds() -> SensorKinds:
    """Return all kinds; their files are imported by name, as plug-ins."""
    package = importlib.import_module(_PACKAGE)
    for module in pkgutil.iter_modules(package.__path__):
        importlib.import_module(f"{_PACKAGE}.{module.name}")
    return SensorKinds(
        dict(sorted(_readers.items())), tuple(_choices[rank] for rank in sorted(_choices))
    )
