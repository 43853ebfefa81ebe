"""The potential of a wave over a costmap, and the cells that a wave can reach."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from arjuna_core.arrays import Bools, Bytes, Floats, Ints, Singles
from arjuna_nav.costmap.costmap import INSCRIBED, LETHAL, UNKNOWN
from arjuna_nav.planners.base import check_stopped, stop_flag

EVERYWHERE: Bools = np.empty((0, 0), np.bool_)
"""The corridor of a search that has none."""

NEUTRAL = 50.0  # COST_NEUTRAL and COST_FACTOR of nav2_navfn_planner
COST_FACTOR = 0.8
_BAND = np.float32(2.0 * NEUTRAL)  # priInc of nav2_navfn_planner
_SETTLED = (1.0, 2.0 * NEUTRAL)  # the gradient at the target looks two cells about it
_LEAST_GAIN = np.float32(0.5)  # of a cell's cost, by which a neighbour has to be lower
_INF = np.float32(np.inf)
_C0, _C1, _C2 = np.float32(0.7040), np.float32(0.5307), np.float32(0.2301)
_QUEUED = np.uint8(LETHAL)
_NOWHERE = (-1, -1)
_Beside = tuple[np.float32, np.float32, np.float32, np.float32]


def traversal_costs(allow_unknown: bool = True) -> Singles:
    """Return the cost of crossing a cell by its costmap's value, `(256,) float32`.

    `50 + 0.8 c`, inf where the robot's centre may not be; unknown costs as much as
    the costliest free cell.

    Source: nav2_navfn_planner, setCostmap.
    """
    return closed(NEUTRAL + COST_FACTOR * np.arange(256, dtype=np.float64), allow_unknown)


def closed(costs: NDArray[np.floating[Any]], allow_unknown: bool) -> Singles:
    """Return costs `(256,)` by cells' values, inf where the robot's centre may not be; float32.

    Unknown costs as much as the costliest free cell, or inf.
    """
    costs[UNKNOWN] = costs[INSCRIBED - 1] if allow_unknown else np.inf
    costs[INSCRIBED:UNKNOWN] = np.inf
    return costs.astype(np.float32)


def wavefront(
    data: Bytes,
    costs: Singles,
    seeds: Floats,
    target: tuple[int, int] = _NOWHERE,
    corridor: Bools = EVERYWHERE,
    shift: int = 0,
    beyond: tuple[float, float] = _SETTLED,
) -> Singles:
    """Return the potential of each cell: the cost to reach it from the nearest seed.

    Args:
        data: `(height, width) uint8` costs of a costmap.
        costs: Of `traversal_costs`; a LETHAL cell is closed.
        seeds: `(N, 3)` row, column and potential of the cells where the wave begins.
        target: Cell at which the wave may stop; without, it covers all that can be reached.
        corridor: Where the wave may go, a cell for each `2**shift` squared of the data's, or empty.
        shift: See `corridor`.
        beyond: Factor on the target's potential, and what is added, up to which all are final.

    Returns:
        `(height, width) float32`, inf where the wave did not come; not contiguous.

    Source: Konolige's NavFn as in nav2_navfn_planner: the quadratic fit of the eikonal equation,
        and three buffers of cells in bands of potential, which are the buckets of Meyer and
        Sanders, Delta-stepping, 2003. Nav2 offers a cell again that is 0.707 of its cost above a
        neighbour; with 0.5 potentials are 3 % too high at the most, not 4.
    """
    cells = _rimmed(data, corridor, shift)
    potential, width = np.full(cells.shape, np.inf, np.float32), cells.shape[1]
    goal = (target[0] + 1) * width + target[1] + 1 if target != _NOWHERE else -1
    numbers = (seeds[:, 0] + 1) * width + seeds[:, 1] + 1
    _expand(
        cells.ravel(),
        costs,
        width,
        numbers.astype(np.uint32),
        seeds[:, 2].astype(np.float32),
        goal,
        (np.float32(beyond[0]), np.float32(beyond[1])),
        potential.ravel(),
        cells.ravel().copy(),
        np.empty((3, data.size + 1), np.uint32),
        stop_flag(),
    )
    check_stopped()
    return potential[1:-1, 1:-1]


def _rimmed(data: Bytes, corridor: Bools, shift: int) -> Bytes:
    """Return the data of a corridor, closed all round and beside it."""
    cells = np.full((data.shape[0] + 2, data.shape[1] + 2), LETHAL, np.uint8)
    if corridor.size:
        _open_corridor(data, corridor, shift, cells)
    else:
        cells[1:-1, 1:-1] = data
    return cells


@njit(cache=True, nogil=True)
def _open_corridor(data: Bytes, corridor: Bools, shift: int, cells: Bytes) -> None:
    """Copy the data of the corridor into cells that have a rim."""
    size, (height, width) = 1 << shift, data.shape
    for i in range(corridor.shape[0]):
        for j in range(corridor.shape[1]):
            if corridor[i, j]:
                for row in range(i * size, min((i + 1) * size, height)):
                    for column in range(j * size, min((j + 1) * size, width)):
                        cells[row + 1, column + 1] = data[row, column]


# A rim of closed cells, unsigned cell numbers and queueing without a branch make it fast:
# `bench planner` times it beside the same in C.
@njit(cache=True, error_model="numpy", nogil=True)
def _expand(
    cells: Bytes,
    costs: Singles,
    width: int,
    seeds: NDArray[np.uint32],
    values: Singles,
    target: int,
    beyond: tuple[np.float32, np.float32],
    potential: Singles,
    seen: Bytes,
    queues: NDArray[np.uint32],
    stop: Bools,
) -> None:
    """Fill `potential`; all arrays are flat, `width` is that of a row with its rim.

    The queues hold the cells of this round, of the next round of the band, and of later bands.
    `seen` holds `cells` with the queued ones closed.
    """
    row, none, least = np.uint32(width), np.uint32(0), costs * _LEAST_GAIN
    now, following, later = queues[0], queues[1], queues[2]
    count, n_next, n_later = none, none, none
    potential[seeds] = values
    for i in range(len(seeds)):
        beside = _beside(potential, seeds[i], row)
        count = _offer(seeds[i], row, values[i], beside, least, seen, now, count)
    limit, lowest = np.min(values) + _BAND, _INF
    while count > 0 and not stop[0]:
        for i in range(count):
            cell = now[i]
            seen[cell] = cells[cell]
            beside = _beside(potential, cell, row)
            value = _fit(beside, costs[cells[cell]])
            if not value < potential[cell]:
                continue
            potential[cell] = value
            if value < limit:
                n_next = _offer(cell, row, value, beside, least, seen, following, n_next)
            else:
                n_later = _offer(cell, row, value, beside, least, seen, later, n_later)
                lowest = min(lowest, value)
        now, following, count, n_next = following, now, n_next, none
        if count == 0:
            if target >= 0 and beyond[0] * potential[target] + beyond[1] < lowest:
                return
            limit, lowest = lowest + _BAND, _INF
            now, later, count, n_later = later, now, n_later, none


@njit(cache=True)
def _beside(potential: Singles, cell: np.uint32, row: np.uint32) -> _Beside:
    """Return the potentials to the left and right, above and below."""
    one = np.uint32(1)
    across = potential[cell - one], potential[cell + one]
    return across[0], across[1], potential[cell - row], potential[cell + row]


@njit(cache=True, error_model="numpy")
def _fit(beside: _Beside, cost: np.float32) -> np.float32:
    """Return a cell's potential from its lower neighbour in each direction."""
    across, along = min(beside[0], beside[1]), min(beside[2], beside[3])
    low, difference = min(across, along), abs(across - along)
    ratio = difference / cost
    value: np.float32 = low + cost * (_C0 + ratio * (_C1 - _C2 * ratio))
    return value if difference < cost else low + cost


