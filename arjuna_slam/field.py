"""The reference of scan matching: a smooth likelihood field and the surface under it.

Each cell holds the likelihood of a point there (the greatest of a Gaussian around every reference
point) for the correlative search, and the sums of an implicit moving-least-squares surface for the
continuous refinement: the signed distance from x to it is sum w n (x - p) / sum w over the points p
with normals n. Sums average the noise of all scans and let scans be added one by one.

Sources: Olson, Real-time correlative scan matching, 2009, section III; Kolluri, Provably good
moving least squares, 2005; Deschaud, IMLS-SLAM, 2018, section III.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

_MARGIN_CELLS = 40


class Field:
    """A likelihood field that grows.

    Args:
        resolution: Edge of a cell [m].
        sigma: Deviation of the Gaussian around each reference point [m].
    """

    def __init__(self, resolution: float, sigma: float) -> None:
        self.resolution = resolution
        self.sigma = sigma
        self.origin = np.zeros(2)
        self.score = np.zeros((0, 0), np.uint8)
        self.planes = np.zeros((0, 0, 4), np.float32)
        self._radius = math.ceil(3.0 * sigma / resolution)
        self._pyramid: tuple[NDArray[np.uint8], NDArray[np.int64]] | None = None

    def add(self, points: NDArray[np.float64], normals: NDArray[np.float64]) -> None:
        """Add reference points.

        Args:
            points: `(N, 2) float64` in the field's frame [m].
            normals: `(N, 2) float64` unit normals, zero where there is none.
        """
        if len(points) == 0:
            return
        self._cover(points.min(axis=0), points.max(axis=0))
        _stamp(
            self.score, self.planes, self.resolution, self.origin,
            points, normals, self.sigma, self._radius,
        )  # fmt: skip
        self._pyramid = None

    def pyramid(self, depth: int) -> tuple[NDArray[np.uint8], NDArray[np.int64]]:
        """Return upper bounds of the score over growing blocks, for branch and bound.

        Level h, cell X bounds the scores of rows `2^h (X - 1)` to `2^h (X + 1) - 1`, columns alike,
        so it holds for every offset within 2^h cells. Level 0 is the score itself.

        Args:
            depth: Highest level.

        Returns:
            All levels as `(K,) uint8`, and `(depth + 1, 3) int64` of start, rows and columns.
        """
        if self._pyramid is None or len(self._pyramid[1]) != depth + 1:
            self._pyramid = _build_pyramid(self.score, depth)
        return self._pyramid

    def trim(self) -> None:
        """Give back the memory around what was added."""
        rows, columns = (
            np.flatnonzero(self.score.any(axis=1)),
            np.flatnonzero(self.score.any(axis=0)),
        )
        if len(rows) == 0:
            return
        along, across = slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)
        self.score = self.score[along, across].copy()
        self.planes = self.planes[along, across].copy()
        self.origin = self.origin + self.resolution * np.array([columns[0], rows[0]])
        self._pyramid = None

    def _cover(self, low: NDArray[np.float64], high: NDArray[np.float64]) -> None:
        """Grow so that the box and the kernel around it lie inside."""
        border = self._radius + 2
        shape = np.array(self.score.shape[::-1])
        if shape[0] == 0:
            self.origin = np.floor(low / self.resolution) * self.resolution
        first = np.floor((low - self.origin) / self.resolution).astype(int) - border
        last = np.floor((high - self.origin) / self.resolution).astype(int) + border + 1
        if shape[0] and (first >= 0).all() and (last <= shape).all():
            return
        before = np.where(first < 0, -first + _MARGIN_CELLS, 0)
        after = np.where(last > shape, last - shape + _MARGIN_CELLS, 0)
        pad = ((before[1], after[1]), (before[0], after[0]))
        self.score = np.pad(self.score, pad)
        self.planes = np.pad(self.planes, (*pad, (0, 0)))
        self.origin = self.origin - before * self.resolution


@njit(cache=True)
def _stamp(
    score: NDArray[np.uint8],
    planes: NDArray[np.float32],
    resolution: float,
    origin: NDArray[np.float64],
    points: NDArray[np.float64],
    normals: NDArray[np.float64],
    sigma: float,
    radius: int,
) -> None:
    scale = 0.5 / (sigma * sigma)
    wx, wy = np.empty(2 * radius + 1), np.empty(2 * radius + 1)
    for i in range(len(points)):
        gx = (points[i, 0] - origin[0]) / resolution
        gy = (points[i, 1] - origin[1]) / resolution
        column, row = int(gx), int(gy)
        for k in range(2 * radius + 1):
            dx = (gx - (column - radius + k) - 0.5) * resolution
            dy = (gy - (row - radius + k) - 0.5) * resolution
            wx[k] = math.exp(-scale * dx * dx)
            wy[k] = math.exp(-scale * dy * dy)
        nx, ny = normals[i, 0], normals[i, 1]
        flat = nx != 0.0 or ny != 0.0
        for a in range(2 * radius + 1):
            dy = (gy - (row - radius + a) - 0.5) * resolution
            for b in range(2 * radius + 1):
                w = wx[b] * wy[a]
                r, c = row - radius + a, column - radius + b
                level = int(255.0 * w + 0.5)
                if level > score[r, c]:
                    score[r, c] = level
                if flat and level > 1:
                    dx = (gx - c - 0.5) * resolution
                    planes[r, c, 0] += w
                    planes[r, c, 1] += w * nx
                    planes[r, c, 2] += w * ny
                    planes[r, c, 3] += w * (nx * dx + ny * dy)


@njit(cache=True)
def _build_pyramid(
    score: NDArray[np.uint8], depth: int
) -> tuple[NDArray[np.uint8], NDArray[np.int64]]:
    levels = np.empty((depth + 1, 3), np.int64)
    total = 0
    rows, columns = score.shape
    for h in range(depth + 1):
        levels[h] = (total, rows + 1, columns + 1)
        total += (rows + 1) * (columns + 1)
        rows, columns = (rows + 1) // 2, (columns + 1) // 2
    pyramid = np.zeros(total, np.uint8)
    block = score
    for h in range(depth + 1):
        start, _, width = levels[h]
        rows, columns = block.shape
        for r in range(rows):
            for c in range(columns):
                v = block[r, c]
                here = start + (r + 1) * width + c + 1
                pyramid[here] = max(pyramid[here], v)
                if h > 0:  # each block also counts for the one before it
                    pyramid[here - 1] = max(pyramid[here - 1], v)
                    pyramid[here - width] = max(pyramid[here - width], v)
                    pyramid[here - width - 1] = max(pyramid[here - width - 1], v)
        half = np.zeros(((rows + 1) // 2, (columns + 1) // 2), np.uint8)
        for r in range(rows):
            for c in range(columns):
                half[r // 2, c // 2] = max(half[r // 2, c // 2], block[r, c])
        block = half
    return pyramid, levels
