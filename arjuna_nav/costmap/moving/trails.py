"""Trails of moving things, which are free, and costs of the paths ahead of them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from arjuna_core.arrays import Bytes, Floats
from arjuna_core.grid import GridFrame
from arjuna_core.se2 import SE2
from arjuna_nav.costmap.window import Window, clipped

_TRAIL = 0.9  # as long as a thing may have moved before that was known [s]
_NOISE = 0.05  # beside a thing, where it may have been marked as well [m]


@dataclass(frozen=True, eq=False)
class Patch:
    """Costs of a part of a grid.

    Attributes:
        costs: Of the window's shape, `uint8`.
    """

    window: Window
    costs: Bytes


def path_costs(
    things: Floats, since: float, time: float, radius: float, frame: GridFrame
) -> Patch | None:
    """Return costs of the paths of things, less the later they pass; None for nothing.

    Args:
        things: `(K, 5)` as `Moving` has them, of the grid's frame.
        since: How old they are [s].
        time: Time ahead for which their paths count [s].
        radius: The robot's, about its middle [m].
    """
    if not len(things):
        return None
    # The cost falls to 0 over 0.3 m beside the path.
    edge = 0.3 / frame.resolution
    positions, goes, sizes = _in_cells(things, since, time, radius, frame)
    reach = sizes[:, None] + edge
    low = np.minimum(positions, positions + goes) - reach
    high = np.maximum(positions, positions + goes) + reach
    x0, y0 = np.floor(low.min(axis=0)).astype(int).tolist()
    x1, y1 = np.ceil(high.max(axis=0)).astype(int).tolist()
    rows, columns = clipped(y0, y1, x0, x1, frame.shape)
    if rows.start >= rows.stop or columns.start >= columns.stop:
        return None
    costs = np.zeros((rows.stop - rows.start, columns.stop - columns.start), np.uint8)
    _draw(costs, positions - (columns.start, rows.start), goes, sizes, edge)
    return Patch((rows, columns), costs)


def free_trails(data: NDArray[Any], things: Floats, frame: GridFrame, free: int) -> Window | None:
    """Free the cells where things have just been, in place: nothing can stand there.

    Args:
        data: `(height, width)`, of any whole numbers.
        things: `(K, 5)` as `Moving` has them, of the grid's frame.

    Returns:
        What has changed; None for nothing.
    """
    if not len(things):
        return None
    row0, row1, column0, column1 = _erase(
        data, *_in_cells(things, 0.0, -_TRAIL, _NOISE, frame), free
    )
    return (slice(row0, row1), slice(column0, column1)) if row0 < row1 else None


def _in_cells(
    things: Floats, since: float, time: float, more: float, frame: GridFrame
) -> tuple[Floats, Floats, Floats]:
    """Return the positions, motions within a time and radii of things, in cells."""
    T_grid_frame, cell = frame.origin.inverse(), frame.resolution
    positions = T_grid_frame.apply(things[:, :2] + since * things[:, 2:4]) / cell
    goes = SE2(0.0, 0.0, T_grid_frame.theta).apply(things[:, 2:4]) * (time / cell)
    return positions, goes, (things[:, 4] + more) / cell


@njit(cache=True)
def _draw(costs: Bytes, positions: Floats, goes: Floats, sizes: Floats, edge: float) -> None:
    """Fill in the cost of each cell by when and how near things come by; lengths in cells."""
    for k in range(len(positions)):
        x, y = positions[k]
        row0, row1, column0, column1 = _about(costs, x, y, goes[k], sizes[k] + edge)
        for row in range(row0, row1):
            for column in range(column0, column1):
                share, beside = _passed(column + 0.5 - x, row + 0.5 - y, goes[k])
                near = min((sizes[k] + edge - beside) / edge, 1.0)
                if near > 0.0:
                    # At most 30, so that paths bend round a thing and do not turn back for it.
                    cost = int(30 * near * (1.0 - share))
                    costs[row, column] = max(costs[row, column], cost)


@njit(cache=True)
def _erase(
    data: NDArray[Any], positions: Floats, goes: Floats, sizes: Floats, free: int
) -> tuple[int, int, int, int]:
    """Free the cells that things have covered; return the rows and columns that have changed."""
    low_row, high_row, low_column, high_column = data.shape[0], 0, data.shape[1], 0
    for k in range(len(positions)):
        x, y = positions[k]
        row0, row1, column0, column1 = _about(data, x, y, goes[k], sizes[k])
        for row in range(row0, row1):
            for column in range(column0, column1):
                if data[row, column] == free:
                    continue
                if _passed(column + 0.5 - x, row + 0.5 - y, goes[k])[1] <= sizes[k]:
                    data[row, column] = free
                    low_row, high_row = min(low_row, row), max(high_row, row + 1)
                    low_column, high_column = min(low_column, column), max(high_column, column + 1)
    return low_row, high_row, low_column, high_column


@njit(cache=True)
def _about(
    data: NDArray[Any], x: float, y: float, motion: Floats, reach: float
) -> tuple[int, int, int, int]:
    """Return the rows and the columns within a reach of a motion."""
    height, width = data.shape
    row0, row1 = min(y, y + motion[1]) - reach, max(y, y + motion[1]) + reach
    column0, column1 = min(x, x + motion[0]) - reach, max(x, x + motion[0]) + reach
    return (
        max(math.floor(row0), 0),
        min(math.ceil(row1), height),
        max(math.floor(column0), 0),
        min(math.ceil(column1), width),
    )


@njit(cache=True)
def _passed(x: float, y: float, motion: Floats) -> tuple[float, float]:
    """Return at which share of a motion a point is passed, and how far beside it that lies."""
    length = max(motion[0] * motion[0] + motion[1] * motion[1], 1e-9)
    share = min(max((x * motion[0] + y * motion[1]) / length, 0.0), 1.0)
    return share, math.hypot(x - share * motion[0], y - share * motion[1])
