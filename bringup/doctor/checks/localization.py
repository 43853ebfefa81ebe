"""Whether the robot is where it believes to be."""

from __future__ import annotations

from bringup.doctor.finding import Finding
from bringup.doctor.snapshot import Snapshot

_FIT = 0.6  # of the scan's hits; a robot that is lost has about a third by chance
_UNSURE = 0.5  # [m]
_KNOWN = 0.01  # share of the map below which it is empty
_CURE = "python -m bringup initial-pose X Y YAW, or another --map"


def check(snapshot: Snapshot) -> list[Finding]:
    """Return what speaks against map or pose."""
    robot = snapshot.robot
    found = []
    if robot.map_known is not None and robot.map_known < _KNOWN:
        what = f"{robot.map_known:.0%} of the map is known"
        found.append(Finding(what, "drive about (teleop, explore); scans and odom must come"))
    if snapshot.runs("amcl", "bt_navigator") and robot.map_known is None:
        cure = "python -m bringup nav --map FILE, or --slam; a viewer's fixed frame is map"
        found.append(Finding("no /map came", cure))
    fit = None if robot.scan is None else robot.scan.on_walls
    mapping = snapshot.runs("slam_toolbox")  # its map lacks walls yet, and is made of the scans
    if fit is not None and fit < _FIT and not mapping:
        what = f"{fit:.0%} of the scan's hits lie on walls of the map"
        found.append(Finding(what, _CURE))
    if robot.deviation is not None and robot.deviation > _UNSURE:
        what = f"AMCL knows its position to {robot.deviation:.1f} m"
        found.append(Finding(what, _CURE))
    return found
