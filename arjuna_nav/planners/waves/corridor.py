"""Corridors of good paths, by an estimate on coarse grids."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, TypeVar

import numpy as np
from numba import njit
from numpy.typing import NDArray

from arjuna_core.arrays import Bools, Bytes, Singles
from arjuna_nav.costmap.costmap import INSCRIBED, LETHAL
from arjuna_nav.planners.waves.potential import EVERYWHERE, NEUTRAL, wavefront

T = TypeVar("T")

_FINE, _COARSE = 2, 3  # cells of 4 x 4 of the map's, and before of 8 x 8 where they may lie
_BLOCKED = 60  # added to a coarse cell's value by the share that is blocked: paths bend round it
_DOUBTFUL = 1.1  # a path costlier than estimated by this factor may not be the best
_ONE = np.uint32(1 << 16)  # cell, in a sum of values


class Corridor(NamedTuple):
    """The coarse cells that a good path may cross, and what it may cost.

    Attributes:
        open: `(height >> shift, width >> shift) bool`, rounded up.
        shift: A coarse cell is `2**shift` squared of the map's.
        most: Cost up to which a path within is the best; else there may be a better one.
    """

    open: Bools
    shift: int
    most: float


UNBOUNDED = Corridor(EVERYWHERE, 0, np.inf)


def corridors(
    data: Bytes,
    costs: Singles,
    start: tuple[int, int],
    goal: tuple[int, int],
    slack: float,
    width: float = 0.0,
) -> tuple[Corridor, ...] | None:
    """Return the coarse cells through which paths cost by estimate little more than the least.

    First those of the finer grid, then those of the coarser one that hold them. They cost at most
    `1 + slack` times the least, and a little more. A coarse cell is open where one of its cells is,
    and costs what these cost on average, the more the more of it is blocked. Where the finer grid
    shows a wall where the coarser one is open, its corridor is searched again on all of the map.

    Args:
        data: `(height, width) uint8` costs of a costmap.
        costs: What it costs to cross a cell by its value, as of `traversal_costs`.
        start: `(row, column)`.
        goal: As `start`.
        slack: See above.
        width: Cells of the map that a path may need to each side, for a robot that bends.

    Returns:
        None at all where the map is small or a maze; None where no path leads to the goal, for what
        is closed on a coarse grid is closed.

    Source: the bound of bidirectional search (Pohl 1971) on a pyramid of pooled maps.
    """
    if not np.isfinite(costs[data[goal]]):
        return None
    # A wave over fewer than 256 x 256 cells needs no corridor.
    if data.size < 256 * 256 or _is_maze(data, costs):
        return ()
    sums = _sums(data, costs, 1 << _FINE)
    ask = costs, start, goal, slack, width
    coarse = _corridor(_pooled(_halved(sums), 1 << _COARSE), _COARSE, *ask)
    if coarse is None:
        return None
    cells = _pooled(sums, 1 << _FINE)
    fine = _corridor(_within(cells, coarse.open), _FINE, *ask)
    if fine is not None and fine.most <= coarse.most * _DOUBTFUL:
        return fine, coarse
    fine = _corridor(cells, _FINE, *ask)
    return None if fine is None else (fine,)


def _is_maze(data: Bytes, costs: Singles) -> bool:
    """Return whether few of a sample's coarse cells are free as a whole."""
    counts = _sums(_strips(data), costs, 1 << _FINE)[1]
    whole = np.count_nonzero(counts == 1 << 2 * _FINE)
    # Below two thirds, walls too thin to be seen may be anywhere.
    return bool(whole < 2 / 3 * np.count_nonzero(counts))


