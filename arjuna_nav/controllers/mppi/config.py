"""Parameters of MPPI and its critics, by Nav2's names."""

from __future__ import annotations

from dataclasses import dataclass, field

from arjuna_core.config import (
    angle_param,
    duration_param,
    length_param,
    param,
    plugin_names,
    speed_param,
    yaw_rate_param,
)
from arjuna_core.plugins import PluginTypes
from arjuna_nav.controllers.base import PluginConfig, with_defaults

NAV2_CRITICS = (
    *("ConstraintCritic", "CostCritic", "ObstaclesCritic", "GoalCritic", "GoalAngleCritic"),
    *("PathAlignCritic", "PathFollowCritic", "PathAngleCritic", "PreferForwardCritic"),
    *("TwirlingCritic", "VelocityDeadbandCritic"),
)
CRITICS = PluginTypes("critic", {}, "", {name: f"mppi::critics::{name}" for name in NAV2_CRITICS})
"""A user's own; Nav2's need no class, for their names say it."""
_STOCK = (
    *("ConstraintCritic", "CostCritic", "GoalCritic", "GoalAngleCritic", "PathAlignCritic"),
    *("PathFollowCritic", "PathAngleCritic", "PreferForwardCritic"),
)


@dataclass(frozen=True)
class CriticConfig:
    """Parameters of every critic."""

    enabled: bool = param(True, "Whether the critic counts.")
    cost_power: int = param(1, "Power of its cost.", minimum=0, maximum=100)
    cost_weight: float = param(1.0, "Weight.", minimum=0.0)


@dataclass(frozen=True)
class NearGoalConfig(CriticConfig):
    """A critic that counts nearer or farther from the goal than a distance."""

    threshold_to_consider: float = length_param(
        0.5, "Distance from the goal within which, or beyond which, it counts.", minimum=0
    )


@dataclass(frozen=True)
class GoalAngleConfig(NearGoalConfig):
    """Scores the heading near the goal."""

    symmetric_yaw_tolerance: bool = param(False, "Whether the robot may arrive backwards.")


@dataclass(frozen=True)
class NearObstaclesConfig(CriticConfig):
    """A critic of the costs near obstacles."""

    inflation_layer_name: str = param(
        "", "The costmap's inflation layer by which costs show distances; its last if empty."
    )
    consider_footprint: bool = param(False, "Whether the outline counts, else the centre.")
    near_goal_distance: float = length_param(
        0.5, "Distance from the goal within which only what is critical counts.", minimum=0
    )


@dataclass(frozen=True)
class CostConfig(NearObstaclesConfig):
    """Scores the costs along a rollout."""

    critical_cost: float = param(300.0, "Cost of a pose near a collision.", minimum=0.0)
    collision_cost: float = param(1e6, "Cost of a collision.", minimum=0.0, maximum=1e12)
    near_collision_cost: int = param(
        253, "Costmap's cost from which a pose is near one.", minimum=0, maximum=255
    )
    trajectory_point_step: int = param(2, "Every which pose is looked at.", minimum=1)


@dataclass(frozen=True)
class ObstaclesConfig(NearObstaclesConfig):
    """Scores the distance from obstacles by the costs."""

    repulsion_weight: float = param(1.5, "Weight of being near obstacles.", minimum=0.0)
    critical_weight: float = param(20.0, "Weight within the margin.", minimum=0.0)
    collision_cost: float = param(1e5, "Cost of a collision.", minimum=0.0, maximum=1e12)
    collision_margin_distance: float = length_param(0.1, "The margin.")
    inflation_cost_scaling_factor: float = param(
        3.0, "The costmap's cost_scaling_factor, where it has none.", unit="1/m", minimum=0.01
    )


@dataclass(frozen=True)
class PathAlignConfig(NearGoalConfig):
    """Scores the distance of a rollout from the path, pose by pose."""

    max_path_occupancy_ratio: float = param(
        0.07, "Share of blocked path from which it does not count.", minimum=0.0
    )
    offset_from_furthest: int = param(
        20, "Poses of the path to be reached before it counts.", minimum=0
    )
    trajectory_point_step: int = param(4, "Every which pose is looked at.", minimum=1)
    use_path_orientations: bool = param(
        False, "Whether the headings count too, a radian as a metre."
    )


@dataclass(frozen=True)
class PathFollowConfig(NearGoalConfig):
    """Scores the distance of a rollout's end from a pose ahead on the path."""

    offset_from_furthest: int = param(6, "Poses beyond the farthest reached.", minimum=0)


@dataclass(frozen=True)
class PathAngleConfig(NearGoalConfig):
    """Scores the angle between a rollout's end and a pose ahead on the path."""

    offset_from_furthest: int = param(4, "Poses beyond the farthest reached.", minimum=0)
    max_angle_to_furthest: float = angle_param(0.785398, "Angle from which it counts.")
    mode: int = param(
        0,
        "0: forwards; 1: whichever is nearer; 2: as the path's poses look. Forwards where vx_min is"
        " not below 0.",
        choices=(0, 1, 2),
    )


@dataclass(frozen=True)
class DeadbandConfig(CriticConfig):
    """Scores velocities that the drive does not follow."""

    deadband_velocities: tuple[float, ...] = param(
        (0.0, 0.0, 0.0), "Least |x|, |y| and |theta| that move the robot.", unit="m/s, rad/s"
    )


