"""Parameters of regulated pure pursuit, by Nav2's names."""

from __future__ import annotations

import math
from dataclasses import dataclass

from arjuna_core.config import (
    angle_param,
    duration_param,
    length_param,
    param,
    speed_param,
    yaw_rate_param,
)
from arjuna_nav.controllers.base import PluginConfig
from arjuna_nav.controllers.motion import gentle_turns


@dataclass(frozen=True)
class RegulatedPurePursuitConfig(PluginConfig):
    """Parameters of regulated pure pursuit, by Nav2's names."""

    desired_linear_vel: float = speed_param(0.5, "Greatest forward speed.")
    lookahead_dist: float = length_param(0.6, "Fixed lookahead.")
    min_lookahead_dist: float = length_param(0.3, "Least scaled lookahead.")
    max_lookahead_dist: float = length_param(0.9, "Greatest scaled lookahead.")
    lookahead_time: float = duration_param(1.5, "Scaled lookahead per speed.")
    use_velocity_scaled_lookahead_dist: bool = param(False, "Whether lookahead grows with speed.")
    min_approach_linear_velocity: float = speed_param(0.05, "Least speed towards the goal.")
    approach_velocity_scaling_dist: float = length_param(
        0.6, "Distance from the goal at which to slow down."
    )
    use_collision_detection: bool = param(True, "Whether to stop before obstacles.")
    max_allowed_time_to_collision_up_to_carrot: float = duration_param(
        1.0, "How far ahead collisions are looked for."
    )
    use_regulated_linear_velocity_scaling: bool = param(True, "Whether bends slow down.")
    use_cost_regulated_linear_velocity_scaling: bool = param(True, "Whether obstacles slow down.")
    cost_scaling_dist: float = length_param(0.6, "Distance to obstacles that slows down.")
    cost_scaling_gain: float = param(1.0, "Speed left per distance.", minimum=0.0)
    inflation_cost_scaling_factor: float = param(
        3.0,
        "The costmap's cost_scaling_factor, where it has none; 0: obstacles slow nothing down.",
        unit="1/m",
        minimum=0.0,
    )
    costmaps_own_distances: bool = param(
        True,
        "Whether the costmap's own cost_scaling_factor says how far obstacles are, where it has"
        " one; else, as Nav2, inflation_cost_scaling_factor.",
        theirs=False,
    )
    regulated_linear_scaling_min_radius: float = length_param(
        0.90, "Radius of bends that slow down."
    )
    regulated_linear_scaling_min_speed: float = speed_param(0.25, "Least regulated speed.")
    use_fixed_curvature_lookahead: bool = param(
        False, "Whether bends slow down, and turns begin, by a point at a distance of its own."
    )
    curvature_lookahead_dist: float = length_param(0.6, "Distance of that point.")
    interpolate_curvature_after_goal: bool = param(
        False, "Whether that point lies beyond the path's end where the path is shorter."
    )
    allow_reversing: bool = param(False, "Whether paths that change their direction are followed.")
    stateful: bool = param(
        True, "Whether the robot stays at the goal once it was there, and turns only."
    )
    use_rotate_to_heading: bool = param(True, "Whether to turn on the spot.")
    rotate_to_heading_min_angle: float = angle_param(
        0.785, "Heading error that starts a turn on the spot."
    )
    rotate_to_heading_angular_vel: float = yaw_rate_param(
        1.8, "Yaw rate on the spot and greatest in bends."
    )
    rotate_to_heading_gain: float = param(
        1.5, "Yaw rate per angle left; stable with 0.25 s to motion.", unit="1/s", minimum=0.1
    )
    min_rotate_to_heading_angular_vel: float = yaw_rate_param(
        0.1, "Yaw rate below which the wheels stick."
    )
    rotate_to_heading_settled_angle: float = angle_param(
        0.05, "Angle left below which the wheels may stick."
    )
    shorter_lookaheads: tuple[float, ...] = param(
        (0.7, 0.5, 0.35),
        "Ratios of the lookahead, tried where its arc collides: it cuts the path's corners.",
        theirs=(),
    )
    rotate_instead_min_angle: float = angle_param(
        0.35, "Bearing from which a turn on the spot is tried where no arc is free.", theirs=math.pi
    )
    gentle_turns: bool = gentle_turns()
    same_goal_tolerance: float = length_param(
        0.1, "Distance between the ends of two paths to the same goal."
    )
    max_angular_accel: float = param(3.2, "Change of the yaw rate.", unit="rad/s^2", minimum=0.01)
    max_robot_pose_search_dist: float = param(
        2.5, "How far along the path the robot is looked for; below 0 all along.", unit="m"
    )
    use_cancel_deceleration: bool = param(
        False, "Whether a robot whose path is cancelled brakes by `cancel_deceleration` along it."
    )
    cancel_deceleration: float = param(3.2, "How it does.", unit="m/s^2", minimum=0.01)
