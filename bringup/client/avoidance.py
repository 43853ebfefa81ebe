"""Obstacle avoidance by what the lidar sees now: forward while free, else towards more room."""

from __future__ import annotations

import math
from dataclasses import dataclass

from arjuna_core.scan import Scan

_FRONT, _SIDE = math.radians(15.0), math.radians(90.0)


@dataclass(frozen=True)
class Decision:
    """The decision that follows from a scan.

    Attributes:
        word: FORWARD, TURN LEFT or TURN RIGHT.
        v: Forward speed [m/s].
        w: Turn rate [rad/s].
        front: Nearest thing within 15 degrees of straight ahead [m].
        left: Nearest from there to 90 degrees left [m].
        right: Nearest from there to 90 degrees right [m].
    """

    word: str
    v: float
    w: float
    front: float
    left: float
    right: float

    def __str__(self) -> str:
        seen = f"Front: {self.front:.2f}m Left: {self.left:.2f}m Right: {self.right:.2f}m"
        return f"[{self.word:<8}] {seen}"


def decide(scan: Scan, distance: float, speed: float, turn: float, clear: float = 10.0) -> Decision:
    """Return what to do at a scan: drive [m/s] unless something is nearer ahead [m], else turn.

    Where nothing is seen it is clear for so far [m].
    """
    middle, width = (_FRONT + _SIDE) / 2.0, _SIDE - _FRONT
    sectors = (0.0, 2.0 * _FRONT), (middle, width), (-middle, width)
    front, left, right = (min(scan.nearest(*sector), clear) for sector in sectors)
    if front > distance:
        return Decision("FORWARD", speed, 0.0, front, left, right)
    if left >= right:
        return Decision("TURN LEFT", 0.0, turn, front, left, right)
    return Decision("TURN RIGHT", 0.0, -turn, front, left, right)
