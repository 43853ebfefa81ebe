"""The poses that a search over poses has reached: a row each, in a table that grows."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

ROOM = 4096  # rows at first; it doubles


class PoseTable(NamedTuple):
    """The poses reached, a row each.

    Attributes:
        poses: `(N, 3) float64` of the grid [cells, rad].
        values: `(N,) float64` what it cost to come there.
        before: `(N,) int64` the row before, -1 at the start.
        kinds: `(N,) int64` number of the move that led there, -1 at the start.
        done: `(N,) bool` whether nothing cheaper leads there any more.
    """

    poses: NDArray[np.float64]
    values: NDArray[np.float64]
    before: NDArray[np.int64]
    kinds: NDArray[np.int64]
    done: NDArray[np.bool_]


@njit(cache=True)
def begun(start: NDArray[np.float64], size: int = ROOM) -> PoseTable:
    """Return a table with room for `size` rows whose first is the start `(3,)`."""
    table = PoseTable(
        np.empty((size, 3)),
        np.zeros(size),
        np.full(size, -1, np.int64),
        np.full(size, -1, np.int64),
        np.zeros(size, np.bool_),
    )
    table.poses[0] = start
    return table


@njit(cache=True)
def with_room(table: PoseTable, count: int, more: int) -> PoseTable:
    """Return the table, or one of twice its size, so that `more` rows fit behind `count`."""
    if count + more <= len(table.values):
        return table
    larger = begun(table.poses[0], 2 * len(table.values))
    larger.poses[:count] = table.poses[:count]
    larger.values[:count] = table.values[:count]
    larger.before[:count] = table.before[:count]
    larger.kinds[:count] = table.kinds[:count]
    larger.done[:count] = table.done[:count]
    return larger


@njit(cache=True)
def rows_to(table: PoseTable, row: int) -> NDArray[np.int64]:
    """Return the rows from the start to a row."""
    rows = [row]
    while table.before[rows[-1]] >= 0:
        rows.append(table.before[rows[-1]])
    return np.array(rows[::-1])
