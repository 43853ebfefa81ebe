"""Driving to a pose by the control law, unless something is in the way."""

from __future__ import annotations

import math

import numpy as np

from arjuna_core.se2 import SE2
from arjuna_core.twist import STILL, Velocity
from arjuna_nav.costmap.collision import first_collision
from arjuna_nav.costmap.costmap import Costmap
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.docking.config import ApproachConfig
from arjuna_nav.docking.control_law import foreseen, steer


class BlockedError(Exception):
    """Something is in the way; the message says where."""


def towards(
    config: ApproachConfig,
    pose: SE2,
    target: SE2,
    backward: bool,
    dock: SE2,
    costmap: Costmap | None,
    footprint: Footprint,
) -> Velocity:
    """Return what to drive towards a pose; all poses are of one frame.

    Args:
        config: Limits.
        pose: Where the robot is.
        target: The pose to end at.
        backward: Whether to drive backwards.
        dock: What stands near it belongs to the dock and is no obstacle.
        costmap: What is in the way, of the same frame; None lets all pass.
        footprint: The robot.

    Raises:
        BlockedError: The way there meets an obstacle.
    """
    if config.use_collision_detection and costmap is not None:
        ahead = foreseen(
            config, pose, target, backward, config.projection_time, config.simulation_time_step
        )
        near = np.hypot(ahead[:, 0] - dock.x, ahead[:, 1] - dock.y)
        ahead = ahead[near > config.dock_collision_threshold]
        hit = first_collision(costmap, footprint, ahead) if len(ahead) else None
        if hit is not None:
            raise BlockedError(f"collision ahead at ({ahead[hit, 0]:.2f}, {ahead[hit, 1]:.2f})")
    return steer(config, pose.inverse() @ target, backward)


def at_the_end(
    config: ApproachConfig,
    pose: SE2,
    target: SE2,
    tolerances: tuple[float, float],
    backward: bool,
) -> Velocity | None:
    """Return what to drive within tolerances of a pose, None outside them.

    So near, the direction to the pose says nothing: the robot goes straight on until it is level
    with the pose, and then is still.

    Args:
        config: Limits.
        pose: Where the robot is.
        target: The pose to end at, in the same frame.
        tolerances: Distance [m] and heading [rad].
        backward: Whether it drives backwards.
    """
    left = pose.inverse() @ target
    ahead = -left.x if backward else left.x
    linear, angular = tolerances
    passed = ahead <= 0.0 and abs(left.y) < linear
    if abs(left.theta) >= angular or not (passed or math.hypot(left.x, left.y) < linear):
        return None
    if passed:
        return STILL
    return Velocity(-config.v_linear_min if backward else config.v_linear_min)