def _corridor(
    cells: Bytes,
    shift: int,
    costs: Singles,
    start: tuple[int, int],
    goal: tuple[int, int],
    slack: float,
    width: float,
) -> Corridor | None:
    """Return the corridor of a coarse grid, None where no path leads through it."""
    ends = [(cell[0] >> shift, cell[1] >> shift) for cell in (start, goal)]
    # 6 cells of slack: three coarse cells to either side of a straight path.
    beyond = 1.0 + slack, (6.0 + 2.0 * width / (1 << shift)) * NEUTRAL
    waves = [
        wavefront(cells, costs, np.array([[*end, 0.0]]), other, beyond=beyond)
        for end, other in (ends, ends[::-1])
    ]
    least = float(waves[0][ends[1]])
    if not np.isfinite(least):
        return None
    within = waves[0] + waves[1] <= beyond[0] * least + beyond[1]
    return Corridor(within, shift, least * _DOUBTFUL * (1 << shift))


def guided(
    look: Callable[[Corridor], T], path_cost: Callable[[T], float], within: tuple[Corridor, ...]
) -> T:
    """Return what a search finds in the first corridor that it is believed in, else everywhere.

    A search through a corridor is believed unless it did not reach the goal, or at a cost
    that shows that the estimate took a door for wider than it is.

    Args:
        look: Searches within a corridor.
        path_cost: Returns the cost of the path to the goal that was found, inf for none.
    """
    for one in within:
        found = look(one)
        if path_cost(found) <= one.most:
            return found
    return look(UNBOUNDED)


@njit(cache=True, inline="always")
def is_outside(within: Corridor, row: int, column: int) -> bool:
    """Return whether a cell of the map lies outside of a corridor."""
    bounded = within.open.shape[0] > 0
    return bounded and not within.open[row >> within.shift, column >> within.shift]


def _strips(data: Bytes) -> Bytes:
    """Return a ninth of a map: rows of whole coarse cells, apart."""
    height, width = data.shape
    # 36 rows apart are enough to judge.
    apart = min(36, height)
    rows = data[: height // apart * apart].reshape(-1, apart, width)[:, : 1 << _FINE]
    return rows.reshape(-1, width)


@njit(cache=True, nogil=True)
def _sums(data: Bytes, costs: Singles, size: int) -> NDArray[np.int32]:
    """Return the sum of the open cells' values in each coarse cell, and their number.

    Both in one number of 32 bits while they are summed, from a table.
    """
    height, width = data.shape
    table = np.zeros(256, np.uint32)
    for value in range(256):
        if costs[value] < np.inf:
            table[value] = _ONE + min(value, INSCRIBED - 1)
    rows, columns = (height + size - 1) // size, (width + size - 1) // size
    result = np.empty((2, rows, columns), np.int32)
    for i in range(rows):
        for j in range(columns):
            total = np.uint32(0)
            for row in range(i * size, min((i + 1) * size, height)):
                for value in data[row, j * size : (j + 1) * size]:
                    total += table[value]
            result[0, i, j], result[1, i, j] = total % _ONE, total // _ONE
    return result


def _halved(sums: NDArray[np.int32]) -> NDArray[np.int32]:
    """Return the sums of a grid half as fine."""
    padded = np.pad(sums, ((0, 0), (0, sums.shape[1] % 2), (0, sums.shape[2] % 2)))
    rows = padded[:, ::2] + padded[:, 1::2]
    halved: NDArray[np.int32] = rows[:, :, ::2] + rows[:, :, 1::2]
    return halved


@njit(cache=True)
def _pooled(sums: NDArray[np.int32], size: int) -> Bytes:
    """Return each coarse cell's value, LETHAL where none of its cells is open."""
    _, height, width = sums.shape
    result = np.full((height, width), LETHAL, np.uint8)
    for row in range(height):
        for column in range(width):
            total, count = sums[0, row, column], sums[1, row, column]
            if count > 0:
                blocked = _BLOCKED - _BLOCKED * count // (size * size)
                result[row, column] = min(total // count + blocked, INSCRIBED - 1)
    return result


def _within(cells: Bytes, coarse: Bools) -> Bytes:
    """Return the cells of a grid twice as fine, closed outside of a corridor."""
    height, width = cells.shape
    finer = coarse.repeat(2, axis=0).repeat(2, axis=1)[:height, :width]
    return np.where(finer, cells, np.uint8(LETHAL))
