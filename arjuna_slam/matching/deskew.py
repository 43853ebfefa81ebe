"""How a robot moves while it scans."""

from __future__ import annotations

from dataclasses import replace

from arjuna_core.scan import Scan
from arjuna_core.se2 import IDENTITY, SE2

_SCANS_MAX = 2.0  # sweeps longer than this many gaps between scans are mistakes of the driver


def motion_within(scan: Scan, delta: SE2, gap: float) -> SE2:
    """Return the motion from a scan's first beam to its last, at the velocity before it.

    Args:
        scan: The scan.
        delta: Motion up to the scan since some time before.
        gap: That time [s].

    Returns:
        The motion; none where the scan's time increment or the gap makes no sense.
    """
    sweep = scan.time_increment * (len(scan.ranges) - 1)
    if not (gap > 0.0 and abs(sweep) <= _SCANS_MAX * gap):
        return IDENTITY
    return SE2.exp(sweep / gap * delta.log())


class Deskewer:
    """Gives each scan the motion during it, at the velocity since the scan before."""

    def __init__(self) -> None:
        self._last: tuple[float, SE2] | None = None  # stamp [s] and odometry

    def deskewed(self, scan: Scan, T_odom_base: SE2) -> Scan:
        """Return the scan with its motion; as it is where no scan came before.

        Args:
            scan: The scan.
            T_odom_base: Odometry at its stamp.
        """
        before, self._last = self._last, (scan.stamp, T_odom_base)
        if scan.time_increment == 0.0 or before is None:
            return scan
        delta = before[1].inverse() @ T_odom_base
        return replace(scan, motion=motion_within(scan, delta, scan.stamp - before[0]))
