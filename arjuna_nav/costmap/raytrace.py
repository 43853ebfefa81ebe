"""Inner loops of the obstacle layer: rays that clear, ends that mark, polygons that fill."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from arjuna_core.arrays import Bytes, Floats
from arjuna_core.raycast import line_cells
from arjuna_nav.costmap.costmap import FREE, LETHAL, blended


@njit(cache=True)
def enter_scan(
    data: Bytes,
    hits: NDArray[np.uint32],
    sensor: Floats,
    ranges: Floats,
    bearings: Floats,
    limits: Floats,
    clearing: bool,
    marking: bool,
) -> None:
    """Clear along all beams of a scan, then mark their ends, in place.

    Lengths are in cells, so that a point's cell is its coordinates' floor.

    Args:
        data: `(height, width) uint8`.
        hits: `(height, width) uint32` where in its cell each mark lies; see `hit_points`.
        sensor: `(3,)` x, y, heading of the sensor in the grid.
        ranges: `(N,)`; inf is no return, NaN invalid.
        bearings: `(N,)` in the sensor frame [rad].
        limits: `(7,)` range_min, range_max, raytrace_min, raytrace_max for beams without return
            (negative for none), raytrace_max, obstacle_min, obstacle_max.
        clearing: Whether rays clear.
        marking: Whether ends mark.
    """
    range_min, range_max, trace_min, trace_inf, trace_max, _, _ = limits
    if clearing:
        for i in range(len(ranges)):
            hit = range_min <= ranges[i] < range_max
            if not hit and not ranges[i] >= range_max:
                continue
            length = min(ranges[i], trace_max) if hit else trace_inf
            angle = sensor[2] + bearings[i]
            keep_end = hit and ranges[i] <= trace_max
            _clear_ray(data, sensor, math.cos(angle), math.sin(angle), trace_min, length, keep_end)
    if marking:
        _mark_ends(data, hits, sensor, ranges, bearings, limits)


@njit(cache=True)
def _mark_ends(
    data: Bytes,
    hits: NDArray[np.uint32],
    sensor: Floats,
    ranges: Floats,
    bearings: Floats,
    limits: Floats,
) -> None:
    """Mark the ends of a scan's beams, and where in their cells they lie; see `enter_scan`."""
    range_min, range_max, _, _, _, mark_min, mark_max = limits
    height, width = data.shape
    for i in range(len(ranges)):
        hit = range_min <= ranges[i] < range_max
        if hit and mark_min <= ranges[i] <= mark_max:
            angle = sensor[2] + bearings[i]
            x = sensor[0] + ranges[i] * math.cos(angle)
            y = sensor[1] + ranges[i] * math.sin(angle)
            row, column = math.floor(y), math.floor(x)
            if 0 <= row < height and 0 <= column < width:
                data[row, column] = LETHAL
                hits[row, column] = blended(hits[row, column], x - column, y - row)


@njit(cache=True)
def enter_points(
    data: Bytes, sensor: Floats, points: Floats, limits: Floats, clearing: bool
) -> None:
    """Clear along the rays to points, or mark the points, in place; lengths are in cells.

    Args:
        data: `(height, width) uint8`.
        sensor: `(3,)` where the points were seen from, in the grid.
        points: `(N, 3)` in the grid.
        limits: `(7,)` raytrace_min, raytrace_max, obstacle_min, obstacle_max, the least and
            greatest height that marks, and the unit of heights [cells]. What marks is measured in
            space, what clears in the plane, as Nav2 does.
        clearing: Whether to clear; else the points mark.
    """
    trace_min, trace_max, mark_min, mark_max, low, high, unit = limits
    height, width = data.shape
    ends = np.zeros(data.shape, np.bool_)  # one ray to each cell will do
    for i in range(len(points)):
        x, y, z = points[i]
        row, column = math.floor(y), math.floor(x)
        far = math.hypot(x - sensor[0], y - sensor[1])
        inside = 0 <= row < height and 0 <= column < width
        if not clearing:
            far = math.hypot(far, (z - sensor[2]) * unit)
            if inside and low <= z <= high and mark_min <= far <= mark_max:
                data[row, column] = LETHAL
            continue
        if far == 0.0 or (inside and ends[row, column]):
            continue
        if inside:
            ends[row, column] = True
        c, s = (x - sensor[0]) / far, (y - sensor[1]) / far
        _clear_ray(data, sensor, c, s, trace_min, min(far, trace_max), far <= trace_max)


@njit(cache=True)
def _clear_ray(
    data: Bytes, sensor: Floats, c: float, s: float, start: float, length: float, keep_end: bool
) -> None:
    """Set cells along a ray free; `keep_end` spares the cell of its end."""
    if length <= start:
        return
    height, width = data.shape
    row, column = math.floor(sensor[1] + start * s), math.floor(sensor[0] + start * c)
    row1, column1 = math.floor(sensor[1] + length * s), math.floor(sensor[0] + length * c)
    low, high = min(row, row1), max(row, row1)
    left, right = min(column, column1), max(column, column1)
    if low >= 0 and high < height and left >= 0 and right < width:
        _clear_inside(data, row, column, row1, column1, keep_end)
        return
    for r, c in line_cells(row, column, row1, column1):
        if keep_end and r == row1 and c == column1:
            break
        if 0 <= r < height and 0 <= c < width:
            data[r, c] = FREE


@njit(cache=True)
def _clear_inside(
    data: Bytes, row: int, column: int, row1: int, column1: int, keep_end: bool
) -> None:
    """Set the cells of a line free that lies on the grid, as `line_cells` names them.

    Cell by cell of one flat array, with nothing to look up; `bench costmap` times it.
    """
    width = data.shape[1]
    d_row, d_column = abs(row1 - row), abs(column1 - column)
    flat, cell = data.reshape(-1), np.uint64(row * width + column)
    by_row = np.uint64(width if row1 > row else -width)  # wraps round, as unsigned numbers do
    by_column = np.uint64(1 if column1 > column else -1)
    error = d_column - d_row
    for _ in range(max(d_row, d_column) + (0 if keep_end else 1)):
        flat[cell] = FREE
        double = 2 * error
        if double > -d_row:
            error -= d_row
            cell += by_column
        if double < d_column:
            error += d_column
            cell += by_row


@njit(cache=True)
def fill_polygon(data: NDArray[Any], corners: Floats, value: int) -> None:
    """Set the cells whose centres lie in a polygon, in place.

    Args:
        data: `(height, width)`, of any whole numbers.
        corners: `(N, 2)` x, y in cells.

    Source: even-odd rule, row by row.
    """
    height, width = data.shape
    row0 = max(math.floor(corners[:, 1].min()), 0)
    row1 = min(math.floor(corners[:, 1].max()) + 1, height)
    column0 = max(math.floor(corners[:, 0].min()), 0)
    column1 = min(math.floor(corners[:, 0].max()) + 1, width)
    for row in range(row0, row1):
        for column in range(column0, column1):
            x, y, inside = column + 0.5, row + 0.5, False
            for i in range(len(corners)):
                xa, ya = corners[i, 0], corners[i, 1]
                xb, yb = corners[i - 1, 0], corners[i - 1, 1]
                if (ya > y) != (yb > y) and x < (xb - xa) * (y - ya) / (yb - ya) + xa:
                    inside = not inside
            if inside:
                data[row, column] = value
