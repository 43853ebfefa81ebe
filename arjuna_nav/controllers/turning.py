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


def braked_turn(
    angle: float, rate: float, rates: tuple[float, float], deceleration: float, latency: float
) -> float:
    """Return the yaw rate that turns by an angle, which a robot feels late [rad/s].

    Args:
        angle: Left to turn [rad].
        rate: As measured; where it leads away by less than the slowest, it counts as noise [rad/s].
        rates: The slowest that turns the wheels, and the fastest [rad/s].
        deceleration: Of braking into the angle [rad/s^2].
        latency: From a command to the motion that is measured [s].

    Source: the braking profile w^2 = 2 a angle, from where the robot will be.
    """
    rest = angle - rate * latency
    away = rest * rate < 0.0 and abs(rate) > rates[0]
    if rest * angle <= 0.0 or away:  # what is under way will do, or is too much
        return 0.0
    fast = min(math.sqrt(2.0 * deceleration * abs(rest)), abs(rest) / max(latency, 0.01))
    return math.copysign(max(rates[0], min(fast, rates[1])), angle)
