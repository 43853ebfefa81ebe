"""Scans taken in: the motion during them, and which of them cannot be used."""

from __future__ import annotations

import enum
import math
from dataclasses import replace

import numpy as np

from arjuna_core.scan import Scan
from arjuna_core.se2 import IDENTITY, SE2
from arjuna_slam.matching.surface import Surface, extract


def motion_within(scan: Scan, delta: SE2, gap: float) -> SE2:
    """Return the motion from a scan's first beam to its last, at the velocity before it.

    `delta` is the motion up to the scan within the time `gap` [s]. The motion is none where the
    scan's time increment or the gap makes no sense.
    """
    sweep = scan.time_increment * (len(scan.ranges) - 1)
    most = 2.0  # gaps between scans; longer sweeps are mistakes of the driver
    if not (gap > 0.0 and abs(sweep) <= most * gap):
        return IDENTITY
    return SE2.exp(sweep / gap * delta.log())


class LastOdometry:
    """The odometry at the last scan: the next one's prior and the motion during it follow."""

    def __init__(self) -> None:
        self.T_odom_base = IDENTITY
        self._stamp: float | None = None

    def advance(self, stamp: float, T_odom_base: SE2) -> None:
        """Take the odometry at a scan's stamp [s] for the last."""
        self._stamp, self.T_odom_base = stamp, T_odom_base

    def gap(self, stamp: float) -> float:
        """Return the time from the last scan to a stamp [s], infinite for the first."""
        return math.inf if self._stamp is None else stamp - self._stamp

    def motion_to(self, T_odom_base: SE2) -> SE2:
        """Return the motion since the last scan."""
        return self.T_odom_base.inverse() @ T_odom_base

    def with_motion(self, scan: Scan, T_odom_base: SE2, motion: SE2 | None = None) -> Scan:
        """Return a scan with the motion during it, so that it can be deskewed.

        `motion` is from its first beam to its last; None for that of the velocity since the last
        scan, where the scan has a time increment.
        """
        if motion is None and scan.time_increment != 0.0 and self._stamp is not None:
            gap = scan.stamp - self._stamp
            motion = motion_within(scan, self.motion_to(T_odom_base), gap)
        return scan if motion is None else replace(scan, motion=motion)


class Skip(enum.Enum):
    """Why a scan is not used."""

    STAMP = "its stamp is no number"
    STALE = "it is no newer than the one before"
    GEOMETRY = "its angles or range limits are not valid"
    EMPTY = "no beam of it is valid"
    LOST = "it lies nowhere on the map"


class ScanFilter:
    """Takes scans in order and counts those that cannot be used.

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
        """Number of scans that were not used."""
        return sum(self.counts.values())

    def skip(self, reason: Skip) -> None:
        """Count a scan that is not used."""
        self.counts[reason] += 1
        self.last = reason

    def take(self, scan: Scan) -> Surface | None:
        """Return what a scan saw, or None if it cannot be used."""
        reason = self._reason(scan)
        if reason is not None:
            self.skip(reason)
            return None
        self._stamp = scan.stamp
        return extract(scan, self._range_max)

    def _reason(self, scan: Scan) -> Skip | None:
        if not math.isfinite(scan.stamp):
            return Skip.STAMP
        if scan.stamp <= self._stamp:
            return Skip.STALE
        numbers = scan.angle_min, scan.angle_increment, scan.range_min
        fan = scan.angle_increment != 0.0 or len(scan.ranges) < 2
        if not (all(map(math.isfinite, numbers)) and fan) or math.isnan(scan.range_max):
            return Skip.GEOMETRY
        if not np.any(scan.ranges > scan.range_min):  # infinite ones say that nothing is near
            return Skip.EMPTY
        return None
