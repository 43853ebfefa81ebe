"""Potential of a wave that spreads over traversal costs, and the descent back to its source."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from arjuna_nav.costmap.costmap import INSCRIBED, UNKNOWN

NEUTRAL = 50.0  # COST_NEUTRAL and COST_FACTOR of nav2_navfn_planner
COST_FACTOR = 0.8
_BUCKET_WIDTH = 10.0  # a fifth of the least step: order within a bucket hardly matters
_BUCKETS = 64  # more than the 252 / 10 that the potentials in a wave span
_STEP = 0.5  # of the descent, pathStep of nav2_navfn_planner [cells]
_STEPS_IN_CELL = 6  # twice what crosses a diagonal: more go in a circle


def traversal_costs(data: NDArray[np.uint8], allow_unknown: bool = True) -> NDArray[np.float64]:
    """Return the cost of crossing each cell: `50 + 0.8 c`, inf where the robot's centre may not be.

    Source: nav2_navfn_planner, setCostmap.
    """
    costs = NEUTRAL + COST_FACTOR * data.astype(np.float64)
    costs[data >= INSCRIBED] = np.inf
    costs[data == UNKNOWN] = NEUTRAL + COST_FACTOR * (INSCRIBED - 1) if allow_unknown else np.inf
    return costs


@njit(cache=True)
def spread(
    costs: NDArray[np.float64], source: tuple[int, int], target: tuple[int, int] = (-1, -1)
) -> NDArray[np.float64]:
    """Return the potential of each cell, the cost of reaching it from the source.

    Args:
        costs: `(height, width) float64` traversal costs, inf for blocked.
        source: `(row, column)` of the source.
        target: Cell at which the wave may stop; with -1 it covers all that can be reached.

    Returns:
        `(height, width) float64`, inf where the wave did not come.

    Source: Konolige's NavFn as in nav2_navfn_planner: the quadratic fit of the eikonal equation.
        The queue is a ring of buckets (Dial 1969), each a doubly linked list of cells.
    """
    height, width = costs.shape
    potential = np.full((height, width), np.inf)
    ends = np.full((2, _BUCKETS), -1, np.int32)
    links = np.empty((2, height * width), np.int32)
    bucket_of = np.full(height * width, -1, np.int16)
    potential[source] = 0.0
    _push(source[0] * width + source[1], 0, ends, links, bucket_of)
    current, empty, goal = 0, 0, target[0] >= 0
    while empty < _BUCKETS:
        cell = ends[0, current % _BUCKETS]
        if cell < 0:
            current, empty = current + 1, empty + 1
            if goal and current * _BUCKET_WIDTH > potential[target] + 2.0 * NEUTRAL:
                break
            continue
        empty = 0
        _remove(cell, ends, links, bucket_of)
        row, column = cell // width, cell % width
        for k in range(4):
            r, c = row + (k == 0) - (k == 1), column + (k == 2) - (k == 3)
            if not (0 <= r < height and 0 <= c < width) or costs[r, c] == np.inf:
                continue
            value = _fit(potential, costs[r, c], r, c)
            if value < potential[r, c] - 1e-9:
                potential[r, c] = value
                number = max(int(value / _BUCKET_WIDTH), current)
                _remove(r * width + c, ends, links, bucket_of)
                _push(r * width + c, number % _BUCKETS, ends, links, bucket_of)
    return potential


@njit(cache=True)
def _fit(potential: NDArray[np.float64], cost: float, row: int, column: int) -> float:
    """Return a cell's potential from its lower neighbour in each direction."""
    height, width = potential.shape
    down = potential[row - 1, column] if row > 0 else np.inf
    up = potential[row + 1, column] if row < height - 1 else np.inf
    left = potential[row, column - 1] if column > 0 else np.inf
    right = potential[row, column + 1] if column < width - 1 else np.inf
    vertical, horizontal = min(down, up), min(left, right)
    low, difference = min(vertical, horizontal), abs(vertical - horizontal)
    if not difference < cost:
        return low + cost
    ratio = difference / cost
    value: float = low + cost * (-0.2301 * ratio * ratio + 0.5307 * ratio + 0.7040)
    return value


