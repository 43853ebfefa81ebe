"""Things that stand free in a scan, by their two outer points."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

_GAP = 0.25  # between neighbours of one thing, and to what is behind it [m]
_LARGEST = 1.0  # across what is told from a wall [m]


@njit(cache=True)
def free_standing(
    points: NDArray[np.float64], ranges: NDArray[np.float64], closed: bool
) -> NDArray[np.int64]:
    """Return the first and last beam of each thing that nothing hides, `(K, 2)`.

    Beside such a thing the beams go on farther: what is seen of it ends where it ends, and not
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
            and wide <= _LARGEST
            and _beyond(ranges, before, first)
            and _beyond(ranges, after, last)
        ):
            found[things, 0], found[things, 1] = first, last
            things += 1
        first = last + 1
    return found[:things]


@njit(cache=True)
def _joined(points: NDArray[np.float64], i: int, j: int) -> bool:
    gap: float = math.hypot(points[i, 0] - points[j, 0], points[i, 1] - points[j, 1])
    return gap <= _GAP


@njit(cache=True)
def _beyond(ranges: NDArray[np.float64], other: int, beam: int) -> bool:
    """Tell whether a neighbouring beam goes on behind the end of another."""
    if not 0 <= other < len(ranges):
        return False
    return not ranges[other] < ranges[beam] + 0.5 * _GAP
