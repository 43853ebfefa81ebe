"""What the lidar sees."""

from __future__ import annotations

from bringup.doctor.finding import Finding
from bringup.doctor.snapshot import Snapshot

_SCAN = "sensor_msgs/msg/LaserScan"
_NEAR = 0.02  # share of the beams
_BLIND = 0.05  # share of the beams below which it sees nothing


def check(snapshot: Snapshot) -> list[Finding]:
    """Return what is wrong with the scans."""
    scan = snapshot.robot.scan
    silent = _silent(snapshot)
    if silent:
        return silent
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


def _silent(snapshot: Snapshot) -> list[Finding]:
    """Name the topics of scans on which somebody listens and nobody publishes."""
    published = {end.topic for end in snapshot.endpoints if end.publishes and end.type == _SCAN}
    waiting: dict[str, set[str]] = {}
    for end in snapshot.endpoints:
        if not end.publishes and end.type == _SCAN and not snapshot.publishers(end.topic):
            waiting.setdefault(end.topic, set()).add(end.node)
    instead = f"scans come on {', '.join(sorted(published))}: --scan-topic TOPIC, or a remapping"
    none = "start the robot; --check FILE says what is understood of its lidar"
    return [
        Finding(
            f"nobody publishes {topic}, and {', '.join(sorted(nodes))} wait for it",
            instead if published else none,
        )
        for topic, nodes in sorted(waiting.items())
    ]
