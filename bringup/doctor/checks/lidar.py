"""What the lidar sees."""

from __future__ import annotations

from bringup.doctor.finding import Finding
from bringup.doctor.snapshot import Snapshot

_NEAR = 0.02  # share of the beams
_BLIND = 0.05  # share of the beams below which it sees nothing


def check(snapshot: Snapshot) -> list[Finding]:
    """Return what is wrong with the scans."""
    scan = snapshot.robot.scan
    listeners = sorted({end.node for end in snapshot.subscribers("/scan")})
    if listeners and not snapshot.publishers("/scan"):
        what = f"nobody publishes /scan, and {', '.join(listeners)} wait for it"
        return [Finding(what, "start the robot; --check FILE says what is understood of its lidar")]
    if scan is None:
        return []
    found = []
    if scan.returns < _BLIND:
        what = f"{scan.returns:.0%} of the lidar's beams hit anything"
        found.append(
            Finding(what, "the lidar is covered or inside the body, or range_max is short")
        )
    if scan.near > _NEAR:
        what = f"{scan.near:.0%} of the lidar's beams hit the robot itself"
        found.append(Finding(what, "raise the lidar, or its range_min"))
    if scan.upside_down and not scan.clockwise:
        what = f"{scan.frame} hangs upside down and its bearings rise: left and right are swapped"
        found.append(Finding(what, "mend the lidar's rpy in the URDF, or its driver's direction"))
    return found
