"""Which of the things in a scan move, and how fast."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_nav.costmap.moving.outlines import free_standing

_KEPT = 8  # sightings of a track
_LOOKS = 4  # that make a speed
_SPAN = 0.9  # that sightings count [s]
_LOST = 0.5  # after which a track ends [s]
_GATE = 0.4  # from where a thing is expected [m]
_SLOWEST, _FASTEST = 0.2, 3.0  # of what is taken for moving [m/s]
_TRAVELLED = 0.15  # by both outer points before it is [m]
_MOST = 128  # tracks


@dataclass(frozen=True, eq=False)
class Moving:
    """What of a scan moves.

    Attributes:
        points: Where its beams end, in the fixed frame, `(N, 2)` [m].
        velocities: Of each, `(N, 2)` [m/s]; 0 for what stands or is not known to move.
        stamp: Of the scan [s].
    """

    points: NDArray[np.float64]
    velocities: NDArray[np.float64]
    stamp: float

    @staticmethod
    def nothing() -> Moving:
        """Return what is known before any scan."""
        return Moving(np.zeros((0, 2)), np.zeros((0, 2)), -math.inf)


class Tracker:
    """Follows the free-standing things of scans from one to the next.

    A thing moves as slowly as the slower of its two outer points: the outer points of what stands
    stay where they are, while its middle seems to wander as the robot passes it.

    Source: nearest-neighbour tracking with a constant velocity (Bar-Shalom and Fortmann, Tracking
        and data association, 1988); speeds by least squares over the last sightings.
    """

    def __init__(self) -> None:
        self._seen = np.zeros((_MOST, _KEPT, 5))  # t, x, y of the first, x, y of the last
        self._counts = np.zeros(_MOST, np.int64)  # sightings; 0 for a free place

    def reset(self) -> None:
        """Forget all."""
        self._counts[:] = 0

    def update(self, scan: Scan, T_fixed_base: SE2) -> Moving:
        """Take the next scan, and return what of it moves.

        Args:
            scan: The scan.
            T_fixed_base: Pose of the base in a frame that stays, at the scan's stamp.
        """
        ranges = np.where(scan.valid, scan.ranges, np.inf)
        angles = scan.angles
        reach = np.where(scan.valid, scan.ranges, np.nan)
        ends = np.column_stack((reach * np.cos(angles), reach * np.sin(angles)))
        points = (T_fixed_base @ scan.T_base_sensor).apply(ends)
        round_it = abs(scan.angle_increment) * len(ranges) > 2.0 * math.pi - 0.05
        things = free_standing(points, ranges, round_it)
        velocities = np.zeros_like(points)
        if len(things):
            _follow(self._seen, self._counts, points, things, scan.stamp, velocities)
        return Moving(points[scan.valid], velocities[scan.valid], scan.stamp)


@njit(cache=True)
def _follow(
    seen: NDArray[np.float64],
    counts: NDArray[np.int64],
    points: NDArray[np.float64],
    things: NDArray[np.int64],
    now: float,
    velocities: NDArray[np.float64],
) -> None:
    """Give each thing to the nearest track or a new one, and fill the velocities of its beams."""
    for track in range(_MOST):
        if counts[track] and not 0.0 <= now - seen[track, _latest(counts[track]), 0] <= _LOST:
            counts[track] = 0
    taken = np.zeros(_MOST, np.bool_)
    for k in range(len(things)):
        first, last = things[k]
        track = _nearest(seen, counts, taken, points[first], points[last], now)
        if track < 0:
            continue
        taken[track] = True
        row = seen[track, counts[track] % _KEPT]
        row[0], row[1:3], row[3:5] = now, points[first], points[last]
        counts[track] += 1
        vx, vy = _velocity(seen[track], counts[track], now)
        velocities[first : last + 1, 0], velocities[first : last + 1, 1] = vx, vy


@njit(cache=True)
def _latest(count: int) -> int:
    return (count - 1) % _KEPT


@njit(cache=True)
def _nearest(
    seen: NDArray[np.float64],
    counts: NDArray[np.int64],
    taken: NDArray[np.bool_],
    first: NDArray[np.float64],
    last: NDArray[np.float64],
    now: float,
) -> int:
    """Return the track whose next place is nearest, a free one where none is; -1 for neither."""
    best, least, empty = -1, _GATE, -1
    x, y = 0.5 * (first[0] + last[0]), 0.5 * (first[1] + last[1])
    for track in range(_MOST):
        if taken[track]:
            continue
        if not counts[track]:
            empty = track if empty < 0 else empty
            continue
        row = seen[track, _latest(counts[track])]
        vx, vy = _velocity(seen[track], counts[track], now)
        ahead = now - row[0]
        gap = math.hypot(
            0.5 * (row[1] + row[3]) + vx * ahead - x, 0.5 * (row[2] + row[4]) + vy * ahead - y
        )
        if gap < least:
            best, least = track, gap
    return best if best >= 0 else empty


@njit(cache=True)
def _velocity(seen: NDArray[np.float64], count: int, now: float) -> tuple[float, float]:
    """Return the velocity of the slower outer point; 0 where it is not sure."""
    looks = 0
    t, sums = 0.0, np.zeros(4)
    for k in range(min(count, _KEPT)):
        if now - seen[k, 0] <= _SPAN:
            looks += 1
            t += seen[k, 0]
            sums += seen[k, 1:5]
    if looks < _LOOKS:
        return 0.0, 0.0
    t, sums = t / looks, sums / looks
    spread, slopes = 0.0, np.zeros(4)
    low, high = math.inf, -math.inf
    for k in range(min(count, _KEPT)):
        if now - seen[k, 0] <= _SPAN:
            off = seen[k, 0] - t
            low, high = min(low, off), max(high, off)
            spread += off * off
            slopes += off * (seen[k, 1:5] - sums)
    if spread <= 0.0:
        return 0.0, 0.0
    slopes /= spread
    speeds = math.hypot(slopes[0], slopes[1]), math.hypot(slopes[2], slopes[3])
    same = slopes[0] * slopes[2] + slopes[1] * slopes[3] > 0.5 * speeds[0] * speeds[1]
    slower = 0 if speeds[0] <= speeds[1] else 2
    speed = min(speeds[0], speeds[1])
    if not same or not _SLOWEST <= speed <= _FASTEST or speed * (high - low) < _TRAVELLED:
        return 0.0, 0.0
    return slopes[slower], slopes[slower + 1]
