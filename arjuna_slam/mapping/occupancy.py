"""Occupancy: counts of beams that pass through and end in each cell of a grid that grows.

A cell is occupied where more than two beams came and more than a tenth of them ended there, free
where fewer ended, unknown where fewer came: the rule of slam_toolbox (Karto), which counts a beam
twice where it ends (`OccupancyGrid::RayTrace`), so that two of one scan make a wall. By it alone a
noisy lidar makes walls three cells thick; so, unless `thin_walls` is off, a cell in whose line
clearly fewer beams ended than in the line beside is the fringe of that one, and not occupied. Cells
lie centred on multiples of their edge: walls stand at round coordinates more often than not, and
one on the border of two cells occupies both, each half a cell off.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from arjuna_core.arrays import Floats, Ints
from arjuna_core.grid import FREE, OCCUPIED, UNKNOWN, GridFrame, OccupancyGrid
from arjuna_core.raycast import line_cells
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2

_FRINGE = 0.65  # share of the beams that ended in the line beside from which on one is no fringe
_CHANCE = 0.5  # deviations by which the number of those may fall short by chance


class Occupancy:
    """A grid of counts and the map they make; only cells that change are computed again.

    Arguments as of `Keyframes`.
    """

    def __init__(
        self,
        resolution: float,
        min_pass_through: int,
        occupancy_threshold: float,
        thin_walls: bool = True,
    ) -> None:
        self._resolution = resolution
        self._passes_min = min_pass_through
        self._hit_share, self._thin = occupancy_threshold, thin_walls
        self._corner = np.zeros(2, np.int64)  # row and column of the first cell
        self._passes = np.zeros((0, 0), np.int32)
        self._hits = np.zeros((0, 0), np.int32)
        self._data = np.full((0, 0), UNKNOWN, np.int8)
        self._stale: Ints | None = None  # first and last row and column, both in
        self._seen: Ints | None = None
        self._robot: Ints | None = None  # where it was last: a lidar may see nothing beside it

    def trace(self, scan: Scan, pose: Floats, range_max: float, sign: int) -> None:
        """Add a scan's beams at a pose `(3,)` in map, or take them away where the sign is -1.

        Beams without return clear up to `range_max` [m].
        """
        ranges = np.asarray(scan.ranges, dtype=np.float64)
        reach = min(range_max, scan.range_max)
        lines = _lines(scan.rays(), ranges, pose, self._resolution, scan.range_min, reach)
        if len(lines) == 0:
            return
        rows, columns = lines[:, 0:3:2], lines[:, 1:4:2]
        box = np.array([rows.min(), rows.max(), columns.min(), columns.max()])
        if sign > 0:
            self._robot = np.floor(pose[1::-1] / self._resolution + 0.5).astype(np.int64).repeat(2)
        self._cover(_joined(self._robot, box))
        _count(self._passes, self._hits, self._corner, lines, sign)
        self._stale = _joined(self._stale, box)
        self._seen = _joined(self._seen, box)

    def grid(self, stamp: float) -> OccupancyGrid | None:
        """Return the map with values -1, 0 and 100, or None before the first beam."""
        if self._seen is None:
            return None
        if self._stale is not None:
            box = self._stale - self._corner.repeat(2) + (-1, 1, -1, 1)  # and what is beside
            _classify(
                self._passes, self._hits, self._data, np.maximum(box, 0),
                self._passes_min, self._hit_share, self._thin,
            )  # fmt: skip
            self._stale = None
        self._shrink(self._seen)
        shown = _joined(self._robot, self._seen)
        data = self._data[self._window(shown)].copy()
        x, y = (float(shown[k]) - 0.5 for k in (2, 0))
        origin = SE2(x * self._resolution, y * self._resolution)
        frame = GridFrame(self._resolution, data.shape[1], data.shape[0], origin)
        return OccupancyGrid(frame, data, stamp)

    def _window(self, box: Ints) -> tuple[slice, slice]:
        row, column = self._corner.tolist()
        first_row, last_row, first_column, last_column = box.tolist()
        return (
            slice(first_row - row, last_row - row + 1),
            slice(first_column - column, last_column - column + 1),
        )

    def _shrink(self, box: Ints) -> None:
        """Draw a box in to the cells that beams have come to, after some were taken away."""
        for side, step in ((0, 1), (1, -1), (2, 1), (3, -1)):
            edge = box.copy()
            edge[side ^ 1] = box[side]
            while box[side & 2] < box[side | 1] and not self._passes[self._window(edge)].any():
                box[side] += step
                edge[side] = edge[side ^ 1] = box[side]

    def _cover(self, box: Ints) -> None:
        if self._passes.size == 0:
            self._corner = box[0::2].copy()
        shape = np.array(self._passes.shape)
        before = self._corner - box[0::2]
        after = box[1::2] + 1 - (self._corner + shape)
        if (before <= 0).all() and (after <= 0).all():
            return
        share = 0.2  # of the grid: growing costs in proportion to the map, not its square
        margin_cells = 40  # by which it grows at least, so that it seldom does
        margin = np.maximum(margin_cells, (share * shape).astype(np.int64))
        before = np.where(before > 0, before + margin, 0)
        after = np.where(after > 0, after + margin, 0)
        self._passes = _grown(self._passes, before, after)
        self._hits = _grown(self._hits, before, after)
        pad = ((before[0], after[0]), (before[1], after[1]))
        self._data = np.pad(self._data, pad, constant_values=UNKNOWN)
        self._corner = self._corner - before


def _grown(counts: NDArray[np.int32], before: Ints, after: Ints) -> NDArray[np.int32]:
    """Return counts with zeros around; unlike those of `np.pad` they take no memory until used."""
    grown = np.zeros(counts.shape + before + after, np.int32)
    height, width = counts.shape
    grown[before[0] : before[0] + height, before[1] : before[1] + width] = counts
    return grown


def _joined(box: Ints | None, other: Ints) -> Ints:
    joined: Ints = other.copy()
    if box is not None:
        joined[0::2] = np.minimum(box, other)[0::2]
        joined[1::2] = np.maximum(box, other)[1::2]
    return joined


@njit(cache=True)
def _lines(
    rays: Floats, ranges: Floats, pose: Floats, resolution: float, range_min: float, reach: float
) -> Ints:
    """Return row and column of each beam's first and last cell, and 1 where it ended there."""
    lines = np.empty((len(ranges), 5), np.int64)
    count = 0
    cosine, sine = math.cos(pose[2]), math.sin(pose[2])
    for i in range(len(ranges)):
        r = ranges[i]
        if not r >= range_min or r <= 0.0:
            continue
        x = pose[0] + cosine * rays[i, 0] - sine * rays[i, 1]
        y = pose[1] + sine * rays[i, 0] + cosine * rays[i, 1]
        length, angle = min(r, reach), pose[2] + rays[i, 2]
        lines[count, 0] = math.floor(y / resolution + 0.5)
        lines[count, 1] = math.floor(x / resolution + 0.5)
        lines[count, 2] = math.floor((y + length * math.sin(angle)) / resolution + 0.5)
        lines[count, 3] = math.floor((x + length * math.cos(angle)) / resolution + 0.5)
        lines[count, 4] = 1 if r < reach else 0
        count += 1
    found: Ints = lines[:count]
    return found