@njit(cache=True)
def _push(
    cell: int,
    slot: int,
    ends: NDArray[np.int32],
    links: NDArray[np.int32],
    bucket_of: NDArray[np.int16],
) -> None:
    """Append a cell to a bucket: first in, first out, so that corrections stay few."""
    last = ends[1, slot]
    links[0, cell], links[1, cell] = last, -1
    if last >= 0:
        links[1, last] = cell
    else:
        ends[0, slot] = cell
    ends[1, slot] = cell
    bucket_of[cell] = slot


@njit(cache=True)
def _remove(
    cell: int, ends: NDArray[np.int32], links: NDArray[np.int32], bucket_of: NDArray[np.int16]
) -> None:
    """Take a cell out of its bucket, where it is in one."""
    slot = bucket_of[cell]
    if slot < 0:
        return
    before, after = links[0, cell], links[1, cell]
    if before >= 0:
        links[1, before] = after
    else:
        ends[0, slot] = after
    if after >= 0:
        links[0, after] = before
    else:
        ends[1, slot] = before
    bucket_of[cell] = -1


@njit(cache=True)
def descend(
    potential: NDArray[np.float64], start: tuple[int, int], source: tuple[int, int]
) -> NDArray[np.float64]:
    """Follow the potential down from a reached cell to the source.

    Goes half a cell down the gradient at a time; where that is not defined or does not lead lower,
    to the lowest of the eight neighbours, never across a blocked corner.

    Args:
        potential: Of `spread`.
        start: `(row, column)` of a cell the wave reached.
        source: Its source.

    Returns:
        `(N, 2) float64` of `(row, column)`, cells' centres at whole numbers, source last.
    """
    height, width = potential.shape
    limit = (_STEPS_IN_CELL + 1) * height * width
    points = np.empty((limit, 2))
    row, column = start
    r, c = float(row), float(column)
    points[0, 0], points[0, 1] = r, c
    count, here = 1, 0
    while (row, column) != source and count < limit - 1:
        d_r, d_c = _gradient(potential, r, c)
        norm = math.hypot(d_r, d_c)
        here += 1
        stepped = same = False
        if norm > 0.0 and here <= _STEPS_IN_CELL:
            next_r, next_c = r - _STEP * d_r / norm, c - _STEP * d_c / norm
            cell_r, cell_c = math.floor(next_r + 0.5), math.floor(next_c + 0.5)
            same = cell_r == row and cell_c == column
            if same or potential[cell_r, cell_c] < potential[row, column]:
                stepped = True
                r, c = next_r, next_c
        if not stepped:
            cell_r, cell_c = _lowest(potential, row, column)
            r, c = float(cell_r), float(cell_c)
        if not same:
            row, column, here = cell_r, cell_c, 0
        points[count, 0], points[count, 1] = r, c
        count += 1
    points[count, 0], points[count, 1] = source
    path: NDArray[np.float64] = points[: count + 1].copy()
    return path


@njit(cache=True)
def _gradient(potential: NDArray[np.float64], r: float, c: float) -> tuple[float, float]:
    """Return the gradient at a point, bilinear between cells; (0, 0) next to cells not reached."""
    height, width = potential.shape
    row, column = math.floor(r), math.floor(c)
    if not (1 <= row < height - 2 and 1 <= column < width - 2):
        return 0.0, 0.0
    a, b = r - row, c - column
    d_r = d_c = 0.0
    for i in range(2):
        for j in range(2):
            weight = (a if i else 1.0 - a) * (b if j else 1.0 - b)
            y, x = row + i, column + j
            along_r = 0.5 * (potential[y + 1, x] - potential[y - 1, x])
            along_c = 0.5 * (potential[y, x + 1] - potential[y, x - 1])
            if not (math.isfinite(along_r) and math.isfinite(along_c)):
                return 0.0, 0.0
            d_r += weight * along_r
            d_c += weight * along_c
    return d_r, d_c


@njit(cache=True)
def _lowest(potential: NDArray[np.float64], row: int, column: int) -> tuple[int, int]:
    """Return the neighbour with the least potential; diagonal ones count unless a corner blocks."""
    height, width = potential.shape
    best_r, best_c, best = row, column, potential[row, column]
    for r in range(max(row - 1, 0), min(row + 2, height)):
        for c in range(max(column - 1, 0), min(column + 2, width)):
            open_corner = potential[row, c] < np.inf and potential[r, column] < np.inf
            if open_corner and potential[r, c] < best:
                best_r, best_c, best = r, c, potential[r, c]
    return best_r, best_c
