"""MPPI's critics of the goal and of the motion itself."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from numba import njit
from numpy.typing import NDArray

from arjuna_core.arrays import Bools
from arjuna_nav.controllers.mppi.config import (
    CostConfig,
    CriticConfig,
    DeadbandConfig,
    GoalAngleConfig,
    NearGoalConfig,
    ObstaclesConfig,
)
from arjuna_nav.controllers.mppi.rollouts import Array, Rollouts
from arjuna_nav.controllers.mppi.scene import Grid, Scene, touches
from arjuna_nav.costmap.costmap import INSCRIBED, LETHAL, UNKNOWN

_F = np.float32


def goal(config: NearGoalConfig, rollouts: Rollouts, scene: Scene) -> Array | None:
    """Return each rollout's mean distance from the goal; None far away."""
    if scene.goal_distance > config.threshold_to_consider:
        return None
    gaps: Array = _mean_distance(rollouts.x, rollouts.y, scene.goal.x, scene.goal.y)
    return weighed(gaps, config.cost_weight)


def goal_angle(config: GoalAngleConfig, rollouts: Rollouts, scene: Scene) -> Array | None:
    """Return each rollout's mean angle from the goal's heading; None far away."""
    if scene.goal_distance > config.threshold_to_consider:
        return None
    angles: Array = _mean_angle(rollouts.yaw, scene.goal.theta, config.symmetric_yaw_tolerance)
    return weighed(angles, config.cost_weight)


def prefer_forward(config: NearGoalConfig, rollouts: Rollouts, scene: Scene) -> Array | None:
    """Return how far each rollout drives back; None near the goal."""
    if scene.goal_distance < config.threshold_to_consider:
        return None
    return weighed(_beyond(rollouts.v, 0.0, math.inf), config.cost_weight * scene.dt)


def constraint(config: CriticConfig, rollouts: Rollouts, scene: Scene) -> Array:
    """Return how long and how far each rollout's speed is beyond its limits.

    The speed of either direction counts, with the sign of the forward one; the limit is that of
    both, of a differential drive too.

    Source: nav2_mppi_controller, ConstraintCritic.
    """
    limits, speeds = scene.limits, rollouts.v
    if len(rollouts.side):
        speeds = np.copysign(np.hypot(rollouts.v, rollouts.side), rollouts.v)
    low = math.copysign(math.hypot(limits.v_min, limits.side_max), limits.v_min)
    excess = _beyond(speeds, low, math.hypot(limits.v_max, limits.side_max))
    return weighed(excess, config.cost_weight * scene.dt)


def twirling(config: CriticConfig, rollouts: Rollouts, scene: Scene) -> Array | None:
    """Return each rollout's mean yaw rate; None within the goal's tolerance."""
    if scene.goal_distance <= scene.xy_goal_tolerance:
        return None
    return weighed(_mean_size(rollouts.w), config.cost_weight)


def deadband(config: DeadbandConfig, rollouts: Rollouts, scene: Scene) -> Array:
    """Return how long and how far each rollout's velocities do not move the drive."""
    least = zip(config.deadband_velocities, (rollouts.v, rollouts.side, rollouts.w), strict=True)
    excess = sum(
        np.maximum(_F(low) - np.abs(part), 0).sum(axis=0) for low, part in least if len(part)
    )
    return weighed(excess, config.cost_weight * scene.dt)


def weighed(values: Array, weight: float) -> Array:
    """Return values times a weight, in their precision."""
    costs: Array = values * _F(weight)
    return costs


@njit(cache=True, fastmath=True)
def _mean_distance(x: Array, y: Array, goal_x: float, goal_y: float) -> Array:
    steps, batch = x.shape
    total, gx, gy = np.zeros(batch, np.float32), _F(goal_x), _F(goal_y)
    for t in range(steps):
        for b in range(batch):
            dx, dy = x[t, b] - gx, y[t, b] - gy
            total[b] += math.sqrt(dx * dx + dy * dy)
    mean: Array = total / _F(steps)
    return mean


@njit(cache=True, fastmath=True)
def _mean_angle(yaw: Array, goal_yaw: float, symmetric: bool) -> Array:
    steps, batch = yaw.shape
    total, target, turn = np.zeros(batch, np.float32), _F(goal_yaw), _F(2.0 * math.pi)
    half = _F(math.pi)
    for t in range(steps):
        for b in range(batch):
            ratio = (yaw[t, b] - target) / turn
            off = abs(ratio - np.floor(ratio + _F(0.5))) * turn
            total[b] += min(off, half - off) if symmetric else off
    mean: Array = total / _F(steps)
    return mean


@njit(cache=True, fastmath=True)
def _mean_size(values: Array) -> Array:
    steps, batch = values.shape
    total = np.zeros(batch, np.float32)
    for t in range(steps):
        for b in range(batch):
            total[b] += abs(values[t, b])
    mean: Array = total / _F(steps)
    return mean


