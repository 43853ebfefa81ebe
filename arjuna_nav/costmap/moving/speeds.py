"""Speeds of things that were seen several times."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from arjuna_core.arrays import Floats
from arjuna_nav.costmap.moving.sightings import Sightings, has_moved

KEPT = 8  # sightings of a track
_SIGHTINGS = 4  # that make a speed
SPAN = 0.9  # that sightings count before a thing is known to move [s]
_SLOWEST, _FASTEST = 0.2, 3.0  # of what is taken for moving [m/s]


@njit(cache=True)
def latest(count: int) -> int:
    """Return the row of a track's last sighting, of so many."""
    return (count - 1) % KEPT


@njit(cache=True)
def go(seen: Floats, count: int, going: Floats, scans: Sightings, number: int) -> None:
    """Bring a velocity up to date; who turns about seems to stand meanwhile, and yet moves.

    Args:
        seen: The track's sightings `(KEPT, 7)`: time [s], its first point, its last [m], the beams.
        count: How many there have been.
        going: Its last known velocity, and when; its greatest speed of late, and when; `(5,)`
            [m/s, m/s, s, m/s, s]; changed in place.
        scans: The last scans.
        number: Which of them is the last.
    """
    moves, now = bool(going[:2].any()), scans.stamps[number]
    vx, vy = _velocity(seen, count, moves, now)
    if (vx != 0.0 or vy != 0.0) and (moves or _is_sure(seen, count, scans, number)):
        going[0], going[1], going[2] = vx, vy, now
        speed = math.hypot(vx, vy)
        # Kept for 0.8 s: who turns about is slow only in between.
        if speed >= going[3] or now - going[4] > 0.8:
            going[3], going[4] = speed, now
    # After half a second without a speed, a moved thing counts as standing.
    elif now - going[2] > 0.5 and _slopes(seen, count, now, SPAN)[0] >= _SIGHTINGS:
        going[:2] = 0.0


@njit(cache=True)
def _is_sure(seen: Floats, count: int, scans: Sightings, number: int) -> bool:
    """Return whether a track moves: the first of its kept scans saw its present position free."""
    last, now = seen[latest(count)], scans.stamps[number]
    since, first, then = now, -1, np.int64(-1)  # a plain -1 has `has_moved` compiled twice
    for k in range(min(count, KEPT)):
        if now - SPAN <= seen[k, 0] < since:
            for other in range(len(scans.stamps)):
                if scans.stamps[other] == seen[k, 0]:
                    since, first, then = seen[k, 0], k, other
    if first < 0:
        return False
    before = int(seen[first, 5]), int(seen[first, 6])
    return bool(has_moved(scans, then, before, number, (int(last[5]), int(last[6]))))


@njit(cache=True)
def _velocity(seen: Floats, count: int, moves: bool, now: float) -> tuple[float, float]:
    """Return the velocity of what is known to move, else of the slower outer point if that is sure.

    It is 0 for what stands.
    """
    # A person who walks may turn within half a second.
    span = 0.5 if moves else SPAN
    sightings, duration, slopes = _slopes(seen, count, now, span)
    if moves and sightings >= 2:
        vx, vy = 0.5 * (slopes[0] + slopes[2]), 0.5 * (slopes[1] + slopes[3])
        return (vx, vy) if _SLOWEST <= math.hypot(vx, vy) <= _FASTEST else (0.0, 0.0)
    if sightings < _SIGHTINGS:
        return 0.0, 0.0
    speeds = math.hypot(slopes[0], slopes[1]), math.hypot(slopes[2], slopes[3])
    same = slopes[0] * slopes[2] + slopes[1] * slopes[3] > 0.5 * speeds[0] * speeds[1]
    slower = 0 if speeds[0] <= speeds[1] else 2
    speed = min(speeds[0], speeds[1])
    # Both outer points must have travelled 0.15 m.
    if not same or not _SLOWEST <= speed <= _FASTEST or speed * duration < 0.15:
        return 0.0, 0.0
    return slopes[slower], slopes[slower + 1]


@njit(cache=True)
def _slopes(seen: Floats, count: int, now: float, span: float) -> tuple[int, float, Floats]:
    """Return how many sightings of the last while there are, over how long, and their slopes."""
    sightings, t, sums = 0, 0.0, np.zeros(4)
    for k in range(min(count, KEPT)):
        if now - seen[k, 0] <= span:
            sightings += 1
            t += seen[k, 0]
            sums += seen[k, 1:5]
    t, sums = t / max(sightings, 1), sums / max(sightings, 1)
    spread, slopes = 0.0, np.zeros(4)
    low, high = math.inf, -math.inf
    for k in range(min(count, KEPT)):
        if now - seen[k, 0] <= span:
            off = seen[k, 0] - t
            low, high = min(low, off), max(high, off)
            spread += off * off
            slopes += off * (seen[k, 1:5] - sums)
    if spread <= 0.0:
        return 0, 0.0, slopes
    return sightings, high - low, slopes / spread
