"""Inner loops of the voxel layer: rays that clear voxels, ends that mark them.

Voxels are bits: those above a cell are one number, the lowest voxel its lowest bit.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from arjuna_nav.costmap.costmap import FREE, LETHAL


@njit(cache=True)
def enter_cloud(
    voxels: NDArray[np.uint32],
    data: NDArray[np.uint8],
    sensor: NDArray[np.float64],
    points: NDArray[np.float64],
    limits: NDArray[np.float64],
    levels: int,
    allowed: int,
) -> None:
    """Clear along the rays to all points, then mark the points, in place.

    Places are in voxels, so that a point's voxel is its coordinates' floor.

    Args:
        voxels: `(height, width) uint32`.
        data: `(height, width) uint8` costs of the cells.
        sensor: `(3,)` where the points were seen from.
        points: `(N, 3)`.
        limits: `(8,)` raytrace_min, raytrace_max, obstacle_min, obstacle_max in cells, lowest and
            highest place that marks, whether rays clear and points mark.
        levels: How many voxels are above a cell.
        allowed: How many of them may be marked in a free cell.
    """
    trace_min, trace_max, mark_min, mark_max, low, high, clearing, marking = limits
    height, width = data.shape
    ends = np.zeros(data.shape, np.uint32)  # one ray to each voxel will do
    for i in range(len(points)):
        if not clearing:
            break
        column, row = math.floor(points[i, 0]), math.floor(points[i, 1])
        level = math.floor(points[i, 2])
        if 0 <= row < height and 0 <= column < width and 0 <= level < levels:
            if ends[row, column] >> level & 1:
                continue
            ends[row, column] |= np.uint32(1 << level)
        _clear_ray(voxels, data, sensor, points[i], (trace_min, trace_max), levels, allowed)
    for i in range(len(points)):
        x, y, z = points[i]
        column, row, level = math.floor(x), math.floor(y), math.floor(z)
        inside = 0 <= row < height and 0 <= column < width and 0 <= level < levels
        far = math.hypot(x - sensor[0], y - sensor[1])
        if marking and inside and low <= z <= high and mark_min <= far <= mark_max:
            voxels[row, column] |= np.uint32(1 << level)
            data[row, column] = LETHAL if _count(voxels[row, column]) > allowed else FREE


@njit(cache=True)
def _clear_ray(
    voxels: NDArray[np.uint32],
    data: NDArray[np.uint8],
    start: NDArray[np.float64],
    end: NDArray[np.float64],
    reach: tuple[float, float],
    levels: int,
    allowed: int,
) -> None:
    """Set the voxels along a ray free, up to the one it ends in.

    Source: nav2_voxel_grid's ray tracing, a step for each voxel of the longest axis.
    """
    height, width = data.shape
    x, y, z = start
    dx, dy, dz = end[0] - x, end[1] - y, end[2] - z  # numbers, for an array is made at each step
    count = math.ceil(max(abs(dx), abs(dy), abs(dz)))
    length = math.hypot(dx, dy)
    last = math.floor(end[0]), math.floor(end[1]), math.floor(end[2])
    for k in range(count):
        share = k / count
        if share * length < reach[0] or share * length > reach[1]:
            continue
        column, row = math.floor(x + share * dx), math.floor(y + share * dy)
        level = math.floor(z + share * dz)
        if (column, row, level) == last:
            return
        if 0 <= row < height and 0 <= column < width and 0 <= level < levels:
            voxels[row, column] &= ~np.uint32(1 << level)
            data[row, column] = LETHAL if _count(voxels[row, column]) > allowed else FREE


@njit(cache=True)
def _count(bits: int) -> int:
    """Return how many bits are set (Kernighan)."""
    count = 0
    while bits:
        bits &= bits - 1
        count += 1
    return count
