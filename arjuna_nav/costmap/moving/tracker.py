"""Tracking of the things in scans that move."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit

from arjuna_core.arrays import Bools, Floats, Ints
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_nav.costmap.moving.sightings import (
    Sightings,
    are_own,
    fill_in,
    free_standing,
    has_come,
    is_free,
)
from arjuna_nav.costmap.moving.speeds import KEPT, SPAN, go, latest

REACH = 3.0  # from where somebody may be at a robot before it has stopped [m]
HIDDEN = 1.5  # for which what moves is expected to move on where it is hidden [s]
_LOST = 0.5  # after which a track ends [s]
_MOST = 128  # tracks
_RING = 8  # points that stand for what moves and is hidden


@dataclass(frozen=True, eq=False)
class Moving:
    """The parts of a scan that move.

    Attributes:
        points: Where its beams end, in the fixed frame, `(N, 2)` [m]; and round what moves and
            is hidden.
        velocities: Of each, `(N, 2)` [m/s]; 0 for what stands or is not known to move.
        paces: The greatest speed of late of what each is of, `(N,)` [m/s]; it is kept for a
            while after a stop.
        come: Which are where nothing was just before, though their velocity is not known, `(N,)`.
        things: Of each thing that moves the middle, the velocity and the radius, `(K, 5)`
            [m, m, m/s, m/s, m].
        stamp: Of the scan [s].
    """

    points: Floats
    velocities: Floats
    paces: Floats
    come: Bools
    things: Floats
    stamp: float

    @property
    def speeds(self) -> Floats:
        """Speed at which each point may approach, wherever it turns, `(N,)` [m/s]."""
        # A thing that has moved, at an unknown speed, is taken to move at 1 m/s.
        return np.where(self.come, 1.0, self.paces)

    @staticmethod
    def nothing() -> Moving:
        """Return what is known before any scan."""
        none = np.zeros((0, 2))
        return Moving(none, none, np.zeros(0), np.zeros(0, np.bool_), np.zeros((0, 5)), -math.inf)


class Tracker:
    """Follows the free-standing things of scans from one to the next.

    To be known to move, a thing moves as slowly as the slower of its two outer points: the outer
    points of what stands stay where they are, while its middle seems to wander as the robot passes
    it. And it has come where an earlier scan saw nothing, or left what is free now: what stands
    among much else comes in sight here and goes out of it there, as if it went. From then on its
    middle counts, for the outer points of what comes near part from each other; and where something
    hides a part of it, what is seen about where it has got to is its.

    Args:
        reach: Distance up to which it reports what has come [m].

    Source: nearest-neighbour tracking with a constant velocity (Bar-Shalom and Fortmann, Tracking
        and data association, 1988); speeds by least squares over the last sightings.
    """

    def __init__(self, reach: float = 0.0) -> None:
        self._reach = reach
        self._seen = np.zeros((_MOST, KEPT, 7))  # t, x, y of the first, x, y of the last, beams
        self._counts = np.zeros(_MOST, np.int64)  # sightings; 0 for a free row
        self._going = np.zeros((_MOST, 5))  # last velocity, and when; greatest speed, and when
        self._scans = Sightings.of(KEPT, 0, 0.0, 1.0)

    def update(self, scan: Scan, T_fixed_base: SE2) -> Moving:
        """Take the next scan, and return what of it moves."""
        # [rad] A scan of one beam says 0: as wide as a beam is what it sees of others' ends.
        count, layout = len(scan.ranges), (scan.angle_min, scan.angle_increment or 1e-3)
        if not self._scans.fits(count, *layout):
            self._scans = Sightings.of(KEPT, count, *layout)
        number = self._scans.begin(scan.stamp, T_fixed_base @ scan.T_base_sensor)
        round_it = abs(scan.angle_increment) * count > 2.0 * math.pi - 0.05
        points, motions, come, things, hidden, paces = _watch(
            scan.ranges,
            (scan.range_min, scan.range_max),
            round_it,
            self._reach,
            (self._seen, self._counts, self._going),
            self._scans,
            number,
        )
        if len(hidden):
            points = np.vstack((points, _round(hidden)))
            rings = np.column_stack((hidden[:, 2:4], paces)).repeat(_RING, axis=0)
            motions = np.vstack((motions, rings))
            come = np.append(come, np.zeros(len(rings), np.bool_))
        return Moving(points, motions[:, :2], motions[:, 2], come, things, scan.stamp)


@njit(cache=True)
def _watch(
    ranges: Floats,
    limits: tuple[float, float],
    closed: bool,
    reach: float,
    tracks: tuple[Floats, Ints, Floats],
    scans: Sightings,
    number: int,
) -> tuple[Floats, Floats, Bools, Floats, Floats, Floats]:
    """Return where beams end, how that moves, what has come, what moves, of it the hidden, paces.

    All of a scan's work in one kernel; `bench costmap` times it.
    """
    fill_in(scans, number, ranges, limits)
    found = free_standing(scans.points[number], scans.ranges[number], closed)
    motions = np.zeros((len(ranges), 3))  # velocity and greatest speed
    seen, counts, going = tracks
    _follow(seen, counts, going, scans, number, found, motions)
    things, hidden, paces = _predicted(seen, counts, going, scans, number, motions)
    come, ends, kept = has_come(scans, number, SPAN, reach), scans.points[number].copy(), 0
    for i in range(len(ranges)):
        if math.isfinite(scans.ranges[number, i]):
            stands = motions[i, 0] == 0.0 and motions[i, 1] == 0.0 and motions[i, 2] == 0.0
            for k in range(2):
                ends[kept, k] = ends[i, k]
            for k in range(3):
                motions[kept, k] = motions[i, k]
            come[kept] = come[i] and stands and not are_own(scans, i, i)
            kept += 1
    return ends[:kept], motions[:kept], come[:kept], things, things[hidden], paces[hidden]


@njit(cache=True)
def _follow(
    seen: Floats,
    counts: Ints,
    going: Floats,
    scans: Sightings,
    number: int,
    found: Ints,
    motions: Floats,
) -> None:
    """Give each thing to the nearest track or a new one, and fill the motions of its beams."""
    now, points = scans.stamps[number], scans.points[number]
    for track in range(_MOST):
        lost = HIDDEN if going[track, :2].any() else _LOST
        if counts[track] and not 0.0 <= now - seen[track, latest(counts[track]), 0] <= lost:
            counts[track] = 0
    taken = np.zeros(_MOST, np.bool_)
    for k in range(len(found)):
        first, last = found[k]
        if are_own(scans, first, last):
            continue
        track = _nearest(seen, counts, going, taken, points[first], points[last], now)
        if track < 0:
            continue
        taken[track] = True
        if not counts[track]:
            going[track] = 0.0
        row = seen[track, counts[track] % KEPT]
        row[0], row[1:3], row[3:5], row[5], row[6] = now, points[first], points[last], first, last
        counts[track] += 1
        go(seen[track], counts[track], going[track], scans, number)
        motions[first : last + 1, :2] = going[track, :2]
        # Who has stopped may go on at the same pace; after 3 s it is not expected any more.
        if now - going[track, 2] <= 3.0:
            motions[first : last + 1, 2] = going[track, 3]


@njit(cache=True)
def _predicted(
    seen: Floats, counts: Ints, going: Floats, scans: Sightings, number: int, motions: Floats
) -> tuple[Floats, Bools, Floats]:
    """Return what moves, whether it is hidden, its pace; fill the motions of beams that yet hit it.

    A thing that this scan does not show free-standing moves on as before.
    """
    now, points = scans.stamps[number], scans.points[number]
    things, hidden, paces = np.empty((_MOST, 5)), np.zeros(_MOST, np.bool_), np.empty(_MOST)
    count = 0
    for track in range(_MOST):
        if not counts[track] or not going[track, :2].any():
            continue
        row = seen[track, latest(counts[track])]
        ahead = now - row[0]
        vx, vy = going[track, :2]
        x, y = 0.5 * (row[1] + row[3]) + vx * ahead, 0.5 * (row[2] + row[4]) + vy * ahead
        radius = 0.5 * math.hypot(row[3] - row[1], row[4] - row[2])
        things[count], paces[count] = (x, y, vx, vy, radius), going[track, 3]
        hidden[count] = ahead > 0.0 and not is_free(scans, number, things[count, :2])
        count += 1
        for i in range(len(points) if ahead > 0.0 else 0):
            stands = motions[i, 0] == 0.0 and motions[i, 1] == 0.0
            # Points up to 0.1 m beyond its outer points are the thing's own.
            if stands and math.hypot(points[i, 0] - x, points[i, 1] - y) <= radius + 0.1:
                motions[i, 0], motions[i, 1], motions[i, 2] = vx, vy, going[track, 3]
    return things[:count], hidden[:count], paces[:count]


def _round(things: Floats) -> Floats:
    """Return points round each of some things, `(N, 2)` [m]."""
    turns = np.arange(_RING) * (2.0 * math.pi / _RING)
    ring = np.column_stack((np.cos(turns), np.sin(turns)))
    points: Floats = things[:, None, :2] + things[:, None, 4:] * ring
    return points.reshape(-1, 2)


@njit(cache=True)
def _nearest(
    seen: Floats, counts: Ints, going: Floats, taken: Bools, first: Floats, last: Floats, now: float
) -> int:
    """Return the track predicted to be nearest, a free one where none is; -1 for neither."""
    # A sighting belongs to the nearest track expected within 0.4 m.
    best, least, empty = -1, 0.4, -1
    x, y = 0.5 * (first[0] + last[0]), 0.5 * (first[1] + last[1])
    for track in range(_MOST):
        if taken[track]:
            continue
        if not counts[track]:
            empty = track if empty < 0 else empty
            continue
        row = seen[track, latest(counts[track])]
        vx, vy = going[track, :2]
        ahead = now - row[0]
        gap = math.hypot(
            0.5 * (row[1] + row[3]) + vx * ahead - x, 0.5 * (row[2] + row[4]) + vy * ahead - y
        )
        if gap < least:
            best, least = track, gap
    return best if best >= 0 else empty
