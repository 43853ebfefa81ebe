"""The robot's belief about its pose."""

from __future__ import annotations

from collections.abc import Iterator

from bringup.doctor.snapshot import Finding, Snapshot

RANK = 10
_REMEDY = "python -m bringup initial-pose X Y YAW, or another --map"


def check(
    snapshot: Snapshot, known: float = 0.01, on_walls: float = 0.6, deviation: float = 0.5
) -> Iterator[Finding]:
    """Yield facts that contradict the map or the pose.

    Args:
        known: Share of a map's cells below which it is empty.
        on_walls: Least share of the scan's hits; a lost robot has about a third by chance.
        deviation: Greatest standard deviation of the position [m].
    """
    robot = snapshot.robot
    if robot.map_known is not None and robot.map_known < known:
        what = f"{robot.map_known:.0%} of the map is known"
        yield Finding(what, "drive about (teleop, explore); scans and odom must come")
    if snapshot.runs("amcl", "bt_navigator") and robot.map_known is None:
        remedy = "python -m bringup nav --map FILE, or --slam; a viewer's fixed frame is map"
        yield Finding("no /map came", remedy)
    fit = None if robot.scan is None else robot.scan.on_walls
    mapping = snapshot.runs("slam_toolbox")  # its map lacks walls yet, and is made of the scans
    if fit is not None and fit < on_walls and not mapping:
        yield Finding(f"{fit:.0%} of the scan's hits lie on walls of the map", _REMEDY)
    if robot.deviation is not None and robot.deviation > deviation:
        yield Finding(f"AMCL knows its position to {robot.deviation:.1f} m", _REMEDY)
