"""The robot's body."""

from __future__ import annotations

from bringup.doctor.finding import Finding
from bringup.doctor.snapshot import Snapshot

_SUNK = -0.03  # [m]


def check(snapshot: Snapshot) -> list[Finding]:
    """Return what is wrong with the body."""
    height = snapshot.robot.height
    if height is None or height >= _SUNK:
        return []
    cure = "wheels need a collision shape and mass; python -m bringup sim --check FILE"
    return [Finding(f"the robot sinks into the ground ({height:.2f} m)", cure)]
