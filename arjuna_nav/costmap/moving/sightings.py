"""The last scans, which points they saw to be free, and which things stand free in them."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from arjuna_core.arrays import Bools, Floats, Ints
from arjuna_core.se2 import SE2

_BESIDE = 0.04  # from a point, where beams have to pass it as well [m]
_SHARE = 0.25  # of a thing's points
_SAME = 0.05  # that near ranges of one length are to each other [m]


class Sightings(NamedTuple):
    """The last scans in turn, all as long.

    Attributes:
        stamps: `(S,)` [s], -inf where there is none yet.
        sensors: `(S, 3)` the sensor's poses in the fixed frame [m, m, rad].
        ranges: `(S, N)` [m], inf where nothing was hit.
        points: `(S, N, 2)` where beams ended in the fixed frame [m].
        angles: The first beam's bearing and what lies between two, `(2,)` [rad].
        added: How many there have been, `(1,) int64`.
        first: Where beams ended first, on the robot's own parts for ever, `(N,)` [m]; NaN before.
        strayed: How many scans in a row they have not, `(N,) int64`; 3 is for good.
    """

    stamps: Floats
    sensors: Floats
    ranges: Floats
    points: Floats
    angles: Floats
    added: Ints
    first: Floats
    strayed: Ints

    @staticmethod
    def of(scans: int, beams: int, angle_min: float, increment: float) -> Sightings:
        """Return room for scans of so many beams, empty."""
        return Sightings(
            np.full(scans, -math.inf),
            np.zeros((scans, 3)),
            np.full((scans, beams), np.nan),
            np.zeros((scans, beams, 2)),
            np.array([angle_min, increment]),
            np.zeros(1, np.int64),
            np.full(beams, math.nan),
            np.zeros(beams, np.int64),
        )

    def fits(self, beams: int, angle_min: float, increment: float) -> bool:
        """Return whether a scan is like these."""
        return self.ranges.shape[1] == beams and bool((self.angles == (angle_min, increment)).all())

    def begin(self, stamp: float, T_fixed_sensor: SE2) -> int:
        """Take the oldest scan's room for one to be placed, and return its number."""
        oldest = int(self.added[0]) % len(self.stamps)
        self.added[0] += 1
        self.stamps[oldest], self.sensors[oldest] = stamp, T_fixed_sensor.array()
        return oldest


@njit(cache=True)
def fill_in(scans: Sightings, number: int, ranges: Floats, limits: tuple[float, float]) -> None:
    """Fill in a scan's ranges and where its beams end.

    Args:
        scans: The scans.
        number: Of `Sightings.begin`.
        ranges: `(N,)` [m]; inf is no return, NaN invalid.
        limits: The shortest and the longest valid range [m].
    """
    x, y, theta = scans.sensors[number]
    for i in range(len(ranges)):
        length = ranges[i]
        hit = limits[0] <= length < limits[1]
        bearing = theta + scans.angles[0] + scans.angles[1] * i
        scans.points[number, i, 0] = x + length * math.cos(bearing) if hit else math.nan
        scans.points[number, i, 1] = y + length * math.sin(bearing) if hit else math.nan
        if not hit:
            length = math.inf if length >= limits[1] else math.nan  # NaN: too near, or none
        scans.ranges[number, i] = length
        if math.isnan(scans.first[i]):
            scans.first[i] = length
        if scans.strayed[i] < 3 and not math.isnan(length):
            stays = abs(length - scans.first[i]) <= _SAME  # never of what has no end
            scans.strayed[i] = 0 if stays else scans.strayed[i] + 1


@njit(cache=True)
def are_own(scans: Sightings, first: int, last: int) -> bool:
    """Return whether most of these beams have always ended where they do now.

    They do on the robot's own parts, which move with it, and on what stands round one at rest.
    """
    return int((scans.strayed[first : last + 1] == 0).sum()) * 2 > last - first + 1


@njit(cache=True)
def has_moved(
    scans: Sightings, then: int, beams_then: tuple[int, int], now: int, beams_now: tuple[int, int]
) -> bool:
    """Return whether a thing has come where it was free, or left what is free now.

    What stands does neither, though what is seen of it between other things may seem to go.

    Args:
        scans: The scans.
        then: Number of an earlier one.
        beams_then: The first and the last beam that hit the thing then.
        now: Number of the last one.
        beams_now: As then.

    Source: moving things violate space known to be free, as in Wang, Thorpe and Thrun, Online
        simultaneous localization and mapping with detection and tracking of moving objects, ICRA
        2003.
    """
    come = _share(scans, now, beams_now, then)
    return come >= _SHARE or _share(scans, then, beams_then, now) >= _SHARE


