"""MPPI's critics of the path: near it all along, ahead on it, and facing it."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from arjuna_nav.controllers.mppi.config import (
    PathAlignConfig,
    PathAngleConfig,
    PathFollowConfig,
)
from arjuna_nav.controllers.mppi.rollouts import Array, Rollouts
from arjuna_nav.controllers.mppi.scene import Scene

_F = np.float32


def path_align(config: PathAlignConfig, rollouts: Rollouts, scene: Scene) -> Array | None:
    """Return each rollout's mean distance from the path; None where it does not count.

    Source: nav2_mppi_controller, PathAlignCritic.
    """
    if scene.goal_distance < config.threshold_to_consider:
        return None
    if scene.furthest < config.offset_from_furthest:
        return None
    reached = scene.free[: scene.furthest + 1]
    if np.count_nonzero(~reached) > config.max_path_occupancy_ratio * len(reached):
        return None
    along = np.zeros(len(scene.path), np.float32)
    along[1:] = np.cumsum(np.hypot(*np.diff(scene.path[:, :2], axis=0).T))
    gaps: Array = _gaps(
        rollouts.x, rollouts.y, scene.path, along, scene.free, config.trajectory_point_step
    )
    return _weighed(gaps, config.cost_weight)


def path_follow(config: PathFollowConfig, rollouts: Rollouts, scene: Scene) -> Array | None:
    """Return the distance of each rollout's end from a pose ahead; None near the goal.

    Source: nav2_mppi_controller, PathFollowCritic.
    """
    if scene.goal_distance < config.threshold_to_consider:
        return None
    index = min(scene.furthest + config.offset_from_furthest, len(scene.path) - 1)
    while index < len(scene.path) - 1 and not scene.free[index]:
        index += 1
    x, y = scene.path[index, :2]
    distances: Array = np.hypot(rollouts.x[-1] - x, rollouts.y[-1] - y)
    return _weighed(distances, config.cost_weight)


def path_angle(config: PathAngleConfig, rollouts: Rollouts, scene: Scene) -> Array | None:
    """Return the angle between each rollout's end and a pose ahead; None where that is ahead.

    Source: nav2_mppi_controller, PathAngleCritic.
    """
    if scene.goal_distance < config.threshold_to_consider:
        return None
    index = min(scene.furthest + config.offset_from_furthest, len(scene.path) - 1)
    x, y = scene.path[index, :2]
    now = abs(math.atan2(float(y), float(x)))
    if min(now, math.pi - now if config.mode else now) < config.max_angle_to_furthest:
        return None
    sight = np.arctan2(y - rollouts.y[-1], x - rollouts.x[-1])
    off = np.abs(
        np.remainder(sight - rollouts.yaw[-1] + _F(math.pi), _F(2 * math.pi)) - _F(math.pi)
    )
    angles: Array = np.minimum(off, _F(math.pi) - off) if config.mode else off
    return _weighed(angles, config.cost_weight)


def _weighed(values: Array, weight: float) -> Array:
    costs: Array = values * _F(weight)
    return costs


@njit(cache=True, fastmath=True)
def _gaps(
    x: Array, y: Array, path: Array, along: Array, free: NDArray[np.bool_], step: int
) -> Array:
    """Return each rollout's mean distance from the path's pose that is as far along."""
    steps, batch = x.shape
    way, total = np.zeros(batch, np.float32), np.zeros(batch, np.float32)
    count, index = np.zeros(batch, np.float32), np.zeros(batch, np.int32)
    last = len(path) - 1
    for t in range(step, steps, step):
        _add_steps(x[t - step], y[t - step], x[t], y[t], way)
        for b in range(batch):
            i = index[b]
            while i < last and along[i + 1] <= way[b]:
                i += 1
            index[b] = i
            if i < last and along[i + 1] - way[b] < way[b] - along[i]:
                i += 1
            if free[i]:
                dx, dy = x[t, b] - path[i, 0], y[t, b] - path[i, 1]
                total[b] += math.sqrt(dx * dx + dy * dy)
                count[b] += _F(1.0)
    for b in range(batch):
        total[b] = total[b] / max(count[b], _F(1.0))
    return total


@njit(cache=True, fastmath=True)
def _add_steps(x0: Array, y0: Array, x1: Array, y1: Array, way: Array) -> None:
    """Add the lengths of steps, by vectors."""
    for b in range(len(way)):
        dx, dy = x1[b] - x0[b], y1[b] - y0[b]
        way[b] += math.sqrt(dx * dx + dy * dy)
