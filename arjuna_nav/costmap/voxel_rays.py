"""Inner loops of the voxel layer: rays that clear voxels, ends that mark them.

Voxels are bits: those above a cell are one number, the lowest voxel its lowest bit.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from arjuna_nav.costmap.costmap import FREE, LETHAL, UNKNOWN, blended


@njit(cache=True)
def clear_cloud(
    voxels: NDArray[np.uint32],
    known: NDArray[np.uint32],
    data: NDArray[np.uint8],
    sensor: NDArray[np.float64],
    points: NDArray[np.float64],
    limits: NDArray[np.float64],
    column: tuple[int, int, int],
) -> None:
    """Clear along the rays to all points, in place.

    Coordinates are in voxels: the floor of a point's coordinates is its voxel.

    Args:
        voxels: `(height, width) uint32` which are marked.
        known: Likewise which were ever seen.
        data: `(height, width) uint8` costs of the cells.
        sensor: `(3,)` where the points were seen from.
        points: `(N, 3)`.
        limits: As `enter_points` has them, in voxels.
        column: How many voxels are above a cell, how many of them may be marked in a free cell,
            and how many unknown.
    """
    height, width = data.shape
    levels = column[0]
    ends = np.zeros(data.shape, np.uint32)  # one ray to each voxel will do
    for i in range(len(points)):
        x, y, z = math.floor(points[i, 0]), math.floor(points[i, 1]), math.floor(points[i, 2])
        if 0 <= y < height and 0 <= x < width and 0 <= z < levels:
            if ends[y, x] >> z & 1:
                continue
            ends[y, x] |= np.uint32(1 << z)
        _clear_ray(voxels, known, data, sensor, points[i], (limits[0], limits[1]), column)


@njit(cache=True)
def mark_cloud(
    voxels: NDArray[np.uint32],
    known: NDArray[np.uint32],
    data: NDArray[np.uint8],
    hits: NDArray[np.uint32],
    sensor: NDArray[np.float64],
    points: NDArray[np.float64],
    limits: NDArray[np.float64],
    column: tuple[int, int, int],
    precise: bool,
) -> None:
    """Mark the voxels that points are in, in place; points below the lowest voxel mark that.

    Args as `clear_cloud`, and:
        hits: `(height, width) uint32` where in its cell each mark lies; see `hit_points`.
        precise: Whether the points say where in their cells things lie.
    """
    _, _, mark_min, mark_max, low, high, unit = limits
    height, width = data.shape
    levels, allowed, _ = column
    for i in range(len(points)):
        px, py, pz = points[i]
        x, y, z = math.floor(px), math.floor(py), max(math.floor(pz), 0)
        inside = 0 <= y < height and 0 <= x < width and z < levels
        far = math.hypot(px - sensor[0], py - sensor[1])
        far = math.hypot(far, (pz - sensor[2]) * unit)
        if inside and low <= pz <= high and mark_min <= far <= mark_max:
            voxels[y, x] |= np.uint32(1 << z)
            known[y, x] |= np.uint32(1 << z)
            if _count(voxels[y, x]) > allowed:
                data[y, x] = LETHAL
                if precise:
                    hits[y, x] = blended(hits[y, x], px - x, py - y)


@njit(cache=True)
def _clear_ray(
    voxels: NDArray[np.uint32],
    known: NDArray[np.uint32],
    data: NDArray[np.uint8],
    start: NDArray[np.float64],
    end: NDArray[np.float64],
    reach: tuple[float, float],
    above: tuple[int, int, int],
) -> None:
    """Set the voxels along a ray free, up to the one it ends in.

    Source: nav2_voxel_grid's ray tracing, a step for each voxel of the longest axis.
    """
    height, width = data.shape
    levels, allowed, unknown = above
    x, y, z = start
    dx, dy, dz = end[0] - x, end[1] - y, end[2] - z  # numbers, for an array is made at each step
    count = math.ceil(max(abs(dx), abs(dy), abs(dz)))
    length = math.hypot(dx, dy)
    last = math.floor(end[0]), math.floor(end[1]), math.floor(end[2])
    entered = False
    for k in range(count):
        share = k / count
        if share * length < reach[0]:
            continue
        if share * length > reach[1]:
            return
        column, row = math.floor(x + share * dx), math.floor(y + share * dy)
        level = math.floor(z + share * dz)
        if (column, row, level) == last:
            return
        if not (0 <= row < height and 0 <= column < width and 0 <= level < levels):
            if entered:  # a ray that has left the grid does not come back
                return
        else:
            entered = True
            voxels[row, column] &= ~np.uint32(1 << level)
            known[row, column] |= np.uint32(1 << level)
            if _count(voxels[row, column]) > allowed:
                data[row, column] = LETHAL
            elif unknown < levels and levels - _count(known[row, column]) > unknown:
                data[row, column] = UNKNOWN
            else:
                data[row, column] = FREE


@njit(cache=True)
def _count(bits: int) -> int:
    """Return how many bits are set (Kernighan)."""
    count = 0
    while bits:
        bits &= bits - 1
        count += 1
    return count
