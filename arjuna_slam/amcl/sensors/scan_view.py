"""What one scan says, in the form that the filter's parts use."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arjuna_core.scan import Scan
from arjuna_core.se2 import IDENTITY, SE2
from arjuna_slam.amcl.config import AmclConfig

_MATCHED = 180  # more beams match no better: what the map errs by is the same for neighbours
_BESIDE = 1.0  # who stands so near hides much of the map [m]
_HIDDEN = 0.2  # share of the beams from which it may be much
_BEAMS_MIN = 10  # fewer beams with a return say nothing about where the robot is


@dataclass(frozen=True)
class Beams:
    """Beams of a scan that say something: NaN and too short ones do not.

    Attributes:
        directions: Unit vectors in the base frame, `(B, 2) float64`.
        ranges: `(B,) float64` [m]; a beam without return carries the longest range.
        returned: Which beams returned, `(B,) bool`.
        endpoints: Of the beams that returned, `(M, 2) float64` in the base frame [m].
    """

    directions: NDArray[np.float64]
    ranges: NDArray[np.float64]
    returned: NDArray[np.bool_]
    endpoints: NDArray[np.float64]


@dataclass(frozen=True)
class ScanView:
    """One scan.

    Attributes:
        stamp: [s].
        range_max: The longest range used [m].
        T_base_sensor: Pose of the sensor in the base frame.
        many: Beams for scan matching, from all around.
        few: At most `max_beams`, for the particles.
    """

    stamp: float
    range_max: float
    T_base_sensor: SE2
    many: Beams
    few: Beams

    @staticmethod
    def of(scan: Scan, config: AmclConfig) -> ScanView:
        """Read a scan; few beams are taken at even steps over the sweep, as nav2_amcl does."""
        low = max(config.laser_min_range, scan.range_min)
        high = scan.range_max
        if config.laser_max_range >= 0.0:
            high = min(config.laser_max_range, high)
        ranges = np.minimum(scan.ranges, high)
        mount = scan.T_base_sensor
        directions = _unit(scan.angles + mount.theta)
        if scan.motion != IDENTITY:
            ranges, directions = _deskewed(ranges, scan.rays(), mount, high)
        step = max(1, (len(ranges) - 1) // (config.max_beams - 1))
        stride = max(1, math.ceil(len(ranges) / _MATCHED))

        def beams(each: int) -> Beams:
            some = np.ascontiguousarray(ranges[::each])
            ways = np.ascontiguousarray(directions[::each])
            telling = some >= low  # NaN is not
            if not telling.all():
                some, ways = some[telling], ways[telling]
            returned = some < high
            ends = ways[returned] * some[returned, np.newaxis]
            ends += (mount.x, mount.y)
            return Beams(ways, some, returned, ends)

        return ScanView(scan.stamp, scan.range_max, mount, beams(stride), beams(step))

    @property
    def blind(self) -> bool:
        """Whether too few beams returned to tell where the robot is."""
        return len(self.many.endpoints) < _BEAMS_MIN

    @property
    def readings(self) -> list[NDArray[np.float64]]:
        """Ends of beams to match, each `(M, 2) float64` in the base frame [m], all of them first.

        Where many end near by, which may be walls or a crowd, the others come as a second reading.
        """
        ends, mount = self.many.endpoints, self.T_base_sensor
        far = ends[np.hypot(ends[:, 0] - mount.x, ends[:, 1] - mount.y) > _BESIDE]
        hidden = _BEAMS_MIN <= len(far) < (1.0 - _HIDDEN) * len(ends)
        return [ends, far] if hidden else [ends]


def _unit(bearings: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.column_stack((np.cos(bearings), np.sin(bearings)))


def _deskewed(
    ranges: NDArray[np.float64], rays: NDArray[np.float64], mount: SE2, high: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return ranges and directions as seen from where the sensor was at beam 0."""
    directions = _unit(rays[:, 2])
    far = ~(np.isfinite(ranges) & (ranges < high))
    lengths = np.where(far, 1.0, np.maximum(ranges, 1e-6))
    offsets = rays[:, :2] - (mount.x, mount.y) + directions * lengths[:, np.newaxis]
    seen = np.hypot(offsets[:, 0], offsets[:, 1])
    directions = np.where(far[:, np.newaxis], directions, offsets / seen[:, np.newaxis])
    return np.where(far, ranges, np.minimum(seen, np.nextafter(high, 0.0))), directions
