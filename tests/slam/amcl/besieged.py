"""People close about a robot, who stop a share of its beams."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from arjuna_core.scan import Scan

_RADIUS = 0.25  # of a person [m]
_HIDES = 0.05  # that a beam must be shorter for it [m]
_MOST = 300  # people tried


def besieged(
    scan: Scan, share: float, rng: np.random.Generator, near: tuple[float, float] = (0.05, 1.0)
) -> Scan:
    """Return a scan in which people stop at least a share of the beams, if so many find room.

    Args:
        scan: Of walls alone.
        share: 0..1.
        rng: For where they stand.
        near: From the lidar to them, at least and at most [m].
    """
    ranges = scan.ranges
    for _ in range(_MOST):
        if np.mean(ranges < scan.ranges - _HIDES) >= share:
            break
        away, bearing = rng.uniform(*near) + _RADIUS, rng.uniform(-math.pi, math.pi)
        facing = int(np.argmax(np.cos(scan.angles - bearing)))
        if scan.ranges[facing] > away:
            ranges = np.minimum(ranges, _to_person(scan.angles, away, bearing))
    return replace(scan, ranges=ranges)


def _to_person(angles: NDArray[np.float64], away: float, bearing: float) -> NDArray[np.float64]:
    along, across = away * np.cos(angles - bearing), away * np.sin(angles - bearing)
    depth = _RADIUS**2 - across**2
    ranges: NDArray[np.float64] = np.where(
        (depth > 0.0) & (along > 0.0), along - np.sqrt(np.maximum(depth, 0.0)), np.inf
    )
    return ranges
