"""The poses that a search over poses has reached: a row each, in a table that grows."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from arjuna_core.arrays import Bools, Floats, Ints

ROOM = 4096  # rows at first; it doubles
BLOCK = 4  # edge of a block of cells of an index


class PoseTable(NamedTuple):
    """The poses reached, a row each.

    Attributes:
        poses: `(N, 3) float64` of the grid [cells, rad].
        values: `(N,) float64` what it cost to come there.
        before: `(N,) int64` the row before, -1 at the start.
        kinds: `(N,) int64` number of the move that led there, -1 at the start.
        done: `(N,) bool` whether nothing cheaper leads there any more.
    """

    poses: Floats
    values: Floats
    before: Ints
    kinds: Ints
    done: Bools


class RowIndex(NamedTuple):
    """The row of the pose in each cell and heading: blocks of cells, made where poses come.

    Attributes:
        blocks: `(rows, columns) int32` number of the block of `BLOCK` squared cells, -1 for none.
        slots: `(N, BLOCK * BLOCK * headings) int32` rows of a block's poses, -1 for none.
        used: `(1,) int32` how many blocks there are.
    """

    blocks: NDArray[np.int32]
    slots: NDArray[np.int32]
    used: NDArray[np.int32]


@njit(cache=True)
def indexed(height: int, width: int, headings: int) -> RowIndex:
    """Return an index of no rows over a grid of cells.

    Source: `bench planner` times searches over it; a dictionary is slower, and an array of all
    cells and headings of a map of 4000 x 4000 takes gigabytes.
    """
    blocks = np.full((height // BLOCK + 1, width // BLOCK + 1), -1, np.int32)
    return RowIndex(
        blocks, np.empty((16, BLOCK * BLOCK * headings), np.int32), np.zeros(1, np.int32)
    )


@njit(cache=True)
def with_block(index: RowIndex, row: int, column: int) -> RowIndex:
    """Return the index, or a larger one, in which a cell has a block."""
    at = row // BLOCK, column // BLOCK
    if index.blocks[at] >= 0:
        return index
    number = index.used[0]
    slots = index.slots
    if number == len(slots):
        slots = np.empty((2 * number, slots.shape[1]), np.int32)
        slots[:number] = index.slots
    slots[number] = -1
    index.blocks[at] = number
    index.used[0] += 1
    return RowIndex(index.blocks, slots, index.used)


@njit(cache=True, inline="always")
def slot_of(index: RowIndex, row: int, column: int, heading: int) -> tuple[int, int]:
    """Return where in the slots the row of a pose stands, in a cell that has a block."""
    inside = (row % BLOCK) * BLOCK + column % BLOCK
    headings = index.slots.shape[1] // (BLOCK * BLOCK)
    return index.blocks[row // BLOCK, column // BLOCK], inside * headings + heading


@njit(cache=True)
def row_at(index: RowIndex, row: int, column: int, heading: int) -> int:
    """Return the row of the pose in a cell and heading, -1 for none."""
    if index.blocks[row // BLOCK, column // BLOCK] < 0:
        return -1
    return int(index.slots[slot_of(index, row, column, heading)])


@njit(cache=True)
def new_table(start: Floats, size: int = ROOM) -> PoseTable:
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
    larger = new_table(table.poses[0], 2 * len(table.values))
    larger.poses[:count] = table.poses[:count]
    larger.values[:count] = table.values[:count]
    larger.before[:count] = table.before[:count]
    larger.kinds[:count] = table.kinds[:count]
    larger.done[:count] = table.done[:count]
    return larger


@njit(cache=True)
def rows_to(table: PoseTable, row: int) -> Ints:
    """Return the rows from the start to a row."""
    rows = [row]
    while table.before[rows[-1]] >= 0:
        rows.append(table.before[rows[-1]])
    return np.array(rows[::-1])
