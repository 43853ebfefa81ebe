"""Contradiction: whether beams have gone through what another scan says is there.

Two corridors look alike along their walls; what distinguishes them is that one continues where the
other ends. A likelihood does not see that, since it counts no free space.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from numba import njit
from scipy import ndimage

from arjuna_core.arrays import Bools, Floats, Ints
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2

_THROUGH, _ON = 0.4, 0.2  # a beam so much longer than the distance to a point goes through it [m]


def seen_and_contradicted(
    points: Floats, scans: Iterable[tuple[Scan, SE2]], range_max: float
) -> tuple[Bools, Bools]:
    """Return which points scans see, and which of those their beams go through, each `(N,) bool`.

    Each scan comes with its robot's pose in the points' frame.
    """
    on, through = np.zeros(len(points), np.int64), np.zeros(len(points), np.int64)
    for scan, pose in scans:
        _count(*_beams(scan, pose, range_max), points, on, through)
    seen = on + through > 0
    share = 0.7  # of a point's beams that must go through it
    against = through > share * (on + through)
    return seen, seen & against


def longest(points: Floats) -> float:
    """Return how long the longest wall is that points on it make up without gaps [m]."""
    if not len(points):
        return 0.0
    gap = 0.2  # [m] side of cells that are one piece where they touch
    cells = np.floor(points / gap).astype(np.int64)
    cells -= cells.min(axis=0)
    taken = np.zeros(cells.max(axis=0) + 1, np.bool_)
    taken[cells[:, 0], cells[:, 1]] = True
    names, count = ndimage.label(taken, np.ones((3, 3)))
    which, every = names[cells[:, 0], cells[:, 1]], np.arange(1, count + 1)
    size = [
        ndimage.maximum(xy, which, every) - ndimage.minimum(xy, which, every) for xy in points.T
    ]
    return float(np.hypot(*size).max())


def gone_through(points: Floats, scans: Iterable[tuple[Scan, SE2]], range_max: float) -> Bools:
    """Return which points beams of any scan go through, as `seen_and_contradicted`."""
    result = np.zeros(len(points), np.bool_)
    for scan, pose in scans:
        _pass(*_beams(scan, pose, range_max), points, result)
    return result


_Beams = tuple[Floats, Floats, Floats]
"""Ranges [m]; first angle, increment, least and greatest range used; the sensor's pose."""


def _beams(scan: Scan, pose: SE2, range_max: float) -> _Beams:
    how = (scan.angle_min, scan.angle_increment, scan.range_min, min(scan.range_max, range_max))
    ranges = np.asarray(scan.ranges, dtype=np.float64)
    return ranges, np.array(how), (pose @ scan.T_base_sensor).array()


@njit(cache=True)
def _toward(
    ranges: Floats, how: Floats, sensor: Floats, x: float, y: float
) -> tuple[float, float, float]:
    """Return the distance to a point and the least and greatest range there; inf if unseen."""
    first, increment, range_min, range_max = how
    dx, dy = x - sensor[0], y - sensor[1]
    distance = math.hypot(dx, dy)
    if distance >= range_max or distance < range_min:
        return math.inf, 0.0, 0.0
    turn = math.copysign(1.0, increment) * (math.atan2(dy, dx) - sensor[2] - first)
    beam = round((turn % (2.0 * math.pi)) / abs(increment))
    if beam < 1 or beam + 1 >= len(ranges):
        return math.inf, 0.0, 0.0
    shortest, longest = math.inf, 0.0
    for measured in ranges[beam - 1 : beam + 2]:
        if not range_min <= measured < range_max:  # what is not a number says nothing, too
            return math.inf, 0.0, 0.0
        shortest, longest = min(shortest, measured), max(longest, measured)
    return distance, shortest, longest


@njit(cache=True)
def _count(
    ranges: Floats, how: Floats, sensor: Floats, points: Floats, on: Ints, through: Ints
) -> None:
    for k in range(len(points)):
        distance, shortest, longest = _toward(ranges, how, sensor, points[k, 0], points[k, 1])
        if shortest > distance + _THROUGH:
            through[k] += 1
        elif shortest - _ON < distance < longest + _ON:
            on[k] += 1


@njit(cache=True)
def _pass(ranges: Floats, how: Floats, sensor: Floats, points: Floats, through: Bools) -> None:
    for k in range(len(points)):
        if not through[k]:
            distance, shortest, _ = _toward(ranges, how, sensor, points[k, 0], points[k, 1])
            through[k] = shortest > distance + _THROUGH