@njit(cache=True)
def _offer(
    cell: np.uint32,
    row: np.uint32,
    value: np.float32,
    beside: _Beside,
    least: Singles,
    seen: Bytes,
    queue: NDArray[np.uint32],
    count: np.uint32,
) -> np.uint32:
    """Queue the neighbours that a cell's new value may lower; return how many are queued.

    Without a branch, which could not be predicted.
    """
    one = np.uint32(1)
    for k, other in enumerate((cell - one, cell + one, cell - row, cell + row)):
        cost = seen[other]
        lowers = beside[k] > value + least[cost]
        queue[count] = other
        seen[other] = _QUEUED if lowers else cost
        count += np.uint32(lowers)
    return count


def reachable(data: Bytes, costs: Singles, seeds: Floats) -> Bools:
    """Return which cells a wave would reach from its seeds, `(height, width) bool`.

    Args:
        data: `(height, width) uint8` costs of a costmap.
        costs: Of `traversal_costs`.
        seeds: `(N, 3)` row, column and potential of the cells where the wave begins.
    """
    reached = np.zeros(data.shape, np.bool_)
    _flood(data, np.isfinite(costs), seeds[:, :2].astype(np.int64), reached)
    return reached


@njit(cache=True, nogil=True)
def _flood(data: Bytes, crossable: Bools, seeds: Ints, reached: Bools) -> None:
    """Fill `reached` run by run of a row.

    Source: Smith, Tint fill, SIGGRAPH 1979.
    """
    height, width = data.shape
    stack = [(np.int64(0), np.int64(0))]
    stack.pop()
    for row, column in seeds:
        reached[row, column] = False
        stack.append((row, column))
    while len(stack) > 0:
        row, column = stack.pop()
        if reached[row, column]:
            continue
        first, last = column, column
        while first > 0 and crossable[data[row, first - 1]]:
            first -= 1
        while last < width - 1 and crossable[data[row, last + 1]]:
            last += 1
        reached[row, first : last + 1] = True
        for other in (row - 1, row + 1):
            if not 0 <= other < height:
                continue
            before = False
            for k in range(first, last + 1):
                opens = crossable[data[other, k]] and not reached[other, k]
                if opens and not before:
                    stack.append((other, k))
                before = opens
    return
