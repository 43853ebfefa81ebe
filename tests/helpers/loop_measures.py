"""Measures of a trajectory's loops against the truth: near poses, closures, position."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from arjuna_core.raycast import cast
from arjuna_core.se2 import SE2
from arjuna_slam.graph.pose_graph import Edge
from tests.helpers.buildings import RESOLUTION, Building

_NEAR, _APART = 1.5, 20.0  # two poses near each other, and the path between two visits [m]
_RUN_GAP = 5  # scans that revisit nothing without ending a loop
_SLACK = np.diag([0.1**2, 0.1**2, 0.03**2])  # on top of what a closure claims of itself
_DEVIATIONS = 3.0


def near_pairs(true: NDArray[np.float64], walls: Building | None) -> NDArray[np.int64]:
    """Return pairs of poses near each other with a path between them, `(P, 2) int64`.

    Args:
        true: The true poses, `(N, 3) float64` [m, m, rad].
        walls: Only pairs in sight of each other count; None for all.
    """
    travel = travelled(true)
    pairs: NDArray[np.int64] = cKDTree(true[:, :2]).query_pairs(_NEAR, output_type="ndarray")
    pairs = pairs[np.abs(travel[pairs[:, 1]] - travel[pairs[:, 0]]) > _APART]
    pairs = pairs[np.lexsort((pairs[:, 0], pairs[:, 1]))]
    if walls is None:
        return pairs
    seen = np.array([_in_sight(true[i], true[j], walls) for i, j in pairs], np.bool_)
    visible: NDArray[np.int64] = pairs[seen]
    return visible


def _in_sight(a: NDArray[np.float64], b: NDArray[np.float64], walls: Building) -> bool:
    gap = b - a
    bearing, far = np.array([math.atan2(gap[1], gap[0])]), math.hypot(gap[0], gap[1])
    free = cast(walls.blocked, RESOLUTION, float(a[0]), float(a[1]), bearing, far)[0]
    return bool(free >= far)


def travelled(true: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the distance driven to each pose from the first, `(N,) float64` [m]."""
    steps = np.hypot(*np.diff(true[:, :2], axis=0).T)
    return np.concatenate(([0.0], np.cumsum(steps)))


def errors(
    found: NDArray[np.float64], true: NDArray[np.float64], pairs: NDArray[np.int64]
) -> NDArray[np.float64]:
    """Return how far off the second of each pair is as seen from the first, `(P,)` [m]."""
    seen = []
    for poses in (found, true):
        first, second = poses[pairs[:, 0]], poses[pairs[:, 1]]
        c, s = np.cos(first[:, 2]), np.sin(first[:, 2])
        dx, dy = (second - first)[:, :2].T
        seen.append(np.array([c * dx + s * dy, c * dy - s * dx]))
    error: NDArray[np.float64] = np.hypot(*(seen[0] - seen[1]))
    return error


def agreement_of_loops(pairs: NDArray[np.int64], good: NDArray[np.bool_]) -> list[float]:
    """Return the share of agreeing pairs of each stretch that revisits."""
    return [float(good[k].mean()) for k in _stretches(pairs)]


def _stretches(pairs: NDArray[np.int64]) -> Iterator[NDArray[np.int64]]:
    if len(pairs):
        breaks = np.flatnonzero(np.diff(pairs[:, 1]) > _RUN_GAP) + 1
        yield from np.split(np.arange(len(pairs)), breaks)


def is_wrong(edge: Edge, truth: list[SE2]) -> bool:
    """Return whether a closure is off by more than it says of itself, and some slack."""
    true = truth[edge.i].inverse() @ truth[edge.j]
    error = edge.T_i_j.array() - true.array()
    error[2] = math.remainder(error[2], 2.0 * math.pi)
    claimed = np.linalg.inv(edge.information) + _SLACK
    return bool(error @ np.linalg.solve(claimed, error) > _DEVIATIONS**2)


def aligned_error(found: NDArray[np.float64], true: NDArray[np.float64]) -> float:
    """Return the root mean square error of positions after the best rigid alignment [m]."""
    a, b = (complex_poses - complex_poses.mean() for complex_poses in map(_complex, (found, true)))
    turn = np.vdot(a, b)
    return float(np.sqrt(np.mean(np.abs(a * turn / max(abs(turn), 1e-12) - b) ** 2)))


def _complex(poses: NDArray[np.float64]) -> NDArray[np.complex128]:
    points: NDArray[np.complex128] = poses[:, 0] + 1j * poses[:, 1]
    return points
