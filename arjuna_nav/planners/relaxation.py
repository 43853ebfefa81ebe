"""Paths relaxed: each point between its neighbours, and near to where it was."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from numba import njit

from arjuna_core.arrays import Floats
from arjuna_core.config import length_param, param
from arjuna_nav.costmap.costmap import INSCRIBED, UNKNOWN, Costmap


@dataclass(frozen=True)
class SmootherConfig:
    """Smoothing of a planner's path."""

    max_iterations: int = param(1000, "Most iterations.", minimum=1)
    w_smooth: float = param(0.3, "Weight of smoothness.", minimum=0.0)
    w_data: float = param(0.2, "Weight of the path found.", minimum=0.0)
    tolerance: float = length_param(1e-10, "Change at which it has converged.")
    do_refinement: bool = param(True, "Whether to smooth the smoothed path again.")
    refinement_num: int = param(2, "How many times again.", minimum=0)


def smoothed(points: Floats, costmap: Costmap, config: SmootherConfig) -> Floats:
    """Return points `(N, 2)` [m] smoothed as far as they touch nothing; both ends stay."""
    points = np.ascontiguousarray(points)
    for _ in range(1 + config.refinement_num * config.do_refinement):
        other = relax(
            points, config.w_data, config.w_smooth, config.tolerance, config.max_iterations
        )
        if touches(_finely(other), costmap):
            break
        points = other
    return points


def smoothed_poses(path: Floats, costmap: Costmap, config: SmootherConfig) -> Floats:
    """Return a path `(N, 3)` whose parts that are driven in one direction are smoothed.

    The poses at a part's ends and beside them stay, and with them the headings there.
    """
    path, steps = path.copy(), np.diff(path[:, :2], axis=0)
    ahead = steps[:, 0] * np.cos(path[:-1, 2]) + steps[:, 1] * np.sin(path[:-1, 2])
    directions = np.sign(np.round(ahead, 6))  # 0: it turns on the spot
    ends = [0, *(np.flatnonzero(np.diff(directions)) + 1), len(steps)]
    for first, last in itertools.pairwise(ends):
        if directions[first] and last - first > 3:
            path[first + 1 : last, :2] = smoothed(path[first + 1 : last, :2], costmap, config)
            along = directions[first] * (path[first + 2 : last + 1] - path[first : last - 1])
            path[first + 1 : last, 2] = np.arctan2(along[:, 1], along[:, 0])
    return path


def _finely(points: Floats) -> Floats:
    """Return points with three more between any two, for what lies between is driven too."""
    steps = np.diff(points, axis=0)
    parts = [points[:-1] + ratio * steps for ratio in (0.0, 0.25, 0.5, 0.75)]
    return np.vstack((*parts, points[-1:]))


@njit(cache=True, nogil=True)
def relax(given: Floats, w_data: float, w_smooth: float, tolerance: float, max_its: int) -> Floats:
    """Return points `(N, 2)` pulled to their neighbours' middle and to where they were.

    Args:
        given: The points; both ends stay.
        w_data: Weight of where they were.
        w_smooth: Weight of their neighbours' middle.
        tolerance: Change at which it has converged.

    Source: Thrun, path smoothing by gradient descent; nav2_smoother.
    """
    points: Floats = given.copy()
    # Over-relaxation diverges from 2 on. Where it ends, the weights' ratio says, not their size.
    relaxation = max(1.0, (w_data + 2.0 * w_smooth) / 1.9)
    w_data, w_smooth = w_data / relaxation, w_smooth / relaxation
    for _ in range(max_its):
        change = 0.0
        for i in range(1, len(points) - 1):
            for k in range(2):
                old = points[i, k]
                pull = points[i - 1, k] + points[i + 1, k] - 2.0 * old
                points[i, k] = old + w_data * (given[i, k] - old) + w_smooth * pull
                change += abs(points[i, k] - old)
        if change < tolerance:
            break
    return points


def touches(points: Floats, costmap: Costmap) -> bool:
    """Return whether a point `(N, 2)` [m] is off the costmap or in a cell closed to the robot."""
    cells = costmap.frame.to_cells(points)
    if not costmap.frame.inside(cells).all():
        return True
    costs = costmap.data[tuple(cells.T)]
    return bool(((costs >= INSCRIBED) & (costs != UNKNOWN)).any())
