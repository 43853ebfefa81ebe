"""The planar velocity of a robot's base."""

from __future__ import annotations

import math
from dataclasses import KW_ONLY, dataclass


@dataclass(frozen=True)
class Velocity:
    """A planar twist in the frame of the robot's base.

    Attributes:
        x: Forward speed [m/s].
        y: Speed to the left [m/s].
        yaw_rate: Counter-clockwise [rad/s].
    """

    x: float = 0.0
    _: KW_ONLY
    y: float = 0.0
    yaw_rate: float = 0.0

    @property
    def speed(self) -> float:
        """Speed over ground, whatever the direction [m/s]."""
        return math.hypot(self.x, self.y)

    @property
    def is_finite(self) -> bool:
        """True where all parts are finite."""
        return all(map(math.isfinite, (self.x, self.y, self.yaw_rate)))

    def scaled(self, part: float) -> Velocity:
        """Return a part of it; the course stays."""
        return Velocity(self.x * part, y=self.y * part, yaw_rate=self.yaw_rate * part)


STILL = Velocity()
