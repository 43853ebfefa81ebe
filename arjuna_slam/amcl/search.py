"""Global search: every place of a map where a scan could have been taken."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from arjuna_core.se2 import wrap
from arjuna_slam.amcl.field import DistanceField
from arjuna_slam.amcl.lookup import bordered, sum_at_endpoints

_SIGMA = 0.2  # how far a beam may end from an obstacle and still count [m]
_LEAF = 0.1  # finest step of position [m]
_HEADINGS = 120
_BEAMS = 90
_ROOTS_MAX = 200_000  # poses scored at the coarsest level
_KEPT_MIN = 8192  # poses that are looked into further, at least
_KEPT_SHARE = 0.05
_APART = 0.4  # found poses differ by this much [m] ...
_APART_HEADING = math.radians(20.0)  # ... or by this much


class GlobalSearch:
    """Coarse-to-fine matching of a scan against a whole map.

    Tables hold the best score within blocks of positions, so that a block's score bounds the
    score of every pose inside; the blocks that promise most are split until they are fine.

    Args:
        field: The map's distances.

    Source: Olson, Real-time correlative scan matching, 2009; the bounds are those of Hess et al.,
    Real-time loop closure in 2D lidar SLAM, 2016, section V-B, searched breadth first.
    """

    def __init__(self, field: DistanceField) -> None:
        self._field = field
        self._leaf = max(1, round(_LEAF / field.frame.resolution))
        levels = 0
        while self._block_count(self._leaf << levels) * _HEADINGS > _ROOTS_MAX:
            levels += 1
        self._pad = self._leaf << levels
        scores = np.exp(-(field.distances.astype(np.float64) ** 2) / (2.0 * _SIGMA**2))
        scores = np.pad(scores.astype(np.float32), self._pad)
        free = np.pad(field.free, self._pad)
        self._scores = bordered(scores, 0.0)
        best = [_pool(scores, self._leaf)]
        self._free = [_pool(free, self._leaf)]
        for level in range(levels):
            best.append(_pool_twice(best[-1], self._leaf << level))
            self._free.append(_pool_twice(self._free[-1], self._leaf << level))
        self._best = [bordered(table, 0.0) for table in best]

    def find(self, endpoints: NDArray[np.float64], limit: int) -> NDArray[np.float64]:
        """Return the most promising distinct poses for a scan, best first.

        Args:
            endpoints: `(M, 2) float64` in the base frame [m].
            limit: Greatest number of poses.

        Returns:
            `(K, 3) float64` in the map frame [m, m, rad], within a step of the true optimum.
        """
        stride = max(1, len(endpoints) // _BEAMS)
        cells = endpoints[::stride] / self._field.frame.resolution
        blocks = self._roots()
        kept = max(_KEPT_MIN, int(_KEPT_SHARE * len(blocks)))
        for level in range(len(self._best) - 1, -1, -1):
            scores = sum_at_endpoints(self._best[level], blocks, cells)
            blocks = blocks[_largest(scores, kept)]
            if level > 0:
                blocks = self._split(blocks, level)
        poses = blocks + np.array([0.5 * self._leaf, 0.5 * self._leaf, 0.0])
        scores = sum_at_endpoints(self._scores, poses, cells)
        poses[:, :2] -= self._pad
        origin, resolution = self._field.frame.origin, self._field.frame.resolution
        poses[:, :2] = origin.apply(poses[:, :2] * resolution)
        poses[:, 2] = wrap(poses[:, 2] + origin.theta)
        found: NDArray[np.float64] = poses[distinct(poses, scores, limit)]
        return found

    def _block_count(self, size: int) -> int:
        frame = self._field.frame
        return math.ceil(frame.height / size) * math.ceil(frame.width / size)

    def _roots(self) -> NDArray[np.float64]:
        """Return the coarsest blocks that hold a free cell, at every heading, `(N, 3)`."""
        size = self._pad
        free = self._free[-1][size::size, size::size]
        corners = np.argwhere(free)[:, ::-1] * size + size
        headings = np.arange(_HEADINGS) * (2.0 * math.pi / _HEADINGS)
        return np.column_stack(
            (np.repeat(corners, _HEADINGS, axis=0), np.tile(headings, len(corners)))
        )

    def _split(self, blocks: NDArray[np.float64], level: int) -> NDArray[np.float64]:
        """Return the quarters of blocks that hold a free cell."""
        half = self._leaf << (level - 1)
        offsets = np.array([[0, 0, 0], [half, 0, 0], [0, half, 0], [half, half, 0]])
        quarters = (blocks[:, np.newaxis, :] + offsets).reshape(-1, 3)
        columns, rows = quarters[:, 0].astype(np.int64), quarters[:, 1].astype(np.int64)
        height, width = self._free[0].shape
        inside = (columns < width) & (rows < height)
        inside[inside] = self._free[level - 1][rows[inside], columns[inside]]
        free: NDArray[np.float64] = quarters[inside]
        return free


def distinct(
    poses: NDArray[np.float64], scores: NDArray[np.floating], limit: int
) -> NDArray[np.int64]:
    """Return indices of the best poses `(N, 3)` of which no two are alike, best first."""
    scores = scores.copy()
    chosen: list[int] = []
    while len(chosen) < limit and len(scores):
        best = int(np.argmax(scores))
        if scores[best] == -np.inf:
            break
        chosen.append(best)
        near = np.hypot(*(poses[:, :2] - poses[best, :2]).T) < _APART
        turned = np.abs(wrap(poses[:, 2] - poses[best, 2])) < _APART_HEADING
        scores[near & turned] = -np.inf
    return np.array(chosen, dtype=np.int64)


def _largest(scores: NDArray[np.float32], count: int) -> NDArray[np.int64]:
    if len(scores) <= count:
        return np.arange(len(scores))
    largest: NDArray[np.int64] = np.sort(np.argpartition(-scores, count)[:count])
    return largest


def _pool(table: NDArray, size: int) -> NDArray:  # type: ignore[type-arg]
    """Return for each cell the greatest value of the `size` x `size` cells that begin at it."""
    pooled = table
    for axis in (0, 1):
        source = pooled
        for shift in range(1, size):
            pooled = np.maximum(pooled, _shifted(source, shift, axis))
    return pooled


def _pool_twice(pooled: NDArray, size: int) -> NDArray:  # type: ignore[type-arg]
    """Return the pooling over blocks twice as large from one over blocks of `size`."""
    for axis in (0, 1):
        pooled = np.maximum(pooled, _shifted(pooled, size, axis))
    return pooled


def _shifted(table: NDArray, shift: int, axis: int) -> NDArray:  # type: ignore[type-arg]
    """Return the table moved towards index 0 along an axis, zeros moving in."""
    result = np.zeros_like(table)
    keep = table.shape[axis] - shift
    source, target = [slice(None)] * 2, [slice(None)] * 2
    source[axis], target[axis] = slice(shift, None), slice(0, keep)
    result[tuple(target)] = table[tuple(source)]
    return result
