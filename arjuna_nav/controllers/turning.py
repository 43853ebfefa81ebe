"""Turning on the spot: how fast, so that it comes to rest where it is to."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Turning:
    """Limits of a turn on the spot.

    Attributes:
        rate: Greatest yaw rate [rad/s].
        acceleration: Greatest change of the yaw rate [rad/s^2].
        period: Time between two commands [s].
        gain: Yaw rate per angle left [1/s].
        rate_min: Yaw rate below which the wheels stick [rad/s].
        settled: Angle left below which the wheels may stick [rad].
    """

    rate: float
    acceleration: float
    period: float
    gain: float = 1.5
    rate_min: float = 0.1
    settled: float = 0.05

    def towards(self, angle: float, last: float) -> float:
        """Return the yaw rate that turns by an angle and comes to rest there [rad/s].

        Args:
            angle: Left to turn [rad].
            last: Yaw rate commanded last [rad/s].
        """
        brake = math.sqrt(self.acceleration * abs(angle))  # half the limit: none overshoots
        rate = min(self.rate, brake, self.gain * abs(angle))
        if abs(angle) > self.settled:
            rate = max(rate, min(self.rate_min, self.rate))
        change = self.acceleration * self.period
        return min(max(math.copysign(rate, angle), last - change), last + change)
