"""Speed limits along a path: before narrow gaps and bends, in time."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit

from arjuna_core.arrays import Bytes, Floats
from arjuna_core.config import duration_param, length_param, param, speed_param
from arjuna_core.se2 import SE2
from arjuna_nav.controllers.motion import braking_distance, braking_speed
from arjuna_nav.costmap import Costmap


@dataclass(frozen=True)
class ForesightConfig:
    """Limits of the speed by what lies ahead on the path."""

    enabled: bool = param(
        True, "Whether narrow gaps and bends ahead slow the robot down.", theirs=False
    )
    reaction_time: float = duration_param(
        0.25, "Speed allowed is clearance beside the robot by this time: what it may err meanwhile."
    )
    min_speed: float = speed_param(0.3, "Least speed it is slowed down to.", minimum=0.01)
    lateral_acceleration: float = param(
        1.0, "Greatest acceleration in bends.", unit="m/s^2", minimum=0.01
    )
    deceleration: float = param(1.5, "Braking before what lies ahead.", unit="m/s^2", minimum=0.01)
    chord: float = length_param(
        0.4,
        "Length over which the path's curvature is taken: the steps of a grid are none.",
        minimum=0.05,
    )


def allowed_speed(
    config: ForesightConfig, path: Floats, pose: SE2, costmap: Costmap, desired: float
) -> float:
    """Return the greatest speed now [m/s].

    Every pose ahead has a speed, by the clearance beside the robot there and by the path's
    curvature; the robot may be so fast that it can brake to each of them in time.

    Args:
        path: Ahead of the robot, `(N, 3) float64`, in the costmap's frame.
        desired: Greatest speed of all [m/s]; where it is below the least, it is returned.

    Source: velocity profiles along a path, as Kunz and Stilman, Time-optimal trajectory generation
        for path following with bounded acceleration and velocity, RSS 2012, backward pass.
    """
    if not config.enabled or desired <= config.min_speed or len(path) < 2:
        return desired
    frame = costmap.frame
    points = np.vstack(((pose.x, pose.y), path[:, :2]))
    limits = (
        config.min_speed,
        config.reaction_time,
        config.lateral_acceleration,
        config.deceleration,
        config.chord,
    )
    cells = frame.origin.inverse().apply(points) / frame.resolution
    return float(_speed(points, cells, costmap.data, costmap.clearances, limits, desired))


@njit(cache=True)
def _speed(
    points: Floats,
    cells: Floats,
    data: Bytes,
    clearances: Floats,
    limits: tuple[float, float, float, float, float],
    desired: float,
) -> float:
    """Go along the path as far as braking takes; the first point is the robot's own."""
    least, reaction, lateral, deceleration, chord = limits
    height, width = data.shape
    speed, along, entered, back = desired, 0.0, 0.0, 1
    horizon = braking_distance(desired, deceleration)
    for i in range(len(points)):
        along += _gap(points, i - 1, i) if i > 0 else 0.0
        if entered > horizon:
            break
        row, column = math.floor(cells[i, 1]), math.floor(cells[i, 0])
        if 0 <= row < height and 0 <= column < width:
            beside = least + clearances[data[row, column]] / max(reaction, 1e-3)
            speed = min(speed, braking_speed(along, deceleration, beside))
        while back < i and _gap(points, back, i) > chord:
            entered += _gap(points, back, back + 1)
            back += 1
        if i > back:  # a bend counts from where it begins
            round_it = max(
                math.sqrt(lateral / max(_curvature(points, back, i, chord), 1e-3)), least
            )
            speed = min(speed, braking_speed(entered, deceleration, round_it))
    return speed


@njit(cache=True)
def _gap(points: Floats, i: int, j: int) -> float:
    return math.hypot(points[j, 0] - points[i, 0], points[j, 1] - points[i, 1])


@njit(cache=True)
def _curvature(points: Floats, first: int, last: int, chord: float) -> float:
    """Return the curvature [1/m] of the circle through the ends and the middle of a stretch."""
    middle = (first + last) // 2
    a, b, c = _gap(points, first, middle), _gap(points, middle, last), _gap(points, first, last)
    if first == middle or a * b * c < 1e-9 or c < 0.5 * chord:
        return 0.0
    ax, ay = points[middle] - points[first]
    bx, by = points[last] - points[first]
    curvature: float = 2.0 * abs(ax * by - ay * bx) / (a * b * c)
    return curvature
