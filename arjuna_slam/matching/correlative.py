"""Correlative search: the best pose of a scan in a window, exact to a cell and an angle step.

Sources: Olson, Real-time correlative scan matching, 2009 (multi-resolution bounds); Hess et al.,
Real-time loop closure in 2D LIDAR SLAM, 2016, section V (branch and bound); penalties as Karto.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from arjuna_core.se2 import SE2
from arjuna_slam.matching.field import Field

_ANGLE_STEP_MIN = math.radians(0.25)
# A field's score, and its pyramid with its levels
Tables = tuple[NDArray[np.uint8], NDArray[np.uint8], NDArray[np.int64]]
_RUN = 16  # points between two looks at whether a block can still win


@dataclass(frozen=True)
class Window:
    """Where to search and how much to trust the prior.

    Attributes:
        xy: Half the width of the window [m].
        theta: Half its angle [rad].
        depth: Levels of the pyramid.
        distance_penalty: Variance of the penalty on distance [m^2]; inf for none.
        angle_penalty: Variance of the penalty on angle [rad^2]; inf for none.
        floor_xy: Least the distance penalty may become.
        floor_theta: Least the angle penalty may become.
    """

    xy: float
    theta: float
    depth: int
    distance_penalty: float = math.inf
    angle_penalty: float = math.inf
    floor_xy: float = 0.5
    floor_theta: float = 0.9


def search(
    field: Field,
    points: NDArray[np.float64],
    prior: SE2,
    window: Window,
    least: float,
    apart: tuple[Sequence[SE2], float] | None = None,
) -> tuple[SE2, float] | None:
    """Return the pose of the greatest response and the response.

    Args:
        field: The reference.
        points: `(N, 2) float64` in the robot's base frame [m].
        prior: Centre of the window, robot in field.
        window: Its size.
        least: Response (0..1, the mean likelihood times the penalties) a pose must exceed.
        apart: Poses, and how far in x or y from each another must be at least [m]; any such is
            returned then, since it is asked whether there is one.

    Returns:
        The pose and its response, or None where no pose of the window exceeds `least`.
    """
    if len(points) == 0 or field.score.size == 0:
        return None
    thetas = prior.theta + _turns(points, field.resolution, window.theta)
    tables = field.score, *field.pyramid(window.depth)
    xy = (np.array([prior.x, prior.y]) - field.origin) / field.resolution
    half_cells = math.ceil(window.xy / field.resolution)
    penalty = np.array(
        [
            0.2 * field.resolution**2 / window.distance_penalty,
            0.2 / window.angle_penalty,
            window.floor_xy,
            window.floor_theta,
        ]
    )
    without = _left_out(apart, prior, field.resolution)
    k, row, column, response = _branch_and_bound(
        tables, points / field.resolution, xy, thetas, half_cells, penalty,
        without, least,
    )  # fmt: skip
    if k < 0:
        return None
    x = prior.x + column * field.resolution
    return SE2(x, prior.y + row * field.resolution, float(thetas[k])), response


def _turns(points: NDArray[np.float64], resolution: float, theta: float) -> NDArray[np.float64]:
    """Return turns up to theta in steps that move nine points of ten by a cell at most [rad]."""
    far = int(0.9 * (len(points) - 1))
    reach = float(np.partition(np.hypot(points[:, 0], points[:, 1]), far)[far])
    step = max(resolution / max(reach, resolution), _ANGLE_STEP_MIN)
    half_steps = math.ceil(theta / step)
    return step * np.arange(-half_steps, half_steps + 1, dtype=np.float64)


def _left_out(
    apart: tuple[Sequence[SE2], float] | None, prior: SE2, resolution: float
) -> NDArray[np.int64]:
    """Return first and last row and column of boxes of offsets left out, `(K, 4) int64`."""
    poses, far = apart or ((), 0.0)
    gaps = np.array([(pose.y - prior.y, pose.x - prior.x) for pose in poses]).reshape(-1, 2)
    boxes = np.round(gaps.repeat(2, axis=1) / resolution)
    boxes += round(far / resolution) * np.array([-1, 1, -1, 1])
    cells: NDArray[np.int64] = boxes.astype(np.int64)
    return cells


@njit(cache=True)
def _bound(
    tables: Tables,
    h: int,
    cells: NDArray[np.int32],
    row: int,
    column: int,
    least: float,
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
def _penalty(row: int, column: int, size: int, turn: float, p: NDArray[np.float64]) -> float:
    """Greatest penalty factor in a block of offsets `size` cells wide."""
    dr = 0 if row <= 0 <= row + size - 1 else min(abs(row), abs(row + size - 1))
    dc = 0 if column <= 0 <= column + size - 1 else min(abs(column), abs(column + size - 1))
    distance = max(1.0 - p[0] * (dr * dr + dc * dc), p[2])
    return float(distance * max(1.0 - p[1] * turn * turn, p[3]))


@njit(cache=True)
def _excluded(row: int, column: int, size: int, without: NDArray[np.int64]) -> bool:
    """Tell whether a whole block of offsets lies in a box of offsets left out, its rim in it."""
    for box in without:
        inside = row >= box[0] and row + size - 1 <= box[1]
        if inside and column >= box[2] and column + size - 1 <= box[3]:
            return True
    return False


@njit(cache=True)
def _offsets(
    points: NDArray[np.float64], xy: NDArray[np.float64], thetas: NDArray[np.float64]
) -> NDArray[np.int32]:
    """Return the cell (row, column) of each point at each angle, `(T, N, 2) int32`."""
    cells = np.empty((len(thetas), len(points), 2), np.int32)
    for k in range(len(thetas)):
        c, s = math.cos(thetas[k]), math.sin(thetas[k])
        for i in range(len(points)):
            cells[k, i, 0] = math.floor(xy[1] + s * points[i, 0] + c * points[i, 1])
            cells[k, i, 1] = math.floor(xy[0] + c * points[i, 0] - s * points[i, 1])
    return cells


@njit(cache=True)
def _descend(
    tables: Tables,
    cells: NDArray[np.int32],
    top_block: tuple[int, int, int],
    bound: float,
    turn: float,
    penalty: NDArray[np.float64],
    without: NDArray[np.int64],
    best: float,
) -> tuple[bool, int, int, float]:
    """Search one block of offsets (row, column, level), depth first, the most promising first."""
    found, best_row, best_column = False, 0, 0
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
            factor = _penalty(r, c, child, turn, penalty)
            value = factor * _bound(tables, h - 1, cells, r, c, best / max(factor, 1e-9))
            if value <= best:
                continue
            place = top
            while place > first and bounds[place - 1] > value:
                stack[place] = stack[place - 1]
                bounds[place] = bounds[place - 1]
                place -= 1
            stack[place] = (r, c, h - 1)
            bounds[place] = value
            top += 1
    return found, best_row, best_column, best


@njit(cache=True)
def _root(t: int, blocks: int, size: int, half: int) -> tuple[int, int, int]:
    """Return angle, row and column of a coarsest block."""
    k, b = t // (blocks * blocks), t % (blocks * blocks)
    return k, -half + (b // blocks) * size, -half + (b % blocks) * size


@njit(cache=True)
def _roots(
    tables: Tables,
    cells: NDArray[np.int32],
    turns: NDArray[np.float64],
    half: int,
    penalty: NDArray[np.float64],
    least: float,
) -> NDArray[np.float64]:
    """Return the bounds of the coarsest blocks, row by row at each angle."""
    depth = len(tables[2]) - 1
    size = 1 << depth
    blocks = (2 * half) // size + 1
    tops = np.empty(len(turns) * blocks * blocks)
    for t in range(len(tops)):
        k, row, column = _root(t, blocks, size, half)
        factor = _penalty(row, column, size, turns[k], penalty)
        tops[t] = factor * _bound(tables, depth, cells[k], row, column, least / max(factor, 1e-9))
    return tops


@njit(cache=True)
def _branch_and_bound(
    tables: Tables,
    points: NDArray[np.float64],
    xy: NDArray[np.float64],
    thetas: NDArray[np.float64],
    half: int,
    penalty: NDArray[np.float64],
    without: NDArray[np.int64],
    least: float,
) -> tuple[int, int, int, float]:
    """Return angle index (-1 for none), row, column and response of the best offset.

    Where offsets are left out, the first block with a good one outside is enough.
    """
    depth = len(tables[2]) - 1
    size = 1 << depth
    blocks = (2 * half) // size + 1
    cells = _offsets(points, xy, thetas)
    turns = thetas - thetas[len(thetas) // 2]
    tops = _roots(tables, cells, turns, half, penalty, least)
    best_k, best_row, best_column, best = -1, 0, 0, least
    for t in np.argsort(-tops):
        if tops[t] <= best:
            break
        k, row, column = _root(t, blocks, size, half)
        found, row, column, response = _descend(
            tables, cells[k], (row, column, depth), tops[t], turns[k], penalty,
            without, best,
        )  # fmt: skip
        if found:
            best_k, best_row, best_column, best = k, row, column, response
    return best_k, best_row, best_column, best
