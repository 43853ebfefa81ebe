"""Parameters of DWB and its critics, by Nav2's names."""

from __future__ import annotations

from dataclasses import dataclass, field

from arjuna_core.config import (
    angle_param,
    duration_param,
    fixed,
    length_param,
    param,
    plugin_names,
    speed_param,
    yaw_rate_param,
)
from arjuna_core.errors import ConfigError
from arjuna_core.plugins import PluginTypes
from arjuna_nav.controllers.base import PluginConfig, with_defaults

NAV2_CRITICS = (
    *("RotateToGoal", "Oscillation", "BaseObstacle", "ObstacleFootprint", "GoalAlign"),
    *("PathAlign", "PathDist", "GoalDist", "PreferForward", "Twirling"),
)
CRITICS = PluginTypes(
    "critic", {}, "", {name: f"dwb_critics::{name}Critic" for name in NAV2_CRITICS}, "class"
)
"""A user's own; Nav2's need no class, for their names say it."""
_STANDARD, _LIMITED = (
    f"dwb_plugins::{name}Generator" for name in ("StandardTrajectory", "LimitedAccel")
)
_FAN = "arjuna_nav.controllers.dwb.trajectories:"
GENERATORS = PluginTypes(
    "trajectory generator", dict.fromkeys((_STANDARD, _LIMITED), _FAN), _STANDARD, stands_in=True
)
AGGREGATIONS = ("last", "sum", "product")
_STOCK = (
    *("RotateToGoal", "Oscillation", "BaseObstacle", "GoalAlign", "PathAlign", "PathDist"),
    "GoalDist",
)


@dataclass(frozen=True)
class ScaledConfig:
    """A critic, which may have a weight alone."""

    scale: float = param(1.0, "Weight.", minimum=0.0)


@dataclass(frozen=True)
class RotateToGoalConfig(ScaledConfig):
    """Turns on the spot once the position is reached."""

    slowing_factor: float = param(5.0, "Weight of the speed while it comes to rest.", minimum=0.0)
    lookahead_time: float = param(
        -1.0, "When the heading is taken; below 0 at the trajectory's end.", unit="s"
    )


@dataclass(frozen=True)
class OscillationConfig:
    """Forbids to change the sign of a velocity back and forth."""

    scale: float = param(1.0, "Weight; what it forbids is forbidden at any.", minimum=0.0)
    x_only_threshold: float = param(
        0.05,
        "Forward speed above which strafing and turning may change their sign; below 0 at none.",
        unit="m/s",
    )
    oscillation_reset_dist: float = param(
        0.05, "Distance after which all is allowed again; below 0 after none.", unit="m"
    )
    oscillation_reset_angle: float = param(
        0.2, "Angle after which all is allowed again; below 0 after none.", unit="rad"
    )
    oscillation_reset_time: float = param(
        -1.0, "Time after which all is allowed again; below 0 after none.", unit="s"
    )


@dataclass(frozen=True)
class ObstacleConfig(ScaledConfig):
    """Scores the costs under the robot; what collides is forbidden."""

    sum_scores: bool = param(False, "Whether the costs of all poses count, else the last's.")


@dataclass(frozen=True)
class MapGridConfig(ScaledConfig):
    """Scores the distance from the path or its end."""

    aggregation_type: str = param(
        "last",
        "What of a trajectory counts: its last pose's distance, or all poses' added or multiplied.",
        choices=AGGREGATIONS,
    )


@dataclass(frozen=True)
class AlignConfig(MapGridConfig):
    """Scores the distance of a point ahead of the robot, so that its heading matters."""

    forward_point_distance: float = length_param(0.325, "How far ahead the point lies.")


@dataclass(frozen=True)
class PreferForwardConfig(ScaledConfig):
    """Scores driving back, hardly forward, and turning."""

    penalty: float = param(1.0, "Score of driving back or hardly at all.", minimum=0.0)
    strafe_x: float = speed_param(0.1, "Speed that is hardly forward.")
    strafe_theta: float = yaw_rate_param(0.2, "Yaw rate that excuses it.")
    theta_scale: float = param(10.0, "Weight of the yaw rate.", minimum=0.0)


