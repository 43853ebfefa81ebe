"""Motions of a few legs, driven by odometry alone: a turn, a straight drive, an arc.

Nothing looks out for obstacles: these are the small motions of an iRobot Create 3.

Source: irobot_create_nodes: DriveDistance, DriveArc, RotateAngle, NavigateToPosition, Undock.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from arjuna_core.config import param
from arjuna_core.se2 import SE2, wrap
from arjuna_core.twist import Velocity
from arjuna_nav.behaviors.base import InvalidGoalError
from arjuna_nav.controllers.motion import braking_speed


@dataclass(frozen=True)
class LegsConfig:
    """How fast the legs begin and end."""

    acceleration: float = param(0.9, "How fast speed changes.", unit="m/s^2", minimum=0.01)
    rotational_acceleration: float = param(
        3.0, "How fast the yaw rate changes.", unit="rad/s^2", minimum=0.01
    )
    minimum_speed: float = param(0.02, "Least speed.", unit="m/s", minimum=0.001)
    minimum_yaw_rate: float = param(0.1, "Least yaw rate.", unit="rad/s", minimum=0.001)


@dataclass(frozen=True)
class Leg:
    """One motion of constant curvature.

    Attributes:
        distance: To drive, negative backwards [m].
        angle: To turn by, meanwhile, positive to the left [rad].
        speed: The greatest one [m/s].
        rate: The greatest yaw rate [rad/s].
    """

    distance: float = 0.0
    angle: float = 0.0
    speed: float = 0.3
    rate: float = 1.9

    def __post_init__(self) -> None:
        values = (self.distance, self.angle, self.speed, self.rate)
        if not all(map(math.isfinite, values)) or min(self.speed, self.rate) <= 0.0:
            what = "distance {:g} m, angle {:g} rad, {:g} m/s, {:g} rad/s".format(*values)
            raise InvalidGoalError(f"{what}: all must be finite, the limits above 0")


Step = Callable[[SE2], Leg]
"""Returns a leg by the pose at its start."""


def arc(angle: float, radius: float, direction: int, speed: float) -> Leg:
    """Return a drive along an arc; the angle's sign is that of the turn.

    Raises:
        InvalidGoalError: The radius is none, or the direction is neither 1 nor -1.
    """
    if not radius > 0.0 or direction not in (-1, 1):
        raise InvalidGoalError(f"radius {radius:g} m, direction {direction}; valid: > 0, 1 or -1")
    return Leg(direction * abs(angle) * radius, angle, speed, speed / radius)


def turn_towards(x: float, y: float, rate: float = 1.9) -> Step:
    """Turn to face a position."""
    return lambda pose: Leg(angle=wrap(math.atan2(y - pose.y, x - pose.x) - pose.theta), rate=rate)


def to_position(goal: SE2, heading: bool, speed: float = 0.3, rate: float = 1.9) -> list[Step]:
    """Return the steps to a pose: turn to face it, drive, and turn to its heading if asked for."""
    steps: list[Step] = [
        turn_towards(goal.x, goal.y, rate),
        lambda pose: Leg(pose.distance(goal), speed=speed),
    ]
    if heading:
        steps.append(lambda pose: Leg(angle=wrap(goal.theta - pose.theta), rate=rate))
    return steps


class Legs:
    """Drives legs one after the other.

    Attributes:
        index: The leg that is driven.
        remaining: What is left of it, [rad] if it turns, else [m].
    """

    def __init__(self, steps: Sequence[Step], config: LegsConfig) -> None:
        self._steps, self._config = steps, config
        self.index, self.remaining = -1, 0.0
        self._leg, self._last = Leg(), SE2()
        self._speed = 0.0  # what the leg is driven by, in the unit of what remains

    def tick(self, pose: SE2, period: float) -> Velocity | None:
        """Return what to drive for a period [s]; None at the end."""
        if self.index >= 0:
            turned = abs(wrap(pose.theta - self._last.theta))
            self.remaining -= turned if self._leg.angle else self._last.distance(pose)
        self._last = pose
        while self.remaining <= 0.0:
            if self.index + 1 == len(self._steps):
                return None
            self.index += 1
            self._leg, self._speed = self._steps[self.index](pose), 0.0
            self.remaining = abs(self._leg.angle or self._leg.distance)
        return self._velocity(period)

    def _velocity(self, period: float) -> Velocity:
        leg, config = self._leg, self._config
        if leg.angle:
            most, gain, least = leg.rate, config.rotational_acceleration, config.minimum_yaw_rate
        else:
            most, gain, least = leg.speed, config.acceleration, config.minimum_speed
        wanted = min(most, self._speed + gain * period, braking_speed(self.remaining, gain, 0.0))
        self._speed = max(wanted, min(least, most))
        if not leg.angle:
            return Velocity(math.copysign(self._speed, leg.distance))
        return Velocity(
            self._speed * leg.distance / abs(leg.angle),
            yaw_rate=math.copysign(self._speed, leg.angle),
        )
