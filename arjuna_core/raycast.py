"""Rays through grids: the cells a ray crosses and the range at which it is stopped."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numba import njit

from arjuna_core.arrays import Bools, Floats


@njit(cache=False)  # Numba 0.68 cannot compile a caller of a generator that comes from its cache
def line_cells(row: int, column: int, row1: int, column1: int) -> Iterator[tuple[int, int]]:
    """Yield `(row, column)` of the cells of the line between two cells, both ends included.

    Numba compiles the generator into the caller's loop: it costs no more than one written out.

    Source: Bresenham, Algorithm for computer control of a digital plotter, 1965.
    """
    d_row, d_column = abs(row1 - row), abs(column1 - column)
    step_row = 1 if row1 > row else -1
    step_column = 1 if column1 > column else -1
    error = d_column - d_row
    for _ in range(max(d_row, d_column) + 1):
        yield row, column
        double = 2 * error
        if double > -d_row:
            error -= d_row
            column += step_column
        if double < d_column:
            error += d_column
            row += step_row


@njit(cache=True)
def cast(
    blocked: Bools, resolution: float, x: float, y: float, bearings: Floats, range_max: float
) -> Floats:
    """Return the range at which each ray from one point enters a blocked cell.

    Args:
        blocked: `(height, width) bool`.
        resolution: Edge of a cell [m].
        x: Start of the rays in grid coordinates, from the outer corner of cell (0, 0) [m].
        y: As `x` [m].
        bearings: `(N,) float64` in grid coordinates [rad].
        range_max: Where a ray ends unhindered [m].

    Returns:
        `(N,) float64` [m], inf for rays that meet nothing within `range_max`.

    Source: Amanatides and Woo, A fast voxel traversal algorithm for ray tracing, 1987.
    """
    ranges = np.empty(len(bearings))
    for i in range(len(bearings)):
        ranges[i] = _cast_one(blocked, resolution, x, y, bearings[i], range_max)
    return ranges


@njit(cache=True)
def _cast_one(
    blocked: Bools, resolution: float, x: float, y: float, bearing: float, range_max: float
) -> float:
    height, width = blocked.shape
    c, s = math.cos(bearing), math.sin(bearing)
    column, row = math.floor(x / resolution), math.floor(y / resolution)
    step_column, step_row = (1 if c > 0.0 else -1), (1 if s > 0.0 else -1)
    delta_x = resolution / abs(c) if c != 0.0 else math.inf
    delta_y = resolution / abs(s) if s != 0.0 else math.inf
    edge_x = (column + (1 if c > 0.0 else 0)) * resolution
    edge_y = (row + (1 if s > 0.0 else 0)) * resolution
    next_x = (edge_x - x) / c if c != 0.0 else math.inf
    next_y = (edge_y - y) / s if s != 0.0 else math.inf
    distance = 0.0
    while distance <= range_max:
        if 0 <= row < height and 0 <= column < width and blocked[row, column]:
            return distance
        if next_x < next_y:
            distance = next_x
            next_x += delta_x
            column += step_column
        else:
            distance = next_y
            next_y += delta_y
            row += step_row
    return math.inf
