"""Parameters that keep a robot from harm elsewhere and have no effect here."""

from __future__ import annotations

from collections.abc import Iterator

from bringup.doctor.snapshot import Finding, Snapshot

RANK = 13


def check(snapshot: Snapshot) -> Iterator[Finding]:
    """Yield the remarks of the robot's processes on their parameter files."""
    for remark in snapshot.robot.remarks:
        remedy = "keep the robot out of harm's reach by other means: docs/coming-from-ros2.md"
        yield Finding(remark, remedy)
