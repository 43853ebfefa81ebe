"""Parameters of the amcl node."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

from arjuna_core.config import SEED_MAX, param
from arjuna_slam.amcl.config import AmclConfig

ALWAYS, NEVER, AUTO = "always", "never", "auto"


@dataclass(frozen=True)
class InitialPose:
    """Pose of the base in the map at the start."""

    x: float = param(0.0, "Position.", unit="m")
    y: float = param(0.0, "Position.", unit="m")
    z: float = param(0.0, "Position; unused, for compatibility.", unit="m")
    yaw: float = param(0.0, "Heading.", unit="rad")


@dataclass(frozen=True)
class AmclNodeConfig(AmclConfig):
    """Parameters of amcl: the filter's, and those of the node."""

    base_frame_id: str = param("base_footprint", "Frame of the robot's base.", read_only=True)
    global_frame_id: str = param("map", "Frame of the map.", read_only=True)
    odom_frame_id: str = param("odom", "Frame of the odometry.", read_only=True)
    scan_topic: str = param("scan", "Topic of the scans.", read_only=True)
    map_topic: str = param("map", "Topic of the map.", read_only=True)
    transform_tolerance: float = param(
        0.2,
        "How far into the future map -> odom is dated. Who interpolates transforms sees each "
        "correction so much later; hence less than nav2_amcl's 1.0, more than a scan's period.",
        unit="s",
        minimum=0.0,
    )
    tf_broadcast: bool = param(True, "Whether to broadcast map -> odom.")
    set_initial_pose: bool = param(False, "Whether to start at initial_pose.")
    initial_pose: InitialPose = InitialPose()
    always_reset_initial_pose: bool = param(
        False, "Whether each activation starts anew instead of at the last known pose."
    )
    first_map_only: bool = param(False, "Whether to ignore maps after the first.")
    global_localization_at_start: str = param(
        AUTO,
        "Whether to search the whole map at the start: always, never, or where no initial pose is "
        "given.",
        choices=(ALWAYS, NEVER, AUTO),
    )
    save_pose_rate: float = param(
        0.5,
        "How often the pose is written to initial_pose while it is tracked; 0 is never.",
        unit="Hz",
        minimum=0.0,
    )
    seed: int = param(0, "Seed of all randomness.", minimum=0, maximum=SEED_MAX, read_only=True)


def filter_part(config: AmclNodeConfig) -> tuple[Any, ...]:
    """Return the values that the filter depends on."""
    return tuple(getattr(config, item.name) for item in fields(AmclConfig))
