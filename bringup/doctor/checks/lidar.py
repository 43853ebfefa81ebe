"""The scans of the lidar."""

from __future__ import annotations

from collections.abc import Iterator

from bringup.doctor.snapshot import Finding, Snapshot

RANK = 9
_SCAN = "sensor_msgs/msg/LaserScan"


def check(snapshot: Snapshot, blind: float = 0.05, near: float = 0.02) -> Iterator[Finding]:
    """Yield scans with too few beams that hit anything, or too many that hit the robot [share]."""
    silent = list(_silent(snapshot))
    yield from silent
    scan = snapshot.robot.scan
    if silent or scan is None:
        return
    if scan.returns < blind:
        what = f"{scan.returns:.0%} of the lidar's beams hit anything"
        yield Finding(what, "the lidar is covered or inside the body, or range_max is short")
    if scan.near > near:
        what = f"{scan.near:.0%} of the lidar's beams hit the robot itself"
        yield Finding(what, "raise the lidar, or its range_min")
    if scan.upside_down and not scan.clockwise:
        what = f"{scan.frame} is upside down and its bearings rise: left and right are swapped"
        yield Finding(what, "mend the lidar's rpy in the URDF, or its driver's direction")


def _silent(snapshot: Snapshot) -> Iterator[Finding]:
    published = {end.topic for end in snapshot.endpoints if end.publishes and end.type == _SCAN}
    waiting: dict[str, set[str]] = {}
    for end in snapshot.endpoints:
        if not end.publishes and end.type == _SCAN and not snapshot.publishers(end.topic):
            waiting.setdefault(end.topic, set()).add(end.node)
    remedy = "start the robot; --check FILE says what is understood of its lidar"
    if published:
        others = ", ".join(sorted(published))
        remedy = f"scans come on {others}: --scan-topic TOPIC, or a remapping"
    for topic, nodes in sorted(waiting.items()):
        what = f"nobody publishes {topic}, and {', '.join(sorted(nodes))} wait for it"
        yield Finding(what, remedy)
