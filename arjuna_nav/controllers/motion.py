"""Where a constant velocity takes the robot."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from arjuna_core.se2 import SE2
from arjuna_core.twist import Velocity

_TURN_STEP = 0.1  # between two poses; moves a corner 0.5 m out by one cell of 5 cm [rad]
_MOST = 10_000  # poses: 500 m of cells of 5 cm


def rollout(pose: SE2, velocity: Velocity, duration: float, spacing: float) -> NDArray[np.float64]:
    """Return the poses along the arc that a constant velocity drives, one round of it at most.

    Args:
        pose: Start.
        velocity: What is driven.
        duration: For how long [s].
        spacing: Greatest distance between two poses [m].

    Returns:
        `(N, 3) float64` [m, m, rad], the start first.
    """
    duration = min(duration, 2.0 * math.pi / max(abs(velocity.yaw_rate), 1e-9))
    travel, turn = abs(velocity.x) * duration, abs(velocity.yaw_rate) * duration
    count = 1 + math.ceil(min(max(travel / spacing, turn / _TURN_STEP), _MOST))
    times = np.linspace(0.0, duration, count)
    theta = pose.theta + velocity.yaw_rate * times
    middle = pose.theta + 0.5 * velocity.yaw_rate * times
    chord = velocity.x * times * np.sinc(velocity.yaw_rate * times / (2.0 * math.pi))
    return np.column_stack(
        (pose.x + chord * np.cos(middle), pose.y + chord * np.sin(middle), theta)
    )


def crossing(pose: SE2, before: SE2, after: SE2, distance: float) -> float:
    """Return where a segment leaves the circle of a radius round the robot, as a ratio 0..1."""
    dx, dy = after.x - before.x, after.y - before.y
    fx, fy = before.x - pose.x, before.y - pose.y
    a, b, c = dx * dx + dy * dy, fx * dx + fy * dy, fx * fx + fy * fy - distance * distance
    if a == 0.0:
        return 1.0
    root = math.sqrt(max(b * b - a * c, 0.0))
    return min(max((root - b) / a, 0.0), 1.0)
