"""What a robot's file says of its drive and sensors, as typed values."""

from __future__ import annotations

from dataclasses import dataclass, field

TOPICS = {"lidar": "scan", "camera": "camera/image_raw", "depth": "camera/depth", "imu": "imu/data"}
"""Topics of sensors whose file names none."""


@dataclass(frozen=True)
class DriveSettings:
    """A skid-steer or differential drive.

    Attributes:
        left: Names of the left wheels' joints.
        right: Names of the right wheels' joints.
        separation: Distance between left and right wheels [m].
        radius: Wheels' radius [m].
        torque: Greatest torque of each wheel [N m].
        effective_track: Track of the two-wheeled robot that turns like this one [m].
        effective_radius: Radius that makes wheel turns into distance [m].
        plugin: Name of the plugin that was read; "" for a guess.
        max_acceleration: Greatest change of the wheels' speed at the ground, 0 for none [m/s^2].
        max_velocity: Greatest speed, 0 for none [m/s].
        rate: Rate of the odometry, 0 for each tick [Hz].
        command_topic: Where commands come from.
        odometry_topic: Where odometry goes.
        odometry_frame: Its frame.
        base_frame: Its child frame; "" for the root link.
        from_world: Whether odometry is the truth rather than the encoders' sum.
        publishes: Which outputs are on, by name (`odom`, `odom_tf`, `wheel_tf`, `joint_states`).
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
    rate: float = 0.0
    command_topic: str = "cmd_vel"
    odometry_topic: str = "odom"
    odometry_frame: str = "odom"
    base_frame: str = ""
    from_world: bool = False
    publishes: tuple[str, ...] = ("odom", "odom_tf")

    @property
    def wheels(self) -> tuple[str, ...]:
        """Names of all driven joints, left ones first."""
        return self.left + self.right

    @property
    def diameter(self) -> float:
        """The wheels' diameter [m]."""
        return 2.0 * self.radius


@dataclass(frozen=True)
class LidarSettings:
    """A planar lidar: angles [rad], ranges [m], rate [Hz], standard deviation of noise [m]."""

    link: str
    frame: str
    samples: int
    angle_min: float
    angle_max: float
    range_min: float
    range_max: float
    rate: float
    noise: float
    topic: str = TOPICS["lidar"]


@dataclass(frozen=True)
class CameraSettings:
    """A camera: size [pixels], field of view [rad], clip distances [m], rate [Hz]."""

    link: str
    frame: str
    width: int
    height: int
    horizontal_fov: float
    near: float
    far: float
    rate: float
    topic: str = TOPICS["camera"]
    depth: bool = False


@dataclass(frozen=True)
class ImuSettings:
    """An IMU: rate [Hz]."""

    link: str
    frame: str
    rate: float
    topic: str = TOPICS["imu"]


@dataclass(frozen=True)
class GazeboSettings:
    """All that the Gazebo tags say and the simulation understands.

    Attributes:
        drive: The drive, where a plugin names one.
        lidar: The first lidar.
        camera: The first colour camera, else the first depth camera.
        imu: The first IMU.
        friction: By link, the friction of its shapes.
        colours: By link, the colour of its material.
        stiffness: By link, `kp` and `kd` as the file has them; contacts keep the simulator's own.
        planar: Whether a planar-move plugin moves the robot, so that its wheels need a grip.
    """

    drive: DriveSettings | None
    lidar: LidarSettings | None
    camera: CameraSettings | None
    imu: ImuSettings | None
    friction: dict[str, float]
    colours: dict[str, tuple[float, ...]] = field(default_factory=dict)
    planar: bool = False
    stiffness: dict[str, dict[str, float]] = field(default_factory=dict)
