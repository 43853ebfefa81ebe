"""Parameters that keep a robot from harm elsewhere and have no effect here."""

from __future__ import annotations

from bringup.doctor.finding import Finding
from bringup.doctor.snapshot import Snapshot

_CURE = "keep the robot out of harm's reach by other means: docs/coming-from-ros2.md"


def check(snapshot: Snapshot) -> list[Finding]:
    """Return the names of parameter files that the robot's processes remark on."""
    return [Finding(remark, _CURE) for remark in snapshot.robot.remarks]
