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
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from arjuna_core.arrays import Bytes, Floats, Ints, Singles

_CROSSED_MIN, _AGREED_MIN = 0.5, 0.7  # weight and share of it in one direction, to be a surface
_LEVEL_MIN = 2  # of 255: likelihood from which a point counts in a cell


class Field:
    """A likelihood field that grows.

    Args:
        resolution: Edge of a cell [m].
        sigma: Deviation of the Gaussian around each reference point [m].

    Attributes:
        origin: Outer corner of cell (0, 0), `(2,) float64` [m].
        score: Likelihood of each cell, `(H, W) uint8`.
        index: Row of each cell in `planes`, 0 where there is no surface: `(H, W) uint16`, and int32
            once there are more rows than that counts.
        planes: Sums of the surface: w, w nx, w ny, w n (p - centre), `(K, 4) float32`.
    """

    def __init__(self, resolution: float, sigma: float) -> None:
        self.resolution = resolution
        self.sigma = sigma
        self.origin = np.zeros(2)
        self.score = np.zeros((0, 0), np.uint8)
        self.index: NDArray[np.uint16 | np.int32] = np.zeros((0, 0), np.uint16)
        self.planes = np.zeros((1, 4), np.float32)
        self._count = 1
        self._radius = math.ceil(3.0 * sigma / resolution)
        self._pyramid: tuple[Bytes, Ints] | None = None

    def add(self, points: Floats, normals: Floats) -> None:
        """Add reference points [m] with unit normals, zero where there is none, each `(N, 2)`."""
        if len(points) == 0:
            return
        self._cover(points.min(axis=0), points.max(axis=0))
        done = 0
        spare = 4096  # planes, so that the array seldom grows
        small_max = 1 << 16  # planes that 16 bits count
        while done < len(points):
            self._count, done = _stamp(
                self.score, self.index, self.planes, self._count, self.resolution, self.origin,
                points, normals, done, self.sigma, self._radius,
            )  # fmt: skip
            if done < len(points):
                more = np.zeros((len(self.planes) + spare, 4), np.float32)
                self.planes = np.concatenate((self.planes, more))
                if len(self.planes) > small_max and self.index.dtype != np.int32:
                    self.index = self.index.astype(np.int32)
        self._pyramid = None

    def pyramid(self, depth: int) -> tuple[Bytes, Ints]:
        """Return upper bounds of the score over growing blocks, for branch and bound.

        Level h, cell X bounds the scores of rows `2^h (X - 1)` to `2^h (X + 1) - 1`, columns alike,
        so it holds for every offset within 2^h cells.

        Returns:
            Levels 1 to `depth`, `(K,) uint8`; start, rows, columns of each, `(depth + 1, 3) int64`.
        """
        if self._pyramid is None or len(self._pyramid[1]) != depth + 1:
            self._pyramid = _build_pyramid(self.score, depth)
        return self._pyramid

    def halved(self) -> Field:
        """Return a field of cells twice as wide that bounds this one's scores; without surface."""
        coarse = Field(2.0 * self.resolution, self.sigma)
        coarse.origin, coarse.score = self.origin, _halve(self.score)
        return coarse

    def likelihood(self, points: Floats) -> Floats:
        """Return the likelihood (0..1) at points `(N, 2)` of the field's frame [m], 0 outside."""
        return self.at(points, self.score) / 255.0

    def at(self, points: Floats, table: NDArray[Any]) -> NDArray[Any]:
        """Return the values of a table of the field's cells at points [m], 0 outside."""
        cells = np.floor((points - self.origin) / self.resolution).astype(np.int64)
        inside = ((cells >= 0) & (cells < table.shape[::-1])).all(axis=1)
        result = np.zeros(len(points), table.dtype)
        result[inside] = table[cells[inside, 1], cells[inside, 0]]
        return result

    def surface(self) -> tuple[Floats, Floats]:
        """Return points on the surface, one a cell that it crosses [m], and their unit normals.

        Both `(N, 2) float64` in the field's frame.
        """
        return _crossings(self.index, self.planes, self.resolution, self.origin)

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
        self.index = self.index[along, across].copy()
        self.planes = self.planes[: self._count].copy()
        self.origin = self.origin + self.resolution * np.array([columns[0], rows[0]])
        self._pyramid = None

    def _cover(self, low: Floats, high: Floats) -> None:
        border = self._radius + 2
        shape = np.array(self.score.shape[::-1])
        if shape[0] == 0:
            self.origin = np.floor(low / self.resolution) * self.resolution
        first = np.floor((low - self.origin) / self.resolution).astype(int) - border
        last = np.floor((high - self.origin) / self.resolution).astype(int) + border + 1
        if shape[0] and (first >= 0).all() and (last <= shape).all():
            return
        margin_cells = 40  # by which it grows at least, so that it seldom does
        before = np.where(first < 0, -first + margin_cells, 0)
        after = np.where(last > shape, last - shape + margin_cells, 0)
        pad = ((before[1], after[1]), (before[0], after[0]))
        self.score = np.pad(self.score, pad)
        self.index = np.pad(self.index, pad)
        self.origin = self.origin - before * self.resolution


