"""Global search: every pose in a map at which a scan could have been taken.

Breadth first where `correlative` goes depth first: many distinct poses are wanted, and the time
must not depend on how well the scan fits. Depth first, the best twelve take 9 ms in the room, but
60 ms in the office and 340 ms there with clutter in the scan; this takes 21, 29 and 28 ms.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter

from arjuna_core.arrays import Floats, Ints
from arjuna_core.se2 import wrap
from arjuna_slam.matching.map_field import MapField, bordered, sum_at_endpoints

# Cost and grain of the search; they change how long it takes, not what counts as a match.
_SIGMA = 0.2  # how far a beam may end from an obstacle and still count [m]; two steps of position
_HEADINGS = 120  # steps of 3 degrees, which move a beam of 4 m by _SIGMA
_APART = 0.4  # found poses differ by this much [m] ...
_APART_HEADING = math.radians(20.0)  # ... or by this much


class GlobalSearch:
    """Coarse-to-fine matching of a scan against a whole map.

    Tables hold the best score within blocks of positions, so that a block's score bounds the
    score of every pose inside; the blocks that promise most are split until they are fine.

    Source: Olson, Real-time correlative scan matching, 2009; the bounds are those of Hess et al.,
    Real-time loop closure in 2D lidar SLAM, 2016, section V-B, searched breadth first.
    """

    def __init__(self, field: MapField) -> None:
        self._frame = field.frame
        leaf = 0.1  # [m] finest step of position, within reach of the refinement
        self._leaf = max(1, round(leaf / field.frame.resolution))
        sizes = [self._leaf]
        roots_max = 200_000  # poses scored at the coarsest level
        while self._block_count(sizes[-1]) * _HEADINGS > roots_max:
            sizes.append(2 * sizes[-1])
        self._sizes = sizes
        likelihood = np.exp(-(field.distances.astype(np.float64) ** 2) / (2.0 * _SIGMA**2))
        padded = np.pad(likelihood.astype(np.float32), sizes[-1])
        free = np.pad(field.free, sizes[-1])
        self._likelihood = bordered(padded, 0.0)
        self._bounds = [bordered(_pool(padded, size), 0.0) for size in sizes]
        self._free = [_pool(free.view(np.uint8), size).view(np.bool_) for size in sizes]

    def find(self, endpoints: Floats, limit: int) -> Floats:
        """Return the most promising distinct poses for a scan, best first, `(K, 3)` [m, m, rad].

        Endpoints are in the base frame [m]; poses are within a step of the true optimum.
        """
        most = 90  # beams that are scored: one in four degrees
        stride = max(1, len(endpoints) // most)
        cells = endpoints[::stride] / self._frame.resolution
        blocks = self._roots()
        kept_min = 8192  # poses that are looked into further, at least
        kept_share = 0.05  # ... and of all at that level
        kept = max(kept_min, int(kept_share * len(blocks)))
        for level in range(len(self._sizes) - 1, -1, -1):
            scores = sum_at_endpoints(self._bounds[level], blocks, cells)
            blocks = blocks[_largest(scores, kept)]
            if level > 0:
                blocks = self._split(blocks, level - 1)
        poses = blocks + np.array([0.5 * self._leaf, 0.5 * self._leaf, 0.0])
        scores = sum_at_endpoints(self._likelihood, poses, cells)
        found = self._in_map(poses)
        return found[distinct(found, scores, limit)]

    def _in_map(self, poses: Floats) -> Floats:
        origin = self._frame.origin
        positions = origin.apply((poses[:, :2] - self._sizes[-1]) * self._frame.resolution)
        return np.column_stack((positions, wrap(poses[:, 2] + origin.theta)))

    def _block_count(self, size: int) -> int:
        return math.ceil(self._frame.height / size) * math.ceil(self._frame.width / size)

    def _roots(self) -> Floats:
        """Return the coarsest blocks that hold a free cell, at every heading, `(N, 3)`."""
        size = self._sizes[-1]
        corners = np.argwhere(self._free[-1][size::size, size::size])[:, ::-1] * size + size
        headings = np.arange(_HEADINGS) * (2.0 * math.pi / _HEADINGS)
        return np.column_stack(
            (np.repeat(corners, _HEADINGS, axis=0), np.tile(headings, len(corners)))
        )

    def _split(self, blocks: Floats, level: int) -> Floats:
        half = self._sizes[level]
        offsets = np.array([[0, 0, 0], [half, 0, 0], [0, half, 0], [half, half, 0]])
        quarters = (blocks[:, np.newaxis, :] + offsets).reshape(-1, 3)
        columns, rows = quarters[:, 0].astype(np.int64), quarters[:, 1].astype(np.int64)
        height, width = self._free[0].shape
        inside = (columns < width) & (rows < height)
        inside[inside] = self._free[level][rows[inside], columns[inside]]
        free: Floats = quarters[inside]
        return free


def distinct(poses: Floats, scores: NDArray[np.floating], limit: int) -> Ints:
    """Return indices of the best poses `(N, 3)` of which no two are alike, best first."""
    scores = scores.copy()
    chosen: list[int] = []
    while len(chosen) < limit and len(scores):
        best = int(np.argmax(scores))
        if scores[best] == -np.inf:
            break
        chosen.append(best)
        near = np.hypot(*(poses[:, :2] - poses[best, :2]).T) < _APART
        alike = np.abs(wrap(poses[:, 2] - poses[best, 2])) < _APART_HEADING
        scores[near & alike] = -np.inf
    return np.array(chosen, dtype=np.int64)


def _largest(scores: NDArray[np.float32], count: int) -> Ints:
    if len(scores) <= count:
        return np.arange(len(scores))
    largest: Ints = np.sort(np.argpartition(-scores, count)[:count])
    return largest


def _pool(table: NDArray[Any], size: int) -> NDArray[Any]:
    """Return for each cell the greatest value of the `size` x `size` cells that begin at it."""
    pooled: NDArray[Any] = maximum_filter(table, size, mode="constant", origin=-(size // 2))
    return pooled
