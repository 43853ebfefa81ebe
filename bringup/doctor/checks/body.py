"""The robot's body."""

from __future__ import annotations

from collections.abc import Iterator

from bringup.doctor.snapshot import Finding, Snapshot

RANK = 12


def check(snapshot: Snapshot, lowest: float = -0.03) -> Iterator[Finding]:
    """Yield faults of the body; its base is to be no lower than a height [m]."""
    height = snapshot.robot.height
    if height is not None and height < lowest:
        remedy = "wheels need a collision shape and mass; python -m bringup sim --check FILE"
        yield Finding(f"the robot sinks into the ground ({height:.2f} m)", remedy)
