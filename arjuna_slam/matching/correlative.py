"""Correlative search: the best pose of a scan in a window, exact to a cell and an angle step.

Sources: Olson, Real-time correlative scan matching, 2009 (multi-resolution bounds); Hess et al.,
Real-time loop closure in 2D LIDAR SLAM, 2016, section V (branch and bound); penalties as Karto.
"""

from __future__ import annotations

import math
from collections.abc import Generator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter

from arjuna_core.arrays import Floats, Ints, Singles
from arjuna_core.se2 import SE2, wrap
from arjuna_slam.matching.branch_and_bound import descend, prepare
from arjuna_slam.matching.field import Field
from arjuna_slam.matching.map_field import MapField, bordered, sum_at_endpoints

_ANGLE_STEP_MIN = math.radians(0.25)
_WORK = 10000  # blocks of offsets looked at in a step of a search that waits between: some ms


@dataclass(frozen=True)
class Window:
    """Search window, and how much to trust the prior."""

    xy: float  # half the width of the window [m]
    theta: float  # half its angle [rad]
    depth: int  # levels of the pyramid
    distance_penalty: float = math.inf  # variance of the penalty on distance [m^2]; inf for none
    angle_penalty: float = math.inf  # variance of the penalty on angle [rad^2]; inf for none
    floor_xy: float = 0.5  # least the distance penalty may become
    floor_theta: float = 0.9  # least the angle penalty may become


def search(
    field: Field, points: Floats, prior: SE2, window: Window, least: float
) -> tuple[SE2, float] | None:
    """Return the pose of the greatest response and the response; None where none exceeds `least`.

    The response (0..1) is the mean likelihood of the points, in the robot's base frame, times the
    penalties; `prior` is the middle of the window.
    """
    steps = searching(field, points, prior, window, least, work=1 << 62)  # all work in one
    while True:
        try:
            next(steps)
        except StopIteration as end:
            found: tuple[SE2, float] | None = end.value
            return found


def searching(
    field: Field,
    points: Floats,
    prior: SE2,
    window: Window,
    least: float,
    apart: tuple[Sequence[SE2], float] | None = None,
    work: int = _WORK,
) -> Generator[None, None, tuple[SE2, float] | None]:
    """Search as `search` does, in steps of a bounded time: `work` blocks of offsets each.

    With `apart`, poses and a distance in x or y from each [m], the question is whether there is any
    pose so far from all of them: the first one found is returned.
    """
    if len(points) == 0 or field.score.size == 0:
        return None
    size = field.resolution
    thetas = prior.theta + _turns(points, size, window.theta)
    tables = field.score, *field.pyramid(window.depth)
    xy = (np.array([prior.x, prior.y]) - field.origin) / size
    half = math.ceil(window.xy / size)
    scales = 0.2 * size**2 / window.distance_penalty, 0.2 / window.angle_penalty
    penalty = np.array([*scales, window.floor_xy, window.floor_theta])
    without = _left_out(apart, prior, size)
    task = prepare(tables, points / size, xy, thetas, half, penalty, least)
    best, done = (-1, 0, 0, float(least)), 0
    while True:
        done, best = descend(tables, task, half, penalty, without, best, done, work)
        if done == len(task[3]):
            break
        yield
    k, row, column, response = best
    if k < 0:
        return None
    return SE2(prior.x + column * size, prior.y + row * size, float(thetas[k])), response


def _turns(points: Floats, resolution: float, theta: float) -> Floats:
    """Return turns up to theta in steps that move nine points of ten by a cell at most [rad]."""
    far = int(0.9 * (len(points) - 1))
    reach = float(np.partition(np.hypot(points[:, 0], points[:, 1]), far)[far])
    step = max(resolution / max(reach, resolution), _ANGLE_STEP_MIN)
    half_steps = math.ceil(theta / step)
    return step * np.arange(-half_steps, half_steps + 1, dtype=np.float64)


def _left_out(apart: tuple[Sequence[SE2], float] | None, prior: SE2, resolution: float) -> Ints:
    """Return first and last row and column of boxes of offsets left out, `(K, 4) int64`."""
    poses, far = apart or ((), 0.0)
    gaps = np.array([(pose.y - prior.y, pose.x - prior.x) for pose in poses]).reshape(-1, 2)
    boxes = np.round(gaps.repeat(2, axis=1) / resolution)
    boxes += round(far / resolution) * np.array([-1, 1, -1, 1])
    cells: Ints = boxes.astype(np.int64)
    return cells


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
        origin = self._frame.origin
        positions = origin.apply((poses[:, :2] - self._sizes[-1]) * self._frame.resolution)
        found = np.column_stack((positions, wrap(poses[:, 2] + origin.theta)))
        return found[distinct(found, scores, limit)]

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


def _largest(scores: Singles, count: int) -> Ints:
    if len(scores) <= count:
        return np.arange(len(scores))
    largest: Ints = np.sort(np.argpartition(-scores, count)[:count])
    return largest


def _pool(table: NDArray[Any], size: int) -> NDArray[Any]:
    """Return for each cell the greatest value of the `size` x `size` cells that begin at it."""
    pooled: NDArray[Any] = maximum_filter(table, size, mode="constant", origin=-(size // 2))
    return pooled
