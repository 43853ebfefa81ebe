"""Parameters of the node `sim`."""

from __future__ import annotations

import re
from dataclasses import dataclass, field

from arjuna_core.config import SEED_MAX, fixed, param
from arjuna_core.errors import ConfigError
from arjuna_core.se2 import SE2
from arjuna_sim.config import SimulatorConfig
from arjuna_sim.model.settings import WHEEL_ODOMETRY

NAMESPACE = re.compile(r"[A-Za-z_][A-Za-z0-9_]*(/[A-Za-z_][A-Za-z0-9_]*)*")


@dataclass(frozen=True)
class InitialPose:
    """The start of the robot in the world."""

    x: float = fixed(0.0, "Place.", unit="m")
    y: float = fixed(0.0, "Place.", unit="m")
    yaw: float = fixed(0.0, "Heading.", unit="rad")

    @property
    def asked(self) -> SE2 | None:
        """The pose; None where all is 0, since nobody asks for that."""
        return SE2(self.x, self.y, self.yaw) if self.x or self.y or self.yaw else None


@dataclass(frozen=True)
class SimConfig(SimulatorConfig):
    """Parameters of the node `sim`, over those of the simulator."""

    robot: str = param(
        "", "The robot's URDF, xacro or SDF file; empty takes the shipped one.", path=True
    )
    robot_arguments: str = fixed(
        "", "Arguments of the robot's xacro file, each name:=value, as in a shell."
    )
    world: str = param(
        "", "The world's SDF file or map YAML; empty takes the shipped room.", path=True
    )
    seed: int = fixed(0, "Seed of all noise.", minimum=0, maximum=SEED_MAX)
    real_time_factor: float = param(
        1.0, "Simulated per real time; 0 is as fast as it goes.", minimum=0.0, maximum=1000.0
    )
    enable_stamped_cmd_vel: bool = fixed(
        False,
        "Whether cmd_vel is TwistStamped instead of Twist; that of the two which alone is published"
        " is taken, whatever this says.",
    )
    publish_ground_truth: bool = fixed(
        True,
        "Whether ground_truth/odom is published, and the static transform world -> map: maps have"
        " the world's coordinates, those of slam_toolbox where odometry begins with them.",
    )
    resource_folder: str = param(
        ".",
        "Folder that spawn_entity and load_world may read files below, beside the shipped worlds"
        " and robots, packages and models; the working folder if '.'.",
        path=True,
    )
    standard_topics: bool = fixed(
        False,
        "Whether commands, odometry and sensors have the standard topics (cmd_vel, odom, scan,"
        " imu/data, camera/image_raw) and odom its transform, whatever the robot's file says.",
    )
    fused_odometry: bool = fixed(
        False,
        "Whether ekf_filter_node makes odometry of the wheels and the IMU: the wheels' own goes to"
        " wheel_odom then, without a transform. Not where the robot's file asks for the world's,"
        " nor where it steers or moves to the side.",
    )
    wheel_odometry: str = fixed(
        WHEEL_ODOMETRY,
        "Topic of the wheels' odometry where ekf_filter_node makes another of it; that of the"
        " robot's file if empty.",
    )
    frames_of_file: bool = fixed(
        False,
        "Whether sensors have the frames that the robot's file names, as in Gazebo, rather than"
        " ones where they are: for a robot_state_publisher of yours, which knows no others. That of"
        " Gazebo Classic's drives begins at the pose in the world then, unless told otherwise.",
    )
    transform_rate: float = fixed(
        10.0,
        "Least rate of the transform from odom, and of wheels whose odometry is fused, also where"
        " the robot's file publishes less often: navigation takes nothing older than some tenths"
        " of a second.",
        unit="Hz",
        minimum=0.0,
    )
    cloud_rate: float = fixed(
        0.0,
        "Most clouds a second of each depth camera, while nobody looks at its pictures; 0 for as"
        " many as its file says. Each takes some 20 ms without a GPU.",
        unit="Hz",
        minimum=0.0,
    )
    initial_pose: InitialPose = field(default_factory=InitialPose)
    placed_by_estimate: bool = fixed(
        False,
        "Whether a pose on 'initialpose' puts the robot there, as in Nav2's loopback simulator: the"
        " world is then that of the map.",
    )
    viewer: bool = fixed(
        False,
        "Whether MuJoCo's own viewer shows the world, in real time and where there is a screen.",
    )
    resume_file: str = param(
        "", "Keeps time and poses, to go on there after a crash; empty: no.", path=True
    )
    namespaces: tuple[str, ...] = fixed(
        (),
        "Namespaces of several robots, each with nodes, topics, /tf and /clock of its own below"
        " it; empty for one robot, in the simulator's own.",
    )
    robots: tuple[str, ...] = param(
        (), "Their files, one for each namespace; empty takes 'robot' for all.", path=True
    )
    starts: tuple[float, ...] = fixed(
        (),
        "Where they start, x, y and yaw of one after the other; empty takes 'initial_pose' for the"
        " first and what is free beside it for the others.",
        unit="m, m, rad",
    )

    def __post_init__(self) -> None:
        """Refuse robots that lack a namespace of their own, or a start."""
        super().__post_init__()
        names = [name.strip("/") for name in self.namespaces]
        for name in names:
            if not NAMESPACE.fullmatch(name):
                raise ConfigError(f"'{name}' is no namespace; valid: as a or a/b")
            if names.count(name) > 1:
                problem = f"namespace '{name}' is given {names.count(name)} times"
                raise ConfigError(f"{problem}; each robot needs one of its own")
        if self.robots and len(self.robots) != len(names):
            problem = f"{len(self.robots)} robots and {len(names)} namespaces"
            raise ConfigError(f"{problem} are given; each robot needs one of its own")
        if self.starts and len(self.starts) != 3 * len(names):
            problem = f"{len(self.starts)} numbers for the starts of {len(names)} robots"
            raise ConfigError(f"{problem}; each takes x, y and yaw")