@dataclass(frozen=True)
class DwbConfig(PluginConfig):
    """Parameters of DWB."""

    min_vel_x: float = param(0.0, "Least forward speed; negative drives back.", unit="m/s")
    max_vel_x: float = speed_param(0.5, "Greatest forward speed.")
    min_vel_y: float = param(0.0, "Least speed to the left; negative is right.", unit="m/s")
    max_vel_y: float = speed_param(0.0, "Greatest speed to the left.")
    max_vel_theta: float = yaw_rate_param(1.0, "Greatest yaw rate.")
    min_speed_xy: float = param(
        0.0, "Least speed, unless it turns by min_speed_theta; below 0 any.", unit="m/s"
    )
    max_speed_xy: float = param(0.5, "Greatest speed; below 0 any.", unit="m/s")
    min_speed_theta: float = param(
        0.0,
        "Least yaw rate of a velocity that is slower than min_speed_xy; below 0 any.",
        unit="rad/s",
    )
    acc_lim_x: float = param(2.5, "Acceleration.", unit="m/s^2", minimum=0.0)
    acc_lim_y: float = param(0.0, "Acceleration to a side.", unit="m/s^2", minimum=0.0)
    acc_lim_theta: float = param(3.2, "Change of the yaw rate.", unit="rad/s^2", minimum=0.0)
    decel_lim_x: float = param(-2.5, "Deceleration.", unit="m/s^2", maximum=0.0)
    decel_lim_y: float = param(0.0, "Deceleration to a side.", unit="m/s^2", maximum=0.0)
    decel_lim_theta: float = param(
        -3.2, "Change of the yaw rate to zero.", unit="rad/s^2", maximum=0.0
    )
    vx_samples: int = param(20, "Speeds tried, two at least.", minimum=0, maximum=10_000)
    vy_samples: int = param(5, "Speeds to the left tried, two at least.", minimum=0, maximum=10_000)
    vtheta_samples: int = param(20, "Yaw rates tried, two at least.", minimum=0, maximum=10_000)
    sim_time: float = duration_param(1.7, "Time simulated.", minimum=0.01)
    trajectory_generator_name: str = param(
        _STANDARD,
        "How velocities are sampled: those within reach of sim_time, driven by accelerating; or"
        " those of one command's period, driven at once.",
        choices=tuple(GENERATORS.types),
        class_of=GENERATORS,
    )
    sim_period: float | None = param(
        None, "Period of LimitedAccelGenerator; that of the controller if none.", unit="s"
    )
    discretize_by_time: bool = param(False, "Whether poses are apart by time, else by distance.")
    time_granularity: float = duration_param(
        0.5, "Greatest time between two poses, if by time.", minimum=0.001
    )
    linear_granularity: float = length_param(
        0.5, "Greatest distance between two poses.", minimum=0.001
    )
    angular_granularity: float = angle_param(
        0.025, "Greatest angle between two poses.", minimum=0.001
    )
    include_last_point: bool = param(
        True, "Whether a trajectory's last pose counts twice where all costs do, as Nav2 has it."
    )
    limit_vel_cmd_in_traj: bool = param(
        False,
        "Whether the command is a trajectory's first velocity, else the one that it tends to.",
    )
    prune_plan: bool = param(
        True,
        "Whether the path behind the robot is forgotten, else what of it the costmap shows counts.",
    )
    shorten_transformed_plan: bool = param(
        True, "Whether forward_prune_distance ends the path that counts, else the costmap does."
    )
    prune_distance: float = length_param(2.0, "How far along the path the robot is looked for.")
    forward_prune_distance: float = length_param(2.0, "How much of the path counts.")
    xy_goal_tolerance: float | None = param(
        None, "Distance that RotateToGoal takes as arrived, the goal checker's at most.", unit="m"
    )
    trans_stopped_velocity: float = speed_param(0.25, "Speed that counts as standing.")
    short_circuit_trajectory_evaluation: bool = param(
        True, "Whether the critics stop at a trajectory that is no longer the best."
    )
    debug_trajectory_details: bool = param(
        False, "Whether a failure says which critic forbids how many trajectories."
    )
    publish_evaluation: bool = param(True, "Whether `evaluation` shows all trajectories' scores.")
    publish_global_plan: bool = param(True, "Whether `received_global_plan` shows the path.")
    publish_transformed_plan: bool = param(
        True, "Whether `transformed_global_plan` shows the part of the path that counts."
    )
    publish_local_plan: bool = param(True, "Whether `local_plan` shows the best trajectory.")
    publish_trajectories: bool = param(True, "Whether `marker` shows all trajectories.")
    publish_cost_grid_pc: bool = param(False, "Whether `cost_cloud` shows each cell's scores.")
    marker_lifetime: float = duration_param(0.1, "How long `marker` is shown; 0 for ever.")
    default_critic_namespaces: tuple[str, ...] = fixed(
        (), "Where critics are looked for, `dwb_critics` if nowhere: all are there."
    )
    critics: tuple[str, ...] = plugin_names(_STOCK, "The critics.", CRITICS)
    RotateToGoal: RotateToGoalConfig = with_defaults(RotateToGoalConfig, scale=32.0)
    Oscillation: OscillationConfig = field(default_factory=OscillationConfig)
    BaseObstacle: ObstacleConfig = with_defaults(ObstacleConfig, scale=0.02)
    ObstacleFootprint: ObstacleConfig = with_defaults(ObstacleConfig, scale=0.02)
    PathAlign: AlignConfig = with_defaults(AlignConfig, scale=32.0, forward_point_distance=0.1)
    GoalAlign: AlignConfig = with_defaults(AlignConfig, scale=32.0, forward_point_distance=0.1)
    PathDist: MapGridConfig = with_defaults(MapGridConfig, scale=32.0)
    GoalDist: MapGridConfig = with_defaults(MapGridConfig, scale=32.0)
    PreferForward: PreferForwardConfig = with_defaults(PreferForwardConfig, scale=5.0)
    Twirling: ScaledConfig = field(default_factory=ScaledConfig)

    def __post_init__(self) -> None:
        namespaces = self.default_critic_namespaces
        if self.critics and namespaces and "dwb_critics" not in namespaces:
            raise ConfigError(
                f"'default_critic_namespaces' is {list(namespaces)}, where there is no "
                f"'{self.critics[0]}'; valid: none, or 'dwb_critics' among them"
            )


@dataclass(frozen=True)
class ListedDwbConfig(DwbConfig):
    """Parameters of DWB whose critics are listed: what is left out of them is Nav2's default."""

    RotateToGoal: RotateToGoalConfig = field(default_factory=RotateToGoalConfig)
    BaseObstacle: ObstacleConfig = field(default_factory=ObstacleConfig)
    ObstacleFootprint: ObstacleConfig = field(default_factory=ObstacleConfig)
    PathAlign: AlignConfig = field(default_factory=AlignConfig)
    GoalAlign: AlignConfig = field(default_factory=AlignConfig)
    PathDist: MapGridConfig = field(default_factory=MapGridConfig)
    GoalDist: MapGridConfig = field(default_factory=MapGridConfig)
    PreferForward: PreferForwardConfig = field(default_factory=PreferForwardConfig)
