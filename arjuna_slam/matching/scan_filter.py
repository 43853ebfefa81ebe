"""Which scans can be used, and how many could not, by reason."""

from __future__ import annotations

import enum
import math

from arjuna_core.scan import Scan
from arjuna_slam.matching.surface import Surface, extract


class Skip(enum.Enum):
    """Why a scan is not used."""

    STAMP = "its stamp is no number"
    STALE = "it is no newer than the one before"
    GEOMETRY = "its angles or range limits are not valid"
    EMPTY = "it has nothing in range"
    LOST = "it lies nowhere on the map"


class ScanFilter:
    """Takes scans in order and counts those that cannot be used.

    Args:
        range_max: Longest range used [m].

    Attributes:
        counts: How many scans were not used, by reason.
        last: Why the last unused scan was not; None before the first.
    """

    def __init__(self, range_max: float) -> None:
        self._range_max = range_max
        self._stamp = -math.inf
        self.counts = dict.fromkeys(Skip, 0)
        self.last: Skip | None = None

    @property
    def skipped(self) -> int:
        """How many scans were not used."""
        return sum(self.counts.values())

    def skip(self, reason: Skip) -> None:
        """Count a scan that is not used."""
        self.counts[reason] += 1
        self.last = reason

    def take(self, scan: Scan) -> Surface | None:
        """Return what a scan saw, or None if it cannot be used."""
        reason = self._reason(scan)
        surface = extract(scan, self._range_max) if reason is None else None
        if surface is not None and len(surface) == 0:
            reason = Skip.EMPTY
        if reason is not None:
            self.skip(reason)
            return None
        self._stamp = scan.stamp
        return surface

    def _reason(self, scan: Scan) -> Skip | None:
        if not math.isfinite(scan.stamp):
            return Skip.STAMP
        if scan.stamp <= self._stamp:
            return Skip.STALE
        numbers = scan.angle_min, scan.angle_increment, scan.range_min
        fan = scan.angle_increment != 0.0 or len(scan.ranges) < 2
        if not (all(map(math.isfinite, numbers)) and fan) or math.isnan(scan.range_max):
            return Skip.GEOMETRY
        return None
