"""Questions about a path `(N, 3) float64` of poses [m, m, rad]."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arjuna_core.se2 import SE2, wrap

_DETOUR = 1.0  # of a path over the straight way, up to which it is no loop [m]


def length(path: NDArray[np.float64]) -> float:
    """Return the length of a path [m]."""
    return float(np.hypot(*np.diff(path[:, :2], axis=0).T).sum())


def along(path: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return how far along a path each of its poses lies, `(N,) float64` [m]."""
    return np.append(0.0, np.cumsum(np.hypot(*np.diff(path[:, :2], axis=0).T)))


def distances(path: NDArray[np.float64], pose: SE2) -> NDArray[np.float64]:
    """Return the distance of each pose of a path from the robot, `(N,) float64` [m]."""
    result: NDArray[np.float64] = np.hypot(path[:, 0] - pose.x, path[:, 1] - pose.y)
    return result


def nearest(
    path: NDArray[np.float64],
    pose: SE2,
    first: int = 0,
    within: float = np.inf,
    turning: float = 0.0,
) -> int:
    """Return the index of the path's pose nearest to the robot.

    Args:
        path: At least one pose.
        pose: The robot's, in the path's frame.
        first: Index from which to look.
        within: How far along the path to look [m].
        turning: What a turn to the path's heading counts [m/rad].
    """
    rest = path[first:]
    rest = rest[along(rest) <= within]
    gaps = distances(rest, pose)
    if turning != 0.0:
        gaps = np.hypot(gaps, turning * wrap(rest[:, 2] - pose.theta))
    return first + int(np.argmin(gaps))


def remaining(path: NDArray[np.float64], pose: SE2) -> float:
    """Return the length of a path from the pose nearest to the robot [m]."""
    return length(ahead(path, pose))


def ends_here(path: NDArray[np.float64], pose: SE2) -> bool:
    """Tell whether a path goes to its end from here, not in a loop that leads back later."""
    straight = float(np.hypot(path[-1, 0] - pose.x, path[-1, 1] - pose.y))
    return length(path) <= straight + _DETOUR


def deviation(path: NDArray[np.float64], other: NDArray[np.float64]) -> float:
    """Return how far the farthest pose of a path lies from another path [m]."""
    gaps = path[::4, None, :2] - other[None, ::2, :2]
    return float(np.sqrt(np.square(gaps).sum(axis=2).min(axis=1).max()))


def ahead(path: NDArray[np.float64], pose: SE2) -> NDArray[np.float64]:
    """Return the part of a path from the pose nearest to the robot."""
    return path[nearest(path, pose) :]
