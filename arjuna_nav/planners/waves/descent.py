"""The descent of a potential to where its wave began."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from arjuna_core.arrays import Floats, Singles


@njit(cache=True, nogil=True)
def descend(potential: Singles, start: tuple[int, int]) -> Floats:
    """Follow the potential down from a reached cell to a seed of its wave.

    Goes half a cell down the gradient at a time; where that is not defined or does not lead lower,
    to the lowest of the eight neighbours, never across a blocked corner.

    Args:
        potential: Of `wavefront`.
        start: `(row, column)` of a cell the wave reached.

    Returns:
        `(N, 2) float64` of `(row, column)`, cells' centres at whole numbers, the seed last.
    """
    # Room for points at first; it doubles where it is not enough.
    points = np.empty((1024, 2))
    row, column = start
    points[0, 0], points[0, 1] = start
    r, c = points[0]
    count, here = 1, 0
    while not _is_bottom(potential, row, column):
        d_r, d_c = _gradient(potential, r, c)
        norm = math.sqrt(d_r * d_r + d_c * d_c)
        here, descends = here + 1, False
        # 6 steps are twice what crosses a diagonal: more go in a circle.
        if norm > 0.0 and here <= 6:
            # Half a cell, pathStep of nav2_navfn_planner.
            next_r, next_c = r - 0.5 * d_r / norm, c - 0.5 * d_c / norm
            cell = math.floor(next_r + 0.5), math.floor(next_c + 0.5)
            descends = cell == (row, column) or potential[cell] < potential[row, column]
        if not descends:
            cell = _lowest(potential, row, column)
            next_r, next_c = float(cell[0]), float(cell[1])
        if cell != (row, column):
            row, column = cell
            here = 0
        if count == len(points) - 1:
            points = np.vstack((points, np.empty_like(points)))
        r, c = next_r, next_c
        points[count, 0], points[count, 1] = r, c
        count += 1
    points[count, 0], points[count, 1] = row, column
    path: Floats = points[: count + 1].copy()
    return path


@njit(cache=True)
def _gradient(potential: Singles, r: float, c: float) -> tuple[float, float]:
    """Return the gradient at a point, bilinear between cells; (0, 0) next to cells not reached."""
    height, width = potential.shape
    row, column = math.floor(r), math.floor(c)
    if not (1 <= row < height - 2 and 1 <= column < width - 2):
        return 0.0, 0.0
    a, b = r - row, c - column
    low, right = potential[row, column], potential[row, column + 1]
    up, up_right = potential[row + 1, column], potential[row + 1, column + 1]
    d_r = (1.0 - a) * (1.0 - b) * 0.5 * (up - potential[row - 1, column])
    d_r += (1.0 - a) * b * 0.5 * (up_right - potential[row - 1, column + 1])
    d_r += a * (1.0 - b) * 0.5 * (potential[row + 2, column] - low)
    d_r += a * b * 0.5 * (potential[row + 2, column + 1] - right)
    d_c = (1.0 - a) * (1.0 - b) * 0.5 * (right - potential[row, column - 1])
    d_c += (1.0 - a) * b * 0.5 * (potential[row, column + 2] - low)
    d_c += a * (1.0 - b) * 0.5 * (up_right - potential[row + 1, column - 1])
    d_c += a * b * 0.5 * (potential[row + 1, column + 2] - up)
    if not math.isfinite(d_r + d_c):
        return 0.0, 0.0
    return d_r, d_c


@njit(cache=True, inline="always")
def _is_bottom(potential: Singles, row: int, column: int) -> bool:
    """Return whether no neighbour is lower; the straight ones, of which one mostly is, first."""
    height, width = potential.shape
    value = potential[row, column]
    if row > 0 and potential[row - 1, column] < value:
        return False
    if column > 0 and potential[row, column - 1] < value:
        return False
    if row < height - 1 and potential[row + 1, column] < value:
        return False
    if column < width - 1 and potential[row, column + 1] < value:
        return False
    return _lowest(potential, row, column) == (row, column)


@njit(cache=True)
def _lowest(potential: Singles, row: int, column: int) -> tuple[int, int]:
    """Return the neighbour with the least potential; diagonal ones count unless a corner blocks."""
    height, width = potential.shape
    best_r, best_c, best = row, column, potential[row, column]
    for r in range(max(row - 1, 0), min(row + 2, height)):
        for c in range(max(column - 1, 0), min(column + 2, width)):
            open_corner = potential[row, c] < np.inf and potential[r, column] < np.inf
            if open_corner and potential[r, c] < best:
                best_r, best_c, best = r, c, potential[r, c]
    return best_r, best_c
