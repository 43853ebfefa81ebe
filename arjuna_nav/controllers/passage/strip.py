"""The widest straight strip between the points of two sides, and what of it an outline meets."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from arjuna_core.se2 import SE2

_TURN_PRICE = 0.03  # of a strip's width, for being turned [m/rad]


def widest_strip(
    points: NDArray[np.float64],
    window: tuple[float, float],
    beside: float,
    turn: float,
    step: float = 0.02,
) -> tuple[SE2, float] | None:
    """Return the middle line of the widest strip that has points on both its sides.

    Args:
        points: Obstacles `(N, 2)`, seen from a place between them [m].
        window: From where to where along the strip points count, from that place [m].
        beside: How far from that place the middle may lie [m].
        turn: How far the strip may be turned against x [rad].
        step: Between the headings that are tried [rad].

    Returns:
        The line's nearest pose to the place, looking along it, and the strip's width [m];
        None where no side ends.

    Source: the maximum-margin line between two sets of points (Vapnik 1963), here by trying
        headings: what lies on which side need not be known before.
    """
    count = max(math.ceil(turn / step), 1)
    found = _widest(points, window, beside, np.linspace(-turn, turn, 2 * count + 1))
    if found[2] <= 0.0:
        return None
    heading, offset, width = found
    return SE2(-offset * math.sin(heading), offset * math.cos(heading), heading), width


@njit(cache=True)
def _widest(
    points: NDArray[np.float64],
    window: tuple[float, float],
    beside: float,
    headings: NDArray[np.float64],
) -> tuple[float, float, float]:
    """Return heading, offset and width of the widest strip; a width of 0 where there is none."""
    best = (0.0, 0.0, 0.0)
    for heading in headings:
        c, s = math.cos(heading), math.sin(heading)
        along = c * points[:, 0] + s * points[:, 1]
        across = c * points[:, 1] - s * points[:, 0]
        sides = np.sort(across[(along >= window[0]) & (along <= window[1])])
        for i in range(len(sides) - 1):
            width, middle = sides[i + 1] - sides[i], 0.5 * (sides[i + 1] + sides[i])
            better = width - _TURN_PRICE * abs(heading) > best[2] - _TURN_PRICE * abs(best[0])
            if abs(middle) <= beside and better:
                best = (heading, middle, width)
    return best


@njit(cache=True)
def follow_line(
    pose: tuple[float, float, float],
    points: NDArray[np.float64],
    outline: NDArray[np.float64],
    lookahead: float,
    sharpest: float,
    distance: float,
    step: float,
) -> float:
    """Return how far an outline comes that is steered onto the x axis, before it meets a point.

    Args:
        pose: Of the robot, seen from the line [m, m, rad].
        points: Obstacles `(N, 2)`, seen from the line [m].
        outline: Corners in the robot's frame `(K, 2)` [m].
        lookahead: Of the pursuit [m].
        sharpest: Bend that the robot drives at most [1/m].
        distance: To drive [m].
        step: Between two looks [m].
    """
    x, y, theta = pose
    driven = 0.0
    while driven < distance:
        if _meets(x, y, theta, points, outline):
            return driven
        bend = min(max(line_bend(y, theta, lookahead), -sharpest), sharpest)
        theta += 0.5 * bend * step
        x += step * math.cos(theta)
        y += step * math.sin(theta)
        theta += 0.5 * bend * step
        driven += step
    return distance


@njit(cache=True)
def line_bend(y: float, theta: float, lookahead: float) -> float:
    """Return the bend [1/m] of the arc to the x axis's point a lookahead farther on."""
    target = -y * math.cos(theta) - lookahead * math.sin(theta)
    return 2.0 * target / (lookahead * lookahead + y * y)


@njit(cache=True)
def _meets(
    x: float,
    y: float,
    theta: float,
    points: NDArray[np.float64],
    outline: NDArray[np.float64],
) -> bool:
    c, s = math.cos(theta), math.sin(theta)
    for i in range(len(points)):
        dx, dy = points[i, 0] - x, points[i, 1] - y
        px, py = c * dx + s * dy, c * dy - s * dx
        inside = False
        for k in range(len(outline)):
            ax, ay = outline[k]
            bx, by = outline[k - 1]
            if (ay > py) != (by > py) and px < (bx - ax) * (py - ay) / (by - ay) + ax:
                inside = not inside
        if inside:
            return True
    return False
