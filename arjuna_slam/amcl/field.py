"""The distance field: how far each place of a map is from the nearest obstacle."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

from arjuna_core.grid import OccupancyGrid
from arjuna_core.se2 import SE2


class DistanceField:
    """Distances to the centre of the nearest occupied cell, and poses in the grid's own terms.

    "Grid coordinates" are cells from the outer corner of cell (0, 0), x along columns.

    Args:
        grid: The map.
        max_distance: Where distances are capped, and the distance of places off the map [m].

    Attributes:
        distances: `(height, width) float32` [m].
        occupied: `(height, width) bool`.
        free: `(height, width) bool`.

    Source: Thrun, Burgard, Fox, Probabilistic Robotics, 2005, section 6.4.
    """

    def __init__(self, grid: OccupancyGrid, max_distance: float) -> None:
        self.frame = grid.frame
        self.max_distance = max_distance
        self.occupied: NDArray[np.bool_] = grid.occupied()
        self.free: NDArray[np.bool_] = grid.free()
        cells = distance_transform_edt(~self.occupied)
        self.distances: NDArray[np.float32] = np.minimum(
            cells * grid.frame.resolution, max_distance
        ).astype(np.float32)

    def to_grid(self, poses: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return poses `(N, 3)` of the map frame [m, m, rad] in grid coordinates `(N, 3)`."""
        result = np.empty_like(poses)
        result[:, :2] = self.frame.origin.inverse().apply(poses[:, :2]) / self.frame.resolution
        result[:, 2] = poses[:, 2] - self.frame.origin.theta
        return result

    def to_map(self, pose: NDArray[np.float64]) -> SE2:
        """Return one pose `(3,)` in grid coordinates in the map frame."""
        x, y = pose[:2] * self.frame.resolution
        return self.frame.origin @ SE2(float(x), float(y), float(pose[2]))

    def sample_free(self, count: int, rng: np.random.Generator) -> NDArray[np.float64]:
        """Draw poses `(count, 3)` of the map frame [m, m, rad], uniform over the free cells."""
        cells = np.argwhere(self.free)
        chosen = cells[rng.integers(len(cells), size=count)]
        offsets = rng.random((count, 2))
        points = (chosen[:, ::-1] + offsets) * self.frame.resolution
        headings = rng.uniform(-math.pi, math.pi, count)
        return np.column_stack((self.frame.origin.apply(points), headings))


@njit(cache=True)
def sum_at_endpoints(
    table: NDArray[np.float32],
    outside: float,
    poses: NDArray[np.float64],
    endpoints: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Return for each pose the sum of a table over the cells where the beams end.

    Args:
        table: `(height, width) float32`.
        outside: What an endpoint off the table adds.
        poses: `(N, 3) float64` in grid coordinates [cells, cells, rad].
        endpoints: `(B, 2) float64` in the base frame [cells].

    Returns:
        `(N,) float64`.
    """
    height, width = table.shape
    sums = np.empty(len(poses))
    for i in range(len(poses)):
        x, y = poses[i, 0], poses[i, 1]
        c, s = math.cos(poses[i, 2]), math.sin(poses[i, 2])
        total = 0.0
        for j in range(len(endpoints)):
            column = x + c * endpoints[j, 0] - s * endpoints[j, 1]
            row = y + s * endpoints[j, 0] + c * endpoints[j, 1]
            if 0.0 <= row < height and 0.0 <= column < width:
                # unsigned indices spare the check for Python's negative ones: a quarter of the time
                total += table[np.uint32(row), np.uint32(column)]
            else:
                total += outside
        sums[i] = total
    return sums


@njit(cache=True)
def count_near(
    distances: NDArray[np.float32],
    limit: float,
    poses: NDArray[np.float64],
    endpoints: NDArray[np.float64],
) -> NDArray[np.int64]:
    """Return for each endpoint how many poses put it nearer than `limit` to an obstacle.

    Args:
        distances: `(height, width) float32` [m].
        limit: [m].
        poses: `(N, 3) float64` in grid coordinates.
        endpoints: `(B, 2) float64` in the base frame [cells].

    Returns:
        `(B,) int64`.
    """
    height, width = distances.shape
    counts = np.zeros(len(endpoints), np.int64)
    for i in range(len(poses)):
        c, s = math.cos(poses[i, 2]), math.sin(poses[i, 2])
        for j in range(len(endpoints)):
            column = math.floor(poses[i, 0] + c * endpoints[j, 0] - s * endpoints[j, 1])
            row = math.floor(poses[i, 1] + s * endpoints[j, 0] + c * endpoints[j, 1])
            inside = 0 <= row < height and 0 <= column < width
            if inside and distances[row, column] < limit:
                counts[j] += 1
    return counts
