"""Paths relaxed: each point between its neighbours, and near to where it was."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from arjuna_nav.costmap.costmap import INSCRIBED, UNKNOWN, Costmap


@njit(cache=True)
def relax(
    given: NDArray[np.float64], w_data: float, w_smooth: float, tolerance: float, max_its: int
) -> NDArray[np.float64]:
    """Return points `(N, 2)` pulled to their neighbours' middle and to where they were.

    Args:
        given: The points; both ends stay.
        w_data: Weight of where they were.
        w_smooth: Weight of their neighbours' middle.
        tolerance: Change at which it has converged.
        max_its: Most iterations.

    Source: Thrun, path smoothing by gradient descent; nav2_smoother.
    """
    points: NDArray[np.float64] = given.copy()
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


def touches(points: NDArray[np.float64], costmap: Costmap) -> bool:
    """Return whether a point `(N, 2)` [m] is off the costmap or in a cell closed to the robot."""
    cells = costmap.frame.to_cells(points)
    if not costmap.frame.inside(cells).all():
        return True
    costs = costmap.data[tuple(cells.T)]
    return bool(((costs >= INSCRIBED) & (costs != UNKNOWN)).any())
