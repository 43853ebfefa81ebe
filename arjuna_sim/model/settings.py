"""What a robot's file says of its drive and sensors, as typed values."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum

from arjuna_core.pose3 import ORIGIN, Pose3

TOPICS = {"lidar": "scan", "camera": "camera/image_raw", "depth": "camera/depth", "imu": "imu/data"}
"""Topics of sensors whose file names none."""


class DriveKind(Enum):
    """How wheels move a robot."""

    SIDES = "differential or skid-steer"
    MECANUM = "mecanum wheels"
    OMNI = "omni wheels"
    STEERED = "steered wheels"
    PLANAR = "moved in the plane"
    """What a file asks for; wheels of another kind stand for it."""


@dataclass(frozen=True)
class DriveSettings:
    """What turns wheels, and which.

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
        max_velocity: Greatest speed, 0 for none [m/s].
        max_reverse: Greatest speed backwards, 0 for `max_velocity` [m/s].
        max_turn: Greatest turn rate, 0 for none [rad/s].
        max_turn_acceleration: Greatest change of the turn rate, 0 for none [rad/s^2].
        command_timeout: A command holds so long, 0 for ever; None where the file says none [s].
        rate: Rate of the odometry, 0 for each tick [Hz].
        command_topic: Where commands come from.
        odometry_topic: Where odometry goes.
        odometry_frame: Its frame.
        base_frame: Its child frame; "" for the root link.
        from_world: Whether odometry is the truth rather than the encoders' sum.
        stamped: Whether commands are TwistStamped.
        publishes: Which outputs are on, by name (`odom`, `odom_tf`, `wheel_tf`, `joint_states`).
        kind: How the wheels move the robot.
        grips: For each wheel, where wheels have rollers, the unit vector along which they grip, in
            the root's frame; across it they roll.
        steering: Names of the joints that steer wheels.
        steering_limit: How far they turn at most [rad].
        free: Names of the joints of wheels that nothing drives.
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
    command_timeout: float | None = None
    rate: float = 0.0
    command_topic: str = "cmd_vel"
    odometry_topic: str = "odom"
    odometry_frame: str = "odom"
    base_frame: str = ""
    from_world: bool = False
    stamped: bool = False
    publishes: tuple[str, ...] = ("odom", "odom_tf")
    kind: DriveKind = DriveKind.SIDES
    grips: tuple[tuple[float, float], ...] = ()
    steering: tuple[str, ...] = ()
    steering_limit: float = 0.0
    free: tuple[str, ...] = ()

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


@dataclass(frozen=True, kw_only=True)
class SensorSettings:
    """What all sensors have.

    Attributes:
        link: The link that carries it.
        frame: The frame that its messages name.
        rate: [Hz].
        topic: Where its messages go.
        name: Its name in the file.
        pose: Its pose in the link.
    """

    link: str
    frame: str
    rate: float
    topic: str
    name: str = ""
    pose: Pose3 = ORIGIN

    @property
    def site(self) -> str:
        """Name of its MuJoCo site: the link's, where it sits at the link's origin."""
        return self.link if self.pose == ORIGIN else f"{self.link}//{self.name}"


@dataclass(frozen=True, kw_only=True)
class LidarSettings(SensorSettings):
    """A planar lidar: angles [rad], ranges [m], standard deviation of noise [m]."""

    samples: int
    angle_min: float
    angle_max: float
    range_min: float
    range_max: float
    noise: float
    topic: str = TOPICS["lidar"]


@dataclass(frozen=True, kw_only=True)
class CloudSettings(LidarSettings):
    """A lidar of several rows, and how far the lowest and the highest tilt upward [rad]."""

    rows: int
    tilt_min: float
    tilt_max: float


@dataclass(frozen=True, kw_only=True)
class RangeSettings(CloudSettings):
    """A sonar or infrared sensor, which tells the nearest range in its cone."""

    infrared: bool = False


@dataclass(frozen=True, kw_only=True)
class CameraSettings(SensorSettings):
    """A camera: size [pixels], field of view [rad], clip distances [m].

    Attributes:
        depth: Whether it tells distances rather than colours first.
        depth_topic: Where distances go; "" for `depth/image_raw` beside the colours.
        cloud_topic: Where its points go; "" for none.
        info_topic: Where its calibration goes; "" for `camera_info` beside the colours.
    """

    width: int
    height: int
    horizontal_fov: float
    near: float
    far: float
    topic: str = TOPICS["camera"]
    depth: bool = False
    depth_topic: str = ""
    cloud_topic: str = ""
    info_topic: str = ""


@dataclass(frozen=True, kw_only=True)
class ImuSettings(SensorSettings):
    """An IMU.

    Attributes:
        gyro_noise: Standard deviation of a turn rate; None where the file names none [rad/s].
        accel_noise: Of an acceleration; None where the file names none [m/s^2].
    """

    topic: str = TOPICS["imu"]
    gyro_noise: float | None = None
    accel_noise: float | None = None


@dataclass(frozen=True, kw_only=True)
class NavSatSettings(SensorSettings):
    """A GPS: standard deviations of its position, level and upright [m]."""

    noise: float = 0.0
    height_noise: float = 0.0


@dataclass(frozen=True, kw_only=True)
class MagnetometerSettings(SensorSettings):
    """A compass: standard deviation of the field [T]."""

    noise: float = 0.0


@dataclass(frozen=True, kw_only=True)
class AltimeterSettings(SensorSettings):
    """An altimeter: standard deviation of the height above its start [m]."""

    noise: float = 0.0


@dataclass(frozen=True, kw_only=True)
class BumperSettings(SensorSettings):
    """A bumper: what the link's collision shapes touch."""


@dataclass(frozen=True)
class GazeboSettings:
    """All that the Gazebo tags say and the simulation understands.

    Attributes:
        drive: The drive, where a plugin names one.
        lidar: The planar lidar that sees most; the level plane of a lidar of several rows where
            there is no other.
        camera: The first colour camera, else the first depth camera.
        imu: The first IMU.
        friction: By link, the friction of its shapes.
        colours: By link, the colour of its material.
        stiffness: By link, `kp` and `kd` as the file has them; contacts keep the simulator's own.
        kind: The kind of drive that a plugin names; None for none.
        further: The sensors beside those three, in the file's order.
        grips: By link, the unit vector of the ground along which friction acts.
        uneven: What to note of links that rub otherwise along and across, unless they have rollers.
        told: Topics, frames and limits of a plugin that names no wheels.
    """

    drive: DriveSettings | None
    lidar: LidarSettings | None
    camera: CameraSettings | None
    imu: ImuSettings | None
    friction: dict[str, float]
    colours: dict[str, tuple[float, ...]] = field(default_factory=dict)
    kind: DriveKind | None = None
    stiffness: dict[str, dict[str, float]] = field(default_factory=dict)
    further: tuple[SensorSettings, ...] = ()
    grips: dict[str, tuple[float, float]] = field(default_factory=dict)
    uneven: tuple[str, ...] = ()
    told: DriveSettings | None = None

    @property
    def sensors(self) -> tuple[SensorSettings, ...]:
        """All sensors, the first of the usual kinds first."""
        first = [s for s in (self.lidar, self.camera, self.imu) if s is not None]
        return (*first, *self.further)
