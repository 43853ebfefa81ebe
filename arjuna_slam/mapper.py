"""Occupancy mapping: counts of beams that pass through and end in each cell.

A cell is occupied where more than two beams came and more than a tenth of them ended there, free
where fewer ended, unknown where fewer came: the rule of slam_toolbox (Karto).
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from arjuna_core.grid import FREE, OCCUPIED, UNKNOWN, GridFrame, OccupancyGrid
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2

_MARGIN_CELLS = 40
_MOVED_POSITION_CELLS = 0.5
_MOVED_HEADING = 0.005


class Mapper:
    """Keeps scans and traces them where their poses say.

    Args:
        resolution: Edge of a cell [m].
        range_max: Longest range traced [m]; beams without return clear up to it.
        min_pass_through: Beams that must come to a cell for it to be known, and one more.
        occupancy_threshold: Share of them that must end there for it to be occupied.
    """

    def __init__(
        self,
        resolution: float,
        range_max: float,
        min_pass_through: int = 2,
        occupancy_threshold: float = 0.1,
    ) -> None:
        self._passes_min = min_pass_through
        self._hit_share = occupancy_threshold
        self._resolution = resolution
        self._range_max = range_max
        self._scans: list[Scan] = []
        self._traced = np.empty((0, 3))
        self._corner = np.zeros(2, np.int64)
        self._passes = np.zeros((0, 0), np.int32)
        self._hits = np.zeros((0, 0), np.int32)

    def add(self, scan: Scan) -> None:
        """Add a scan; it is traced when a grid is next asked for."""
        self._scans.append(scan)

    @property
    def scans(self) -> tuple[Scan, ...]:
        """The scans added."""
        return tuple(self._scans)

    def grid(self, poses: NDArray[np.float64]) -> OccupancyGrid | None:
        """Return the map, tracing what is new or has moved.

        Args:
            poses: Robot in map at each scan added, `(N, 3) float64` of x, y, theta.

        Returns:
            The map with values -1, 0 and 100, or None without scans.

        Raises:
            ValueError: The number of poses is not that of scans.
        """
        if len(poses) != len(self._scans):
            raise ValueError(f"{len(poses)} poses for {len(self._scans)} scans")
        if not self._scans:
            return None
        poses = poses.copy()
        for k in np.flatnonzero(self._moved(poses)).tolist():
            self._trace(k, self._traced[k], -1)
            self._trace(k, poses[k], 1)
            self._traced[k] = poses[k]
        for k in range(len(self._traced), len(poses)):
            self._trace(k, poses[k], 1)
        self._traced = np.concatenate((self._traced, poses[len(self._traced) :]))
        return self._classify()

    def _moved(self, poses: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Tell which traced scans have moved enough to be traced anew."""
        change = poses[: len(self._traced)] - self._traced
        far = np.hypot(change[:, 0], change[:, 1]) > _MOVED_POSITION_CELLS * self._resolution
        turn = np.abs(np.remainder(change[:, 2] + np.pi, 2.0 * np.pi) - np.pi)
        moved: NDArray[np.bool_] = far | (turn > _MOVED_HEADING)
        return moved

    def _trace(self, k: int, pose: NDArray[np.float64], sign: int) -> None:
        scan = self._scans[k]
        sensor = self._from_corner(SE2.from_array(pose) @ scan.T_base_sensor)
        reach = min(self._range_max, scan.range_max)
        ranges = np.asarray(scan.ranges, dtype=np.float64)
        used = np.where(np.isfinite(ranges), np.clip(ranges, 0.0, reach), 0.0)
        longest = float(np.where(np.isposinf(ranges), reach, used).max(initial=0.0))
        self._cover(sensor, longest)
        _count(
            self._passes, self._hits, self._resolution, self._corner, sensor.x, sensor.y,
            sensor.theta + scan.angle_min, scan.angle_increment, ranges, scan.range_min, reach,
            sign,
        )  # fmt: skip

    def _from_corner(self, pose: SE2) -> SE2:
        """Return a pose seen from the corner of the cell at the origin.

        Cells lie centred on multiples of their edge: walls stand at round coordinates more often
        than not, and one on the border of two cells occupies both, each half a cell off.
        """
        half = 0.5 * self._resolution
        return SE2(pose.x + half, pose.y + half, pose.theta)

    def _cover(self, sensor: SE2, reach: float) -> None:
        """Grow so that a disc around the sensor lies inside."""
        centre = np.array([sensor.x, sensor.y])
        low = np.floor((centre - reach) / self._resolution).astype(np.int64) - 1
        high = np.floor((centre + reach) / self._resolution).astype(np.int64) + 2
        if self._passes.size == 0:
            self._corner = low
        shape = np.array(self._passes.shape[::-1])
        before = self._corner - low
        after = high - (self._corner + shape)
        if (before <= 0).all() and (after <= 0).all():
            return
        before = np.where(before > 0, before + _MARGIN_CELLS, 0)
        after = np.where(after > 0, after + _MARGIN_CELLS, 0)
        pad = ((before[1], after[1]), (before[0], after[0]))
        self._passes, self._hits = np.pad(self._passes, pad), np.pad(self._hits, pad)
        self._corner = self._corner - before

    def _classify(self) -> OccupancyGrid | None:
        seen = self._passes > 0
        rows, columns = np.flatnonzero(seen.any(axis=1)), np.flatnonzero(seen.any(axis=0))
        if len(rows) == 0:
            return None
        across, along = slice(columns[0], columns[-1] + 1), slice(rows[0], rows[-1] + 1)
        passes, hits = self._passes[along, across], self._hits[along, across]
        data: NDArray[np.int8] = np.full(passes.shape, UNKNOWN, np.int8)
        known = passes > self._passes_min
        data[known] = FREE
        data[known & (hits > self._hit_share * passes)] = OCCUPIED
        x = (float(self._corner[0] + columns[0]) - 0.5) * self._resolution
        y = (float(self._corner[1] + rows[0]) - 0.5) * self._resolution
        frame = GridFrame(self._resolution, data.shape[1], data.shape[0], SE2(x, y))
        return OccupancyGrid(frame, data, self._scans[-1].stamp)


@njit(cache=True)
def _count(
    passes: NDArray[np.int32],
    hits: NDArray[np.int32],
    resolution: float,
    corner: NDArray[np.int64],
    x: float,
    y: float,
    bearing: float,
    increment: float,
    ranges: NDArray[np.float64],
    range_min: float,
    reach: float,
    sign: int,
) -> None:
    """Add (or take away) one scan's passes and hits, along Bresenham lines."""
    column0 = math.floor(x / resolution) - corner[0]
    row0 = math.floor(y / resolution) - corner[1]
    for i in range(len(ranges)):
        r = ranges[i]
        if not r >= range_min or r <= 0.0:
            continue
        hit = r < reach
        length = min(r, reach)
        angle = bearing + increment * i
        column = math.floor((x + length * math.cos(angle)) / resolution) - corner[0]
        row = math.floor((y + length * math.sin(angle)) / resolution) - corner[1]
        d_row, d_column = abs(row - row0), abs(column - column0)
        step_row = 1 if row > row0 else -1
        step_column = 1 if column > column0 else -1
        error, r0, c0 = d_column - d_row, row0, column0
        for _ in range(max(d_row, d_column) + 1):
            passes[r0, c0] += sign
            double = 2 * error
            if double > -d_row:
                error -= d_row
                c0 += step_column
            if double < d_column:
                error += d_column
                r0 += step_row
        if hit:
            hits[row, column] += sign
