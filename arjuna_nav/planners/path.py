"""Questions about a path `(N, 3) float64` of poses [m, m, rad]."""

from __future__ import annotations

import itertools
import math

import numpy as np
from numba import njit

from arjuna_core.arrays import Floats, Ints
from arjuna_core.se2 import SE2

_ON_THE_SPOT = 1e-4  # nav2_smoother, findDirectionalPathSegments: a shorter step is none [m]


def length(path: Floats) -> float:
    """Return the length of a path [m]."""
    steps = path[1:] - path[:-1]
    return float(np.hypot(steps[:, 0], steps[:, 1]).sum())


def shifted(path: Floats, distance: float) -> Floats:
    """Return the path of a point so far before the one whose path is given [m]."""
    if not distance:
        return path
    heading = np.column_stack((np.cos(path[:, 2]), np.sin(path[:, 2])))
    return np.column_stack((path[:, :2] + distance * heading, path[:, 2]))


@njit(cache=True)
def along(path: Floats) -> Floats:
    """Return how far along a path each of its poses lies, `(N,) float64` [m]."""
    reached = np.zeros(len(path))
    for i in range(1, len(path)):
        step = math.hypot(path[i, 0] - path[i - 1, 0], path[i, 1] - path[i - 1, 1])
        reached[i] = reached[i - 1] + step
    return reached


def turns(path: Floats) -> Ints:
    """Return the indices of the poses that the next one turns on the spot, `(N,) int64`."""
    return np.flatnonzero(np.hypot(*np.diff(path[:, :2], axis=0).T) < _ON_THE_SPOT)


def parts(path: Floats, first: int = 0) -> list[tuple[int, int]]:
    """Return the first and last index of each part from a pose on that has one direction.

    The path inverts where a step leads against the one before it; turns on the spot are no steps.

    Source: nav2_util, findFirstPathInversion.
    """
    steps = np.diff(path[first:, :2], axis=0)
    moves = np.flatnonzero(np.hypot(*steps.T) >= _ON_THE_SPOT)
    along_last = (steps[moves[1:]] * steps[moves[:-1]]).sum(axis=1)
    cusps = first + moves[np.flatnonzero(along_last < 0.0)] + 1
    bounds = [first, *cusps.tolist(), len(path) - 1]
    return list(itertools.pairwise(bounds)) if len(steps) else []


def part_end(path: Floats, first: int = 0) -> int:
    """Return the index after the last pose that is reached in one direction from a pose."""
    return next((last + 1 for _, last in parts(path, first)), len(path))


def directions(path: Floats) -> list[int]:
    """Return how a path is driven, change by change: 1 ahead, -1 back by its poses' headings."""
    steps, middle = np.diff(path[:, :2], axis=0), path[:-1, 2]
    ahead = np.sign(steps[:, 0] * np.cos(middle) + steps[:, 1] * np.sin(middle))
    found: list[int] = []
    for first, last in parts(path):
        direction = -1 if ahead[first:last].sum() < 0.0 else 1
        if found[-1:] != [direction]:
            found.append(direction)
    return found


def distances(path: Floats, pose: SE2) -> Floats:
    """Return the distance of each pose of a path from the robot, `(N,) float64` [m]."""
    result: Floats = np.hypot(path[:, 0] - pose.x, path[:, 1] - pose.y)
    return result


def nearest(
    path: Floats, pose: SE2, first: int = 0, within: float = np.inf, turning: float = 0.0
) -> int:
    """Return the index of the path's pose nearest to the robot.

    Args:
        path: At least one pose.
        pose: The robot's, in the path's frame.
        first: Index from which to look.
        within: How far along the path to look [m].
        turning: What a turn to the path's heading counts [m/rad].
    """
    return int(_nearest(path, first, (pose.x, pose.y, pose.theta), within, turning))


@njit(cache=True)
def _nearest(
    path: Floats, first: int, pose: tuple[float, float, float], within: float, turning: float
) -> int:
    best, index, travelled = np.inf, first, 0.0
    for i in range(first, len(path)):
        if i > first:
            travelled += math.hypot(path[i, 0] - path[i - 1, 0], path[i, 1] - path[i - 1, 1])
        if travelled > within:
            break
        off = (path[i, 2] - pose[2] + math.pi) % (2.0 * math.pi) - math.pi
        gap = math.hypot(path[i, 0] - pose[0], path[i, 1] - pose[1])
        gap = math.hypot(gap, turning * off)
        if gap < best:
            best, index = gap, i
    return index


def remaining(path: Floats, pose: SE2) -> float:
    """Return the length of a path from the pose nearest to the robot [m]."""
    return length(ahead(path, pose))


def ends_here(path: Floats, pose: SE2, remaining: float | None = None, detour: float = 1.0) -> bool:
    """Return whether a path goes to its end from here, not in a loop that leads back later.

    Args:
        remaining: Length of the path, where that is known [m].
        detour: How much longer than the straight line it may be without being a loop [m].
    """
    straight = float(np.hypot(path[-1, 0] - pose.x, path[-1, 1] - pose.y))
    return (length(path) if remaining is None else remaining) <= straight + detour


def deviation(path: Floats, other: Floats) -> float:
    """Return how far the farthest pose of a path lies from another path [m]."""
    gaps = path[::4, None, :2] - other[None, ::2, :2]
    return float(np.sqrt(np.square(gaps).sum(axis=2).min(axis=1).max()))


def ahead(path: Floats, pose: SE2) -> Floats:
    """Return the part of a path from the pose nearest to the robot."""
    return path[nearest(path, pose) :]