@njit(cache=True)
def _stamp(
    score: Bytes,
    index: NDArray[np.uint16 | np.int32],
    planes: Singles,
    count: int,
    resolution: float,
    origin: Floats,
    points: Floats,
    normals: Floats,
    first: int,
    sigma: float,
    radius: int,
) -> tuple[int, int]:
    """Add points from `first` on; return the number of planes and the first point not added.

    A point is not added while there is no room for all the planes it may need.
    """
    scale = -0.5 * (resolution / sigma) ** 2
    width = 2 * radius + 1
    wx, wy = np.empty(width), np.empty(width)
    for i in range(first, len(points)):
        if count + width * width > len(planes):
            return count, i
        gx = (points[i, 0] - origin[0]) / resolution
        gy = (points[i, 1] - origin[1]) / resolution
        _fill_gaussian(wx, gx - int(gx) + radius, scale)
        _fill_gaussian(wy, gy - int(gy) + radius, scale)
        count = _stamp_point(
            score, index, planes, count, resolution, gx, gy, normals[i], wx, wy, radius
        )
    return count, len(points)


@njit(cache=True)
def _fill_gaussian(weights: Floats, centre: float, scale: float) -> None:
    for k in range(len(weights)):
        off = centre - k - 0.5
        weights[k] = math.exp(scale * off * off)


@njit(cache=True)
def _stamp_point(
    score: Bytes,
    index: NDArray[np.uint16 | np.int32],
    planes: Singles,
    count: int,
    resolution: float,
    gx: float,
    gy: float,
    normal: Floats,
    wx: Floats,
    wy: Floats,
    radius: int,
) -> int:
    """Add one point, in cells from the origin; return the number of planes."""
    nx, ny = normal[0], normal[1]
    flat = nx != 0.0 or ny != 0.0
    for a in range(len(wy)):
        r = int(gy) - radius + a
        dy = (gy - r - 0.5) * resolution
        for b in range(len(wx)):
            c = int(gx) - radius + b
            w = wx[b] * wy[a]
            level = int(255.0 * w + 0.5)
            if level < _LEVEL_MIN:
                continue
            if level > score[r, c]:
                score[r, c] = level
            if not flat:
                continue
            k = index[r, c]
            if k == 0:
                k = index[r, c] = count
                count += 1
            dx = (gx - c - 0.5) * resolution
            planes[k, 0] += w
            planes[k, 1] += w * nx
            planes[k, 2] += w * ny
            planes[k, 3] += w * (nx * dx + ny * dy)
    return count


@njit(cache=True)
def _crossings(
    index: NDArray[np.uint16 | np.int32], planes: Singles, resolution: float, origin: Floats
) -> tuple[Floats, Floats]:
    points, normals = np.empty((len(planes), 2)), np.empty((len(planes), 2))
    count = 0
    for r in range(index.shape[0]):
        for c in range(index.shape[1]):
            w, nx, ny, d = planes[index[r, c]]
            length = math.hypot(nx, ny)
            if index[r, c] == 0 or w < _CROSSED_MIN or length < _AGREED_MIN * w:
                continue
            nx, ny, d = nx / length, ny / length, d / length
            if max(abs(d * nx), abs(d * ny)) > 0.5 * resolution:
                continue
            points[count, 0] = origin[0] + (c + 0.5) * resolution + d * nx
            points[count, 1] = origin[1] + (r + 0.5) * resolution + d * ny
            normals[count, 0], normals[count, 1] = nx, ny
            count += 1
    return points[:count].copy(), normals[:count].copy()


def _build_pyramid(score: Bytes, depth: int) -> tuple[Bytes, Ints]:
    levels = np.zeros((depth + 1, 3), np.int64)
    levels[0, 1:] = score.shape
    parts: list[Bytes] = [np.empty(0, np.uint8)]
    blocks, start = score, 0
    for h in range(1, depth + 1):
        blocks = _halve(blocks)
        rows = np.zeros((blocks.shape[0] + 1, blocks.shape[1]), np.uint8)
        rows[:-1] = blocks
        np.maximum(rows[1:], blocks, out=rows[1:])
        part = np.zeros((rows.shape[0], rows.shape[1] + 1), np.uint8)
        part[:, :-1] = rows
        np.maximum(part[:, 1:], rows, out=part[:, 1:])
        levels[h] = (start, *part.shape)
        parts.append(part.ravel())
        start += part.size
    return np.concatenate(parts), levels


def _halve(blocks: Bytes) -> Bytes:
    """Return the maxima of blocks of 2 x 2 cells."""
    height, width = blocks.shape[0] // 2, blocks.shape[1] // 2
    rows = blocks[0::2].copy()
    np.maximum(rows[:height], blocks[1::2], out=rows[:height])
    half: Bytes = rows[:, 0::2].copy()
    np.maximum(half[:, :width], rows[:, 1::2], out=half[:, :width])
    return half
