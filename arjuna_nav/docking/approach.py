"""Driving to a pose by the graceful control law, forwards or backwards, unless blocked."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from arjuna_core.arrays import Floats
from arjuna_core.config import (
    duration_param,
    fixed,
    length_param,
    param,
    speed_param,
    yaw_rate_param,
)
from arjuna_core.se2 import SE2
from arjuna_core.twist import STILL, Velocity
from arjuna_nav.controllers.graceful import control_law
from arjuna_nav.costmap.collision import collision_ahead
from arjuna_nav.costmap.costmap import Costmap
from arjuna_nav.costmap.footprint import Footprint


@dataclass(frozen=True)
class ApproachConfig:
    """Limits of the drive to a dock and away, and of its look ahead, by Nav2's names."""

    k_phi: float = param(3.0, "Rate of the heading's error per rate of the distance.", minimum=0.0)
    k_delta: float = param(2.0, "Gain of the steering's error.", minimum=0.0)
    beta: float = param(0.4, "How much bends slow down.", minimum=0.0)
    lambda_: float = param(2.0, "How sharply bends slow down.", minimum=1.0)
    v_linear_min: float = speed_param(0.1, "Least speed.")
    v_linear_max: float = speed_param(0.25, "Greatest speed.", minimum=0.01)
    v_angular_max: float = yaw_rate_param(0.75, "Greatest yaw rate.", minimum=0.01)
    slowdown_radius: float = length_param(
        0.25, "Distance from the pose at which to slow down.", minimum=0.01
    )
    use_collision_detection: bool = param(True, "Whether to stop before obstacles.")
    costmap_topic: str = fixed("local_costmap/costmap_raw", "Costs that show them.")
    footprint_topic: str = fixed(
        "local_costmap/published_footprint", "Outline that may not meet them."
    )
    transform_tolerance: float = duration_param(
        0.1, "How old the transforms to costs and outline may be."
    )
    projection_time: float = duration_param(5.0, "How far ahead to look.", minimum=0.01)
    simulation_time_step: float = duration_param(0.1, "Step of that look.", minimum=0.01)
    dock_collision_threshold: float = length_param(
        0.3, "Distance to the dock within which nothing counts as obstacle."
    )


class BlockedError(Exception):
    """An obstacle blocks the path; the message says where."""


def towards(
    config: ApproachConfig,
    pose: SE2,
    target: SE2,
    backward: bool,
    dock: SE2,
    costmap: Costmap | None,
    footprint: Footprint | None,
) -> Velocity:
    """Return what to drive towards a pose; all poses are of one frame.

    Args:
        backward: Whether to drive backwards.
        dock: What stands near it belongs to the dock and is no obstacle.
        costmap: Obstacles, of the same frame; None lets all pass.
        footprint: The robot; None where nothing counts as obstacle.

    Raises:
        BlockedError: The path there meets an obstacle.
    """
    if config.use_collision_detection and costmap is not None and footprint is not None:
        ahead = foreseen(config, pose, target, backward)
        near = np.hypot(ahead[:, 0] - dock.x, ahead[:, 1] - dock.y)
        ahead = ahead[near > config.dock_collision_threshold]
        if problem := collision_ahead(costmap, footprint, ahead):
            raise BlockedError(problem)
    return steer(config, pose.inverse() @ target, backward)


def at_the_end(
    config: ApproachConfig, pose: SE2, target: SE2, tolerances: tuple[float, float], backward: bool
) -> Velocity | None:
    """Return what to drive within tolerances of a pose, None outside them.

    So near, the direction to the pose is only noise: the robot drives straight until it is level
    with the pose, and then stands.

    Args:
        target: The pose to end at, in the same frame.
        tolerances: Distance [m] and heading [rad].
        backward: Whether it drives backwards.
    """
    remaining = pose.inverse() @ target
    ahead = -remaining.x if backward else remaining.x
    linear, angular = tolerances
    passed = ahead <= 0.0 and abs(remaining.y) < linear
    if abs(remaining.theta) >= angular or not (
        passed or math.hypot(remaining.x, remaining.y) < linear
    ):
        return None
    if passed:
        return STILL
    return Velocity(-config.v_linear_min if backward else config.v_linear_min)


def steer(config: ApproachConfig, T_base_target: SE2, backward: bool = False) -> Velocity:
    """Return what to drive, ahead or backwards, towards a pose in the robot's base."""
    x, y = T_base_target.x, T_base_target.y
    side = -1.0 if backward else 1.0  # backwards it is the law of a robot turned by pi
    law = np.array([config.k_phi, config.k_delta, config.beta, config.lambda_])
    slowing = config.slowdown_radius
    limits = np.array([config.v_linear_min, config.v_linear_max, slowing, config.v_angular_max])
    v, w = control_law.steer(side * x, side * y, T_base_target.theta, law, limits)
    return Velocity(side * v, yaw_rate=w)


def foreseen(config: ApproachConfig, pose: SE2, target: SE2, backward: bool) -> Floats:
    """Return where the law leads within `projection_time`, `(N, 3) float64` [m, m, rad].

    The present pose is the first; it ends at the target, of the same frame, too.
    """
    poses, step = [pose], config.simulation_time_step
    for _ in range(math.ceil(config.projection_time / step)):
        T_base_target = poses[-1].inverse() @ target
        if math.hypot(T_base_target.x, T_base_target.y) < config.v_linear_max * step:
            break
        velocity = steer(config, T_base_target, backward)
        poses.append(poses[-1] @ SE2.exp(np.array([velocity.x, 0.0, velocity.yaw_rate]) * step))
    return np.array([each.array() for each in poses])