@dataclass(frozen=True)
class AckermannConfig:
    """Limits of a robot with steered wheels."""

    min_turning_r: float = length_param(0.2, "Least turning radius.")


@dataclass(frozen=True)
class VisualizerConfig:
    """Parameters of showing rollouts."""

    trajectory_step: int = param(5, "Every which rollout is shown.", minimum=1)
    time_step: int = param(3, "Every which of its poses is shown.", minimum=1)


@dataclass(frozen=True)
class MppiConfig(PluginConfig):
    """Parameters of MPPI."""

    time_steps: int = param(56, "Steps of a rollout.", minimum=2, maximum=2000)
    model_dt: float = duration_param(0.05, "Time of a step.", minimum=0.001, maximum=10.0)
    batch_size: int = param(1000, "Rollouts.", minimum=1, maximum=100_000)
    iteration_count: int = param(1, "Rounds a command.", minimum=1, maximum=1000)
    temperature: float = param(0.3, "How little the costs decide.", minimum=1e-3)
    gamma: float = param(0.015, "Weight of smoothness against the costs.", minimum=0.0)
    vx_max: float = speed_param(0.5, "Greatest forward speed.")
    vx_min: float = param(-0.35, "Least forward speed; negative drives back.", unit="m/s")
    vy_max: float = speed_param(0.5, "Greatest speed sideways, of Omni.")
    wz_max: float = yaw_rate_param(1.9, "Greatest yaw rate.")
    ax_max: float = param(3.0, "Acceleration; of either sign.", unit="m/s^2")
    ax_min: float = param(-3.0, "Deceleration, below 0; of either sign.", unit="m/s^2")
    ay_max: float = param(3.0, "Acceleration to the left, of Omni.", unit="m/s^2")
    ay_min: float = param(-3.0, "Acceleration to the right, below 0.", unit="m/s^2")
    az_max: float = param(3.5, "Change of the yaw rate.", unit="rad/s^2", minimum=0.0)
    vx_std: float = speed_param(0.2, "Deviation of the speeds tried.")
    vy_std: float = speed_param(0.2, "Deviation of the speeds sideways, of Omni.")
    wz_std: float = yaw_rate_param(0.4, "Deviation of the yaw rates tried.")
    noise_time: float = duration_param(
        0.3, "Correlation time of the noise; 0 for Nav2's white noise.", minimum=0, theirs=0.0
    )
    motion_model: str = param(
        "DiffDrive",
        "How the robot moves: Omni sideways too, Ackermann on no circle less than min_turning_r.",
        choices=("DiffDrive", "Omni", "Ackermann"),
    )
    AckermannConstraints: AckermannConfig = field(default_factory=AckermannConfig)
    prune_distance: float = length_param(1.5, "How much of the path counts.")
    reach_counts: bool = param(
        True,
        "Whether as much of the path counts as the rollouts can reach, where that is more; else, as"
        " Nav2, prune_distance alone.",
        theirs=False,
    )
    max_robot_pose_search_dist: float = param(
        2.5, "How far along the path the robot is looked for; below 0 all along.", unit="m"
    )
    enforce_path_inversion: bool = param(
        False, "Whether a path that changes its direction is followed part by part."
    )
    inversion_xy_tolerance: float = length_param(
        0.2, "Distance from a part's end within which the next begins."
    )
    inversion_yaw_tolerance: float = angle_param(
        0.4, "Angle from its heading within which it does."
    )
    retry_attempt_limit: int = param(1, "Further tries where every rollout collides.", minimum=0)
    reset_period: float = duration_param(
        1.0, "Time without a command after which it forgets the controls found."
    )
    visualize: bool = param(
        False,
        "Whether `trajectories` shows the rollouts, `optimal_trajectory` the controls found and"
        " `transformed_global_plan` the part of the path that counts.",
    )
    TrajectoryVisualizer: VisualizerConfig = field(default_factory=VisualizerConfig)
    open_loop: bool = param(
        False, "Whether rollouts start from the last command, else from the measured velocity."
    )
    regenerate_noises: bool = param(False, "Whether each command has its own noise.")
    seed: int = param(0, "Seed of the noise.", minimum=0)
    critics: tuple[str, ...] = plugin_names(_STOCK, "The critics.", CRITICS)
    ConstraintCritic: CriticConfig = with_defaults(CriticConfig, cost_weight=4.0)
    CostCritic: CostConfig = with_defaults(CostConfig, cost_weight=3.81)
    ObstaclesCritic: ObstaclesConfig = field(default_factory=ObstaclesConfig)
    GoalCritic: NearGoalConfig = with_defaults(
        NearGoalConfig, cost_weight=5.0, threshold_to_consider=1.4
    )
    GoalAngleCritic: GoalAngleConfig = with_defaults(GoalAngleConfig, cost_weight=3.0)
    PathAlignCritic: PathAlignConfig = with_defaults(PathAlignConfig, cost_weight=10.0)
    PathFollowCritic: PathFollowConfig = with_defaults(
        PathFollowConfig, cost_weight=5.0, threshold_to_consider=1.4
    )
    PathAngleCritic: PathAngleConfig = with_defaults(PathAngleConfig, cost_weight=2.2)
    PreferForwardCritic: NearGoalConfig = with_defaults(NearGoalConfig, cost_weight=5.0)
    TwirlingCritic: CriticConfig = with_defaults(CriticConfig, cost_weight=10.0)
    VelocityDeadbandCritic: DeadbandConfig = with_defaults(DeadbandConfig, cost_weight=35.0)
