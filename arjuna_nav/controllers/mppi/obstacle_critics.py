"""MPPI's critics of obstacles: costs along a rollout, or the distance that they tell."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from arjuna_nav.controllers.mppi.config import CostConfig, ObstaclesConfig
from arjuna_nav.controllers.mppi.rollouts import Array, Rollouts
from arjuna_nav.controllers.mppi.scene import Grid, Scene, touches
from arjuna_nav.costmap.costmap import INSCRIBED, LETHAL, UNKNOWN

_F = np.float32


def cost_critic(config: CostConfig, rollouts: Rollouts, scene: Scene) -> tuple[Array, bool]:
    """Return each rollout's mean cost, and whether all collide.

    Source: nav2_mppi_controller, CostCritic.
    """
    table = np.zeros(256, np.float32)
    if scene.goal_distance > config.near_goal_distance:
        table[:LETHAL] = np.arange(LETHAL)
    table[config.near_collision_cost : UNKNOWN] = config.critical_cost
    costs, hit = _along(
        rollouts, scene.grid, table, config.trajectory_point_step, config.consider_footprint
    )
    steps = len(range(0, rollouts.x.shape[0], config.trajectory_point_step))
    costs[hit] = config.collision_cost
    costs *= _F(config.cost_weight / LETHAL / steps)
    return costs, bool(hit.all())


def obstacles_critic(
    config: ObstaclesConfig, rollouts: Rollouts, scene: Scene, inscribed_radius: float
) -> tuple[Array, bool]:
    """Return how near to obstacles each rollout leads, and whether all collide.

    Source: nav2_mppi_controller, ObstaclesCritic.
    """
    cost = np.maximum(np.arange(256, dtype=np.float64), 1.0)
    away = -np.log(cost / (INSCRIBED - 1)) / config.inflation_cost_scaling_factor
    away = np.where(np.isfinite(scene.clearances), scene.clearances, away)
    margin = config.collision_margin_distance
    near = np.maximum(margin - away, 0.0) * config.critical_weight
    repulsion = np.maximum(inscribed_radius + margin - away, 0.0) * config.repulsion_weight
    table = near + (repulsion if scene.goal_distance > config.near_goal_distance else 0.0)
    table[0] = table[UNKNOWN] = 0.0
    costs, hit = _along(
        rollouts, scene.grid, table.astype(np.float32), 1, config.consider_footprint
    )
    costs /= _F(rollouts.x.shape[0])
    costs[hit] = config.collision_cost
    return costs, bool(hit.all())


@njit(cache=True, fastmath=True)
def _along(
    rollouts: Rollouts, grid: Grid, table: Array, step: int, consider_footprint: bool
) -> tuple[Array, NDArray[np.bool_]]:
    """Return the sum of what a table says of the costs along each rollout, and which collide."""
    steps, batch = rollouts.x.shape
    height, width = grid.data.shape
    costs, hit = np.zeros(batch, np.float32), np.zeros(batch, np.bool_)
    c, s = _F(math.cos(grid.theta) * grid.scale), _F(math.sin(grid.theta) * grid.scale)
    x0, y0 = _F(grid.x), _F(grid.y)
    for t in range(0, steps, step):
        for b in range(batch):
            x, y = rollouts.x[t, b], rollouts.y[t, b]
            column, row = int(x0 + c * x - s * y), int(y0 + s * x + c * y)
            if not (0 <= row < height and 0 <= column < width):
                hit[b] = True
                continue
            cost = grid.data[row, column]
            costs[b] += table[cost]
            if cost >= INSCRIBED and cost != UNKNOWN:
                hit[b] = True
            elif consider_footprint and cost >= grid.safe_cost and not hit[b]:
                hit[b] = touches(grid, x, y, rollouts.yaw[t, b])
    return costs, hit
