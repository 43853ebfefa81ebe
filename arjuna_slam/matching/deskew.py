"""How a robot moves while it scans."""

from __future__ import annotations

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