@njit(cache=True)
def _count(
    passes: NDArray[np.int32], hits: NDArray[np.int32], corner: Ints, lines: Ints, sign: int
) -> None:
    """Add (or take away) passes and hits along Bresenham lines."""
    for i in range(len(lines)):
        first_row, first_column = lines[i, 0] - corner[0], lines[i, 1] - corner[1]
        row, column = lines[i, 2] - corner[0], lines[i, 3] - corner[1]
        for r, c in line_cells(first_row, first_column, row, column):
            passes[r, c] += sign
        hits[row, column] += sign * lines[i, 4]


@njit(cache=True)
def _classify(
    passes: NDArray[np.int32],
    hits: NDArray[np.int32],
    data: NDArray[np.int8],
    box: Ints,
    passes_min: int,
    hit_share: float,
    thin: bool,
) -> None:
    """Set the values of a box of cells: first and last row and column."""
    height, width = passes.shape
    for r in range(box[0], min(box[1] + 1, height)):
        for c in range(box[2], min(box[3] + 1, width)):
            came = passes[r, c] + hits[r, c]
            if came <= passes_min:
                data[r, c] = UNKNOWN
            elif hits[r, c] <= hit_share * came:
                data[r, c] = FREE
            elif not (thin and _is_fringe(hits, r, c)):
                data[r, c] = OCCUPIED
            else:  # before a wall most beams go on, behind it none do
                data[r, c] = FREE if 2 * hits[r, c] < passes[r, c] else UNKNOWN


@njit(cache=True)
def _is_fringe(hits: NDArray[np.int32], row: int, column: int) -> bool:
    """Return whether clearly more beams ended in the line of cells beside a cell's own.

    Lines along the wall are compared, which are those that differ most: how many beams end in each
    cell of a wall depends on how they happen to fall.
    """
    around = np.zeros((3, 3))
    for r in range(max(row - 1, 0), min(row + 2, hits.shape[0])):
        for c in range(max(column - 1, 0), min(column + 2, hits.shape[1])):
            around[r - row + 1, c - column + 1] = hits[r, c]
    widest, own, beside = -1.0, 0.0, 0.0
    for k in range(4):
        first, middle, last = _means(around, k)
        spread = max(first, middle, last) - min(first, middle, last)
        if spread > widest:
            widest, own, beside = spread, middle, max(first, last)
    return bool(own < _FRINGE * beside - _CHANCE * math.sqrt(beside))


@njit(cache=True)
def _means(around: Floats, k: int) -> tuple[float, float, float]:
    """Return the means of three lines of cells: rows, columns, and both diagonals."""
    if k == 0:
        return around[0].mean(), around[1].mean(), around[2].mean()
    if k == 1:
        return around[:, 0].mean(), around[:, 1].mean(), around[:, 2].mean()
    a = around if k == 2 else around[::-1]  # mirrored
    middle = (a[0, 0] + a[1, 1] + a[2, 2]) / 3.0
    return (a[0, 1] + a[1, 2]) / 2.0, middle, (a[1, 0] + a[2, 1]) / 2.0