@njit(cache=True)
def has_come(scans: Sightings, now: int, since: float, reach: float) -> Bools:
    """Return which beams of a scan end in space that an earlier scan saw free: things have moved.

    That is known at once, its speed only after some scans more.

    Args:
        scans: The scans; each second one is asked.
        now: Number of the last one.
        since: How old an earlier one may be [s].
        reach: Distance up to which things are reported [m].
    """
    count, kept = scans.ranges.shape[1], len(scans.stamps)
    come = np.zeros(count, np.bool_)
    for back in range(1, kept, 2):
        other = (now - back) % kept
        if not 0.0 < scans.stamps[now] - scans.stamps[other] <= since:
            continue
        for beam in range(count):
            if not come[beam] and scans.ranges[now, beam] < reach:
                come[beam] = is_free(scans, other, scans.points[now, beam])
    first = 0
    while first < count:
        last = first
        while last < count and come[last]:
            last += 1
        # One beam alone is noise: three adjacent ones must agree.
        if last - first < 3:
            come[first:last] = False
        first = last + 1
    return come


@njit(cache=True)
def _share(scans: Sightings, number: int, beams: tuple[int, int], other: int) -> float:
    """Return the part of a thing's points that another scan has seen to be free."""
    first, last = beams
    free = 0
    for beam in range(first, last + 1):
        free += is_free(scans, other, scans.points[number, beam])
    return free / (last - first + 1)


@njit(cache=True)
def is_free(scans: Sightings, number: int, point: Floats) -> bool:
    """Return whether the beams of a scan have passed a point and its surroundings."""
    x, y, theta = scans.sensors[number]
    dx, dy = point[0] - x, point[1] - y
    away = math.hypot(dx, dy)
    step, count = scans.angles[1], scans.ranges.shape[1]
    ranges = scans.ranges[number]
    round_it = 2.0 * math.pi / abs(step)
    middle = ((math.atan2(dy, dx) - theta - scans.angles[0]) / step) % round_it
    beside = max(_BESIDE / max(away, _BESIDE) / abs(step), 1.0)
    for beam in range(math.floor(middle - beside), math.ceil(middle + beside) + 1):
        k = beam % round(round_it)
        # A beam that passed the point ends at least 0.1 m behind it.
        if k >= count or not ranges[k] > away + 0.1:  # NaN has seen nothing
            return False
    return True


_GAP = 0.25  # between neighbours of one thing, and to what is behind it [m]


@njit(cache=True)
def free_standing(points: Floats, ranges: Floats, closed: bool) -> Ints:
    """Return the first and last beam of each thing that nothing hides, `(K, 2)`.

    Beside such a thing the beams reach farther: what is seen of it ends where it ends, and not
    where something nearer hides the rest, so that its outer points are its own.

    Args:
        points: Where the beams end, `(N, 2)` [m]; NaN where they do not.
        ranges: Their lengths `(N,)` [m]; inf or NaN where they do not end.
        closed: Whether the last beam is the first's neighbour.
    """
    count = len(ranges)
    found = np.empty((count, 2), np.int64)
    things, first = 0, 0
    while first < count:
        if not math.isfinite(ranges[first]):
            first += 1
            continue
        last = first
        while last + 1 < count and _joined(points, last, last + 1):
            last += 1
        before, after = first - 1, last + 1
        if closed:
            before, after = before % count, after % count
        wide = math.hypot(points[last, 0] - points[first, 0], points[last, 1] - points[first, 1])
        if (
            last - first >= 2
            # What is wider than 1 m is taken for a wall.
            and wide <= 1.0
            and _beyond(ranges, before, first)
            and _beyond(ranges, after, last)
        ):
            found[things, 0], found[things, 1] = first, last
            things += 1
        first = last + 1
    return found[:things]


@njit(cache=True)
def _joined(points: Floats, i: int, j: int) -> bool:
    gap: float = math.hypot(points[i, 0] - points[j, 0], points[i, 1] - points[j, 1])
    return gap <= _GAP


@njit(cache=True)
def _beyond(ranges: Floats, other: int, beam: int) -> bool:
    """Return whether a neighbouring beam reaches behind the end of another."""
    if not 0 <= other < len(ranges):
        return False
    return not ranges[other] < ranges[beam] + 0.5 * _GAP
