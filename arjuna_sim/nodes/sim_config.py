"""Parameters of the node `sim`."""

from __future__ import annotations

from dataclasses import dataclass, field

from arjuna_core.config import SEED_MAX, param
from arjuna_sim.config import SimulatorConfig


@dataclass(frozen=True)
class InitialPose:
    """Where the robot starts in the world."""

    x: float = param(0.0, "Place.", unit="m", read_only=True)
    y: float = param(0.0, "Place.", unit="m", read_only=True)
    yaw: float = param(0.0, "Heading.", unit="rad", read_only=True)


@dataclass(frozen=True)
class SimConfig(SimulatorConfig):
    """Parameters of the node `sim`, over those of the simulator."""

    robot: str = param(
        "", "The robot's URDF, xacro or SDF file; empty takes the shipped one.", read_only=True
    )
    robot_arguments: str = param(
        "", "Arguments of the robot's xacro file, each name:=value, as in a shell.", read_only=True
    )
    world: str = param(
        "", "The world's SDF file or map YAML; empty takes the shipped room.", read_only=True
    )
    seed: int = param(0, "Seed of all noise.", minimum=0, maximum=SEED_MAX, read_only=True)
    real_time_factor: float = param(
        1.0, "Simulated per real time; 0 is as fast as it goes.", minimum=0.0, maximum=1000.0
    )
    enable_stamped_cmd_vel: bool = param(
        False, "Whether cmd_vel is TwistStamped instead of Twist.", read_only=True
    )
    publish_ground_truth: bool = param(
        True,
        "Whether ground_truth/odom is published, and the static transform world -> map: maps have"
        " the world's coordinates, those of slam_toolbox if the robot starts at the origin.",
        read_only=True,
    )
    resource_folder: str = param(
        ".",
        "Folder that spawn_entity and load_world may read files below, beside the shipped worlds"
        " and robots, packages and models; the working folder if '.'.",
        read_only=True,
    )
    standard_topics: bool = param(
        False,
        "Whether commands, odometry and sensors have the standard topics (cmd_vel, odom, scan,"
        " imu/data, camera/image_raw) and odom its transform, whatever the robot's file says.",
        read_only=True,
    )
    fused_odometry: bool = param(
        False,
        "Whether ekf_filter_node makes odometry of the wheels and the IMU: the wheels' own goes to"
        " wheel_odom then, without a transform. Not where the robot's file asks for the world's,"
        " nor where it steers or moves to the side.",
        read_only=True,
    )
    initial_pose: InitialPose = field(default_factory=InitialPose)
