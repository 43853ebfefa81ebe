"""Agreement: what share of a scan's beams the map explains at a pose."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arjuna_core.raycast import cast
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_slam.amcl.config import AmclConfig
from arjuna_slam.amcl.field import DistanceField
from arjuna_slam.amcl.sensor import range_limits

_NEAR = 0.15  # a beam this near to an obstacle hit it [m]
_THROUGH = 0.5  # a beam this much longer than the map allows went through an obstacle [m]


@dataclass(frozen=True)
class Rays:
    """A scan's beams for comparison with a map.

    Attributes:
        T_base_sensor: Pose of the sensor in the base frame.
        bearings: Of all beams that say something, `(B,) float64` in the sensor frame [rad].
        ranges: `(B,) float64` [m]; a beam without return carries the longest range.
        returned: Which beams returned, `(B,) bool`.
    """

    T_base_sensor: SE2
    bearings: NDArray[np.float64]
    ranges: NDArray[np.float64]
    returned: NDArray[np.bool_]

    @staticmethod
    def of(scan: Scan, config: AmclConfig) -> Rays:
        """Take the beams of a scan; NaN and too short ones say nothing."""
        low, high = range_limits(scan, config)
        with np.errstate(invalid="ignore"):
            telling = scan.ranges >= low
        ranges = np.minimum(scan.ranges[telling], high)
        return Rays(scan.T_base_sensor, scan.angles[telling], ranges, ranges < high)


def agreement(field: DistanceField, pose: NDArray[np.float64], rays: Rays) -> float:
    """Return the share of beams (0..1) that agree with the map at a pose.

    A beam agrees if it ends near an obstacle of the map and crossed none on its way. A beam
    without return counts only against the pose, where the map has an obstacle in its way; thus
    poses are told apart that end points alone do not tell apart.

    Args:
        field: The map's distances.
        pose: Of the base, `(3,) float64` in the map frame [m, m, rad].
        rays: The scan.
    """
    sensor = SE2.from_array(pose) @ rays.T_base_sensor
    origin = field.to_grid(sensor.array()[np.newaxis])[0]
    resolution = field.frame.resolution
    bearings = rays.bearings + origin[2]
    x, y = origin[0] * resolution, origin[1] * resolution
    longest = float(rays.ranges.max()) if len(rays.ranges) else 0.0
    expected = cast(field.occupied, resolution, x, y, bearings, longest)
    through = rays.ranges > expected + _THROUGH
    ends = np.column_stack((np.cos(bearings), np.sin(bearings))) * rays.ranges[:, np.newaxis]
    cells = np.floor(ends / resolution + origin[:2]).astype(np.int64)[:, ::-1]
    near = _near(field, cells) & rays.returned & ~through
    counted = int((rays.returned | through).sum())
    return float(near.sum() / counted) if counted else 0.0


def _near(field: DistanceField, cells: NDArray[np.int64]) -> NDArray[np.bool_]:
    inside = field.frame.inside(cells)
    clipped = np.clip(cells, 0, np.array(field.frame.shape) - 1)
    return inside & (field.distances[clipped[:, 0], clipped[:, 1]] < _NEAR)
