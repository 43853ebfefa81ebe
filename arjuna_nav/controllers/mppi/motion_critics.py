"""MPPI's critics of the goal and of the motion itself."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from arjuna_nav.controllers.mppi.config import (
    CriticConfig,
    DeadbandConfig,
    GoalAngleConfig,
    NearGoalConfig,
)
from arjuna_nav.controllers.mppi.rollouts import Array, Limits, Rollouts
from arjuna_nav.controllers.mppi.scene import Scene

_F = np.float32


def goal(config: NearGoalConfig, rollouts: Rollouts, scene: Scene) -> Array | None:
    """Return each rollout's mean distance from the goal; None far away."""
    if scene.goal_distance > config.threshold_to_consider:
        return None
    gaps: Array = _mean_distance(rollouts.x, rollouts.y, scene.goal.x, scene.goal.y)
    return _weighed(gaps, config.cost_weight)


def goal_angle(config: GoalAngleConfig, rollouts: Rollouts, scene: Scene) -> Array | None:
    """Return each rollout's mean angle from the goal's heading; None far away."""
    if scene.goal_distance > config.threshold_to_consider:
        return None
    angles: Array = _mean_angle(rollouts.yaw, scene.goal.theta, config.symmetric_yaw_tolerance)
    return _weighed(angles, config.cost_weight)


def prefer_forward(
    config: NearGoalConfig, rollouts: Rollouts, scene: Scene, dt: float
) -> Array | None:
    """Return how far each rollout drives back; None near the goal."""
    if scene.goal_distance < config.threshold_to_consider:
        return None
    return _weighed(_beyond(rollouts.v, 0.0, math.inf), config.cost_weight * dt)


def constraint(config: CriticConfig, rollouts: Rollouts, limits: Limits, dt: float) -> Array:
    """Return how long and how far each rollout's speed is beyond its limits."""
    excess = _beyond(rollouts.v, limits.v_min, limits.v_max)
    return _weighed(excess, config.cost_weight * dt)


def twirling(config: CriticConfig, rollouts: Rollouts) -> Array:
    """Return each rollout's mean yaw rate."""
    return _weighed(_mean_size(rollouts.w), config.cost_weight)


def deadband(config: DeadbandConfig, rollouts: Rollouts, dt: float) -> Array:
    """Return how long and how far each rollout's velocities do not move the drive."""
    v, _, w = config.deadband_velocities
    excess = np.maximum(_F(v) - np.abs(rollouts.v), 0) + np.maximum(_F(w) - np.abs(rollouts.w), 0)
    return _weighed(excess.sum(axis=0), config.cost_weight * dt)


def _weighed(values: Array, weight: float) -> Array:
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
