"""Potential of a wave that spreads over a costmap: what it costs to reach each cell."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from arjuna_nav.costmap.costmap import INSCRIBED, UNKNOWN

EVERYWHERE: NDArray[np.bool_] = np.empty((0, 0), np.bool_)
"""The corridor of a search that has none."""

NEUTRAL = 50.0  # COST_NEUTRAL and COST_FACTOR of nav2_navfn_planner
COST_FACTOR = 0.8
_BUCKET_WIDTH = 10.0  # a fifth of the least step: order within a bucket hardly matters
_BUCKETS = 64  # more than the 252 / 10 that the potentials in a wave span
_RING = _BUCKETS - 1
_GAIN = np.float32(0.01)  # less is no better way
_INF = np.float32(np.inf)
_C0, _C1, _C2 = np.float32(0.7040), np.float32(0.5307), np.float32(0.2301)
_NOWHERE = (-1, -1)


def traversal_costs(allow_unknown: bool = True) -> NDArray[np.float32]:
    """Return what it costs to cross a cell by its costmap's value, `(256,) float32`.

    `50 + 0.8 c`, inf where the robot's centre may not be; unknown is as dear as can be.

    Source: nav2_navfn_planner, setCostmap.
    """
    costs = (NEUTRAL + COST_FACTOR * np.arange(256)).astype(np.float32)
    costs[UNKNOWN] = costs[INSCRIBED - 1] if allow_unknown else np.inf
    costs[INSCRIBED:UNKNOWN] = np.inf
    return costs


def spread(
    data: NDArray[np.uint8],
    costs: NDArray[np.float32],
    seeds: NDArray[np.float64],
    target: tuple[int, int] = _NOWHERE,
    corridor: NDArray[np.bool_] = EVERYWHERE,
    shift: int = 0,
) -> NDArray[np.float32]:
    """Return the potential of each cell: what it costs to reach it from the nearest seed.

    Args:
        data: `(height, width) uint8` costs of a costmap.
        costs: Of `traversal_costs`.
        seeds: `(N, 3)` row, column and potential of the cells where the wave begins.
        target: Cell at which the wave may stop; without, it covers all that can be reached.
        corridor: Where the wave may go, a cell for each `2**shift` squared of the data's;
            empty for everywhere.
        shift: See `corridor`.

    Returns:
        `(height, width) float32`, inf where the wave did not come.

    Source: Konolige's NavFn as in nav2_navfn_planner: the quadratic fit of the eikonal equation.
        The queue is a ring of buckets (Dial 1969), each a list of cells, its nodes reused so that
        they stay in the cache: `bench planner` shows half the time of nav2's arrays in C++.
    """
    potential = np.full(data.shape, np.inf, np.float32)
    pending = np.zeros(data.shape, np.uint8)
    nodes = np.empty((2, 2 * (data.size + len(seeds))), np.int32)
    _spread(data, costs, seeds, target, corridor, shift, potential, pending, nodes)
    return potential


@njit(cache=True)
def _spread(
    data: NDArray[np.uint8],
    costs: NDArray[np.float32],
    seeds: NDArray[np.float64],
    target: tuple[int, int],
    corridor: NDArray[np.bool_],
    shift: int,
    potential: NDArray[np.float32],
    pending: NDArray[np.uint8],
    nodes: NDArray[np.int32],
) -> None:
    """Fill `potential`; `pending` has each cell's bucket + 1, `nodes` the cells and their nexts."""
    height, width = data.shape
    heads = np.full(_BUCKETS, -1, np.int32)
    free = np.array([-1, 0], np.int32)  # the first free node, and the first never used
    for row, column, value in seeds:
        potential[int(row), int(column)] = value
        _push(int(row), int(column), width, int(value / _BUCKET_WIDTH), pending, heads, nodes, free)
    current, empty, bounded = 0, 0, corridor.shape[0] > 0
    while empty < _BUCKETS:
        slot = current & _RING
        if heads[slot] < 0:
            current, empty = current + 1, empty + 1
            if target[0] >= 0 and current * _BUCKET_WIDTH > potential[target] + 2.0 * NEUTRAL:
                break
            continue
        empty, cell = 0, _pop(slot, heads, nodes, free)
        row = cell // width
        column = cell - row * width
        if pending[row, column] != slot + 1:  # it has moved to another bucket
            continue
        pending[row, column] = 0
        here = potential[row, column]
        for k in range(4):
            r, c = row + (k == 0) - (k == 1), column + (k == 2) - (k == 3)
            if not (0 <= r < height and 0 <= c < width) or potential[r, c] <= here:
                continue
            cost = costs[data[r, c]]
            if cost == _INF or (bounded and not corridor[r >> shift, c >> shift]):
                continue
            value = _fit(potential, cost, r, c)
            if value < potential[r, c] - _GAIN:
                potential[r, c] = value
                number = max(int(value / _BUCKET_WIDTH), current)
                _push(r, c, width, number, pending, heads, nodes, free)


@njit(cache=True, inline="always")
def _fit(potential: NDArray[np.float32], cost: np.float32, row: int, column: int) -> np.float32:
    """Return a cell's potential from its lower neighbour in each direction."""
    height, width = potential.shape
    down = potential[row - 1, column] if row > 0 else _INF
    up = potential[row + 1, column] if row < height - 1 else _INF
    left = potential[row, column - 1] if column > 0 else _INF
    right = potential[row, column + 1] if column < width - 1 else _INF
    vertical, horizontal = min(down, up), min(left, right)
    low, difference = min(vertical, horizontal), abs(vertical - horizontal)
    value: np.float32 = low + cost
    if difference < cost:
        ratio = difference / cost
        value = low + cost * (_C0 + ratio * (_C1 - _C2 * ratio))
    return value


@njit(cache=True, inline="always")
def _push(
    row: int,
    column: int,
    width: int,
    number: int,
    pending: NDArray[np.uint8],
    heads: NDArray[np.int32],
    nodes: NDArray[np.int32],
    free: NDArray[np.int32],
) -> None:
    """Put a cell into a bucket, unless it is in it; its node in another stays till its turn comes.

    Half of the nodes are kept for cells that are in none: where the others run out, a cell stays
    where it is, which costs time but no truth.
    """
    slot, before, node = number & _RING, pending[row, column], free[0]
    if before == slot + 1 or (before > 0 and node < 0 and free[1] >= nodes.shape[1] // 2):
        return
    pending[row, column] = slot + 1
    if node >= 0:
        free[0] = nodes[1, node]
    else:
        node = free[1]
        free[1] += 1
    nodes[0, node], nodes[1, node] = row * width + column, heads[slot]
    heads[slot] = node


@njit(cache=True, inline="always")
def _pop(
    slot: int, heads: NDArray[np.int32], nodes: NDArray[np.int32], free: NDArray[np.int32]
) -> int:
    """Take the cell put last into a bucket that is not empty, and free its node."""
    node = heads[slot]
    cell, heads[slot] = nodes[0, node], nodes[1, node]
    nodes[1, node], free[0] = free[0], node
    return int(cell)
