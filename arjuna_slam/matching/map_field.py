"""The map as a reference: how far each of its places is from the nearest obstacle."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

from arjuna_core.grid import OccupancyGrid
from arjuna_core.se2 import SE2
from arjuna_slam.matching.refinement import refine

_NOWHERE = np.zeros(2)  # the distances begin at the grid's own origin


class MapField:
    """Distances to the centre of the nearest occupied cell, and poses in the grid's own terms.

    "Grid coordinates" are cells from the outer corner of cell (0, 0), x along columns.

    Args:
        grid: The map.
        max_distance: Where distances are capped, and the distance of places off the map [m].

    Attributes:
        distances: `(height, width) float32` [m].
        occupied: `(height, width) bool`.
        free: `(height, width) bool`.
        unknown: `(height, width) bool`.

    Source: Thrun, Burgard, Fox, Probabilistic Robotics, 2005, section 6.4.
    """

    def __init__(self, grid: OccupancyGrid, max_distance: float) -> None:
        self.frame = grid.frame
        self.max_distance = max_distance
        self.occupied: NDArray[np.bool_] = grid.occupied()
        self.free: NDArray[np.bool_] = grid.free()
        self.unknown: NDArray[np.bool_] = grid.unknown()
        self._T_grid_map = grid.frame.origin.inverse()
        cells = distance_transform_edt(~self.occupied)
        self.distances: NDArray[np.float32] = np.minimum(
            cells * grid.frame.resolution, max_distance
        ).astype(np.float32)

    def to_grid(self, poses: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return poses `(N, 3)` of the map frame [m, m, rad] in grid coordinates `(N, 3)`."""
        origin, resolution = self._T_grid_map, self.frame.resolution
        c, s = math.cos(origin.theta) / resolution, math.sin(origin.theta) / resolution
        result = np.empty(poses.shape, order="F")
        x, y = poses[:, 0], poses[:, 1]
        result[:, 0] = c * x - s * y + origin.x / resolution
        result[:, 1] = s * x + c * y + origin.y / resolution
        result[:, 2] = poses[:, 2] + origin.theta
        return result

    def refine(
        self,
        pose: SE2,
        points: NDArray[np.float64],
        information: NDArray[np.float64],
        scales: NDArray[np.float64],
        deviation: float,
    ) -> SE2:
        """Return the pose at which points lie nearest to obstacles, near a given one.

        Args:
            pose: In the map frame; it is the prior, so that it stays where the scan says nothing.
            points: `(N, 2) float64` in the base frame [m].
            information: Of the prior, axes of the grid, `(3, 3) float64`.
            scales: Of the robust weight in each step, `(K,) float64` [m].
            deviation: Of a point from the map [m].
        """
        start = (self._T_grid_map @ pose).array()
        found = refine(
            (self.distances, None, self.frame.resolution, _NOWHERE), points, None,
            start, start, information, scales, deviation,
        )[0]  # fmt: skip
        return self.frame.origin @ SE2.from_array(found)

    def sample_free(
        self, count: int, rng: np.random.Generator, step: int = 1
    ) -> NDArray[np.float64]:
        """Draw poses `(count, 3)` of the map frame [m, m, rad], uniform over the free cells.

        Args:
            count: How many.
            rng: Source of randomness.
            step: Only each `step`-th row and column is drawn from, unless none there is free.
        """
        cells = np.argwhere(self.free[::step, ::step]) * step
        if not len(cells):
            cells = np.argwhere(self.free)
        chosen = cells[rng.integers(len(cells), size=count)]
        offsets = rng.random((count, 2))
        points = (chosen[:, ::-1] + offsets) * self.frame.resolution
        headings = rng.uniform(-math.pi, math.pi, count)
        return np.column_stack((self.frame.origin.apply(points), headings))