@njit(cache=True)
def _beyond(values: Array, low: float, high: float) -> Array:
    steps, batch = values.shape
    total, least, most = np.zeros(batch, np.float32), _F(low), _F(high)
    for t in range(steps):
        for b in range(batch):
            total[b] += max(least - values[t, b], _F(0.0)) + max(values[t, b] - most, _F(0.0))
    return total


def cost_critic(config: CostConfig, rollouts: Rollouts, scene: Scene) -> tuple[Array, bool]:
    """Return each rollout's mean cost, and whether all collide.

    Source: nav2_mppi_controller, CostCritic.
    """
    table = _cost_table(config, scene.goal_distance > config.near_goal_distance)
    costs, hit = _along(
        rollouts, scene.grid, table, config.trajectory_point_step, config.consider_footprint
    )
    steps = len(range(0, rollouts.x.shape[0], config.trajectory_point_step))
    costs[hit] = config.collision_cost
    costs *= _F(config.cost_weight / LETHAL / steps)
    return costs, bool(hit.all())


@lru_cache
def _cost_table(config: CostConfig, far: bool) -> Array:
    """Return what each of a costmap's costs counts, far from the goal or near it."""
    table = np.zeros(256, np.float32)
    if far:
        table[:LETHAL] = np.arange(LETHAL)
    table[config.near_collision_cost : UNKNOWN] = config.critical_cost
    return table


def obstacles_critic(
    config: ObstaclesConfig, rollouts: Rollouts, scene: Scene
) -> tuple[Array, bool]:
    """Return how near to obstacles each rollout leads, and whether all collide.

    Source: nav2_mppi_controller, ObstaclesCritic.
    """
    cost = np.maximum(np.arange(256, dtype=np.float64), 1.0)
    away = -np.log(cost / (INSCRIBED - 1)) / config.inflation_cost_scaling_factor
    away = np.where(np.isfinite(scene.clearances), scene.clearances, away)
    margin = config.collision_margin_distance
    reach = scene.inflation_radius or scene.inscribed_radius + margin
    near, repulsion = (np.maximum(radius - away, 0.0) for radius in (margin, reach))
    near[[0, UNKNOWN]] = repulsion[[0, UNKNOWN]] = 0.0
    costs, hit = _along(rollouts, scene.grid, near.astype(np.float32), 1, config.consider_footprint)
    costs[hit] = config.collision_cost
    costs *= _F(config.critical_weight)
    if scene.goal_distance > config.near_goal_distance:
        table = (config.repulsion_weight * repulsion).astype(np.float32)
        repelled, _ = _along(rollouts, scene.grid, table, 1, False)
        costs += (repelled - repelled.min()) / _F(rollouts.x.shape[0])
    return costs, bool(hit.all())


@njit(cache=True, fastmath=True)
def _along(
    rollouts: Rollouts, grid: Grid, table: Array, step: int, consider_footprint: bool
) -> tuple[Array, Bools]:
    """Return the sum of what a table says of the costs along each rollout, and which collide."""
    steps, batch = rollouts.x.shape
    height, width = grid.data.shape
    costs, hit = np.zeros(batch, np.float32), np.zeros(batch, np.bool_)
    c, s = _F(math.cos(grid.theta) * grid.scale), _F(math.sin(grid.theta) * grid.scale)
    x0, y0 = _F(grid.x), _F(grid.y)
    cells, data = np.empty(batch, np.int32), grid.data.ravel()
    for t in range(0, steps, step):
        _find_cells(rollouts.x[t], rollouts.y[t], c, s, x0, y0, height, width, cells)
        for b in range(batch):
            cost = data[max(cells[b], 0)]
            costs[b] += table[cost]
            hit[b] |= (cells[b] < 0) | (cost == INSCRIBED) | (cost == LETHAL)
            if consider_footprint and cost >= grid.safe_cost and not hit[b]:
                hit[b] = touches(grid, rollouts.x[t, b], rollouts.y[t, b], rollouts.yaw[t, b])
    return costs, hit


@njit(cache=True, fastmath=True)
def _find_cells(
    x: Array,
    y: Array,
    c: float,
    s: float,
    x0: float,
    y0: float,
    height: int,
    width: int,
    cells: NDArray[np.int32],
) -> None:
    """Write the numbers of the cells in which points lie, row by row, -1 outside; by vectors."""
    rows, columns = np.int32(height), np.int32(width)
    for b in range(len(cells)):
        column, row = np.int32(x0 + c * x[b] - s * y[b]), np.int32(y0 + s * x[b] + c * y[b])
        inside = (row >= 0) & (row < rows) & (column >= 0) & (column < columns)
        cells[b] = row * columns + column if inside else np.int32(-1)
