"""Branch and bound over a grid of offsets at several angles: the kernels of the correlative search.

Source: Hess et al., Real-time loop closure in 2D LIDAR SLAM, 2016, section V.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from arjuna_core.arrays import Bytes, Floats, Ints

# A field's score, and its pyramid with its levels
Tables = tuple[Bytes, Bytes, Ints]
# Cells of the points at each angle, the angles' turns, bounds of the coarsest blocks, their order
Task = tuple[NDArray[np.int32], Floats, Floats, Ints]
# Angle index (-1 for none), row, column and response
Best = tuple[int, int, int, float]
_RUN = 16  # points between two looks at whether a block can still win


@njit(cache=True)
def prepare(
    tables: Tables,
    points: Floats,
    xy: Floats,
    thetas: Floats,
    half: int,
    penalty: Floats,
    least: float,
) -> Task:
    """Return the coarsest blocks of offsets at all angles; all lengths are in cells.

    `xy` is the middle of the window from the field's origin, `penalty` the factors on the squares
    of distance and turn and the least of both, `least` the response that counts.
    """
    cells = np.empty((len(thetas), len(points), 2), np.int32)
    for k in range(len(thetas)):
        c, s = math.cos(thetas[k]), math.sin(thetas[k])
        for i in range(len(points)):
            cells[k, i, 0] = math.floor(xy[1] + s * points[i, 0] + c * points[i, 1])
            cells[k, i, 1] = math.floor(xy[0] + c * points[i, 0] - s * points[i, 1])
    turns, depth = thetas - thetas[len(thetas) // 2], len(tables[2]) - 1
    size = 1 << depth
    blocks = (2 * half) // size + 1
    tops = np.empty(len(turns) * blocks * blocks)
    for t in range(len(tops)):
        k, row, column = _root(t, blocks, size, half)
        factor = _penalty(row, column, size, turns[k], penalty)
        tops[t] = factor * _bound(tables, depth, cells[k], row, column, least / max(factor, 1e-9))
    return cells, turns, tops, np.argsort(-tops)


@njit(cache=True)
def descend(
    tables: Tables,
    task: Task,
    half: int,
    penalty: Floats,
    without: Ints,
    best: Best,
    first: int,
    work: int,
) -> tuple[int, Best]:
    """Search coarsest blocks, the most promising first, until `work` blocks were looked at.

    Boxes of offsets (first and last row and column, `(K, 4)`) may be left out: then any block's
    good one outside counts as found there. `first` of the coarsest blocks are done.

    Returns:
        How many of the coarsest blocks are done now, and the best so far.
    """
    cells, turns, tops, order = task
    depth = len(tables[2]) - 1
    size = 1 << depth
    blocks = (2 * half) // size + 1
    for done in range(first, len(order)):
        t = order[done]
        if tops[t] <= best[3]:
            return len(order), best
        if work <= 0:
            return done, best
        k, row, column = _root(t, blocks, size, half)
        found, row, column, response, looked = _search_block(
            tables, cells[k], (row, column, depth), tops[t], turns[k], penalty, without, best[3]
        )
        if found:
            best = (k, row, column, response)
        work -= looked
    return len(order), best


@njit(cache=True)
def _bound(
    tables: Tables, h: int, cells: NDArray[np.int32], row: int, column: int, least: float
) -> float:
    """Mean upper bound (0..1) over the points for the block of offsets at (row, column).

    Points are no longer looked at once the bound cannot exceed `least`.
    """
    score, pyramid, levels = tables
    start, height, width = levels[h]
    total, most = 0, 255 * len(cells)
    needed = least * most
    for first in range(0, len(cells), _RUN):
        last = min(first + _RUN, len(cells))
        most -= 255 * (last - first)
        if h == 0:
            for i in range(first, last):
                r, c = cells[i, 0] + row, cells[i, 1] + column
                if r >= 0 and r < height and c >= 0 and c < width:
                    total += score[r, c]
        else:
            for i in range(first, last):
                r = ((cells[i, 0] + row) >> h) + 1
                c = ((cells[i, 1] + column) >> h) + 1
                if r >= 0 and r < height and c >= 0 and c < width:
                    total += pyramid[start + r * width + c]
        if total + most <= needed:
            break
    return float(total + most) / (255.0 * len(cells))


@njit(cache=True)
def _penalty(row: int, column: int, size: int, turn: float, p: Floats) -> float:
    """Greatest penalty factor in a block of offsets `size` cells wide."""
    dr = 0 if row <= 0 <= row + size - 1 else min(abs(row), abs(row + size - 1))
    dc = 0 if column <= 0 <= column + size - 1 else min(abs(column), abs(column + size - 1))
    distance = max(1.0 - p[0] * (dr * dr + dc * dc), p[2])
    return float(distance * max(1.0 - p[1] * turn * turn, p[3]))


@njit(cache=True)
def _excluded(row: int, column: int, size: int, without: Ints) -> bool:
    """Return whether a whole block of offsets lies in a box of offsets left out, its rim in it."""
    for box in without:
        inside = row >= box[0] and row + size - 1 <= box[1]
        if inside and column >= box[2] and column + size - 1 <= box[3]:
            return True
    return False


@njit(cache=True)
def _search_block(
    tables: Tables,
    cells: NDArray[np.int32],
    top_block: tuple[int, int, int],
    bound: float,
    turn: float,
    penalty: Floats,
    without: Ints,
    best: float,
) -> tuple[bool, int, int, float, int]:
    """Search one block of offsets (row, column, level), depth first, the most promising first.

    Returns:
        Whether there is a better one, its row, column and response; blocks looked at.
    """
    found, best_row, best_column, looked = False, 0, 0, 0
    depth = top_block[2]
    stack = np.empty((4 * depth + 4, 3), np.int64)
    bounds = np.empty(4 * depth + 4)
    stack[0] = top_block
    bounds[0] = bound
    top = 1
    while top > 0:
        top -= 1
        if bounds[top] <= best:
            continue
        row, column, h = stack[top]
        if h == 0:
            found, best_row, best_column, best = True, row, column, bounds[top]
            continue
        child, first = 1 << (h - 1), top
        for q in range(4):
            r, c = row + (q // 2) * child, column + (q % 2) * child
            if _excluded(r, c, child, without):
                continue
            looked += 1
            factor = _penalty(r, c, child, turn, penalty)
            value = factor * _bound(tables, h - 1, cells, r, c, best / max(factor, 1e-9))
            if value <= best:
                continue
            slot = _make_room(stack, bounds, first, top, value)
            stack[slot] = (r, c, h - 1)
            bounds[slot] = value
            top += 1
    return found, best_row, best_column, best, looked


@njit(cache=True)
def _make_room(stack: Ints, bounds: Floats, first: int, top: int, value: float) -> int:
    """Return where a bound belongs among those from `first` to `top`; greater ones move up."""
    slot = top
    while slot > first and bounds[slot - 1] > value:
        stack[slot] = stack[slot - 1]
        bounds[slot] = bounds[slot - 1]
        slot -= 1
    return slot


@njit(cache=True)
def _root(t: int, blocks: int, size: int, half: int) -> tuple[int, int, int]:
    k, b = t // (blocks * blocks), t % (blocks * blocks)
    return k, -half + (b // blocks) * size, -half + (b % blocks) * size
