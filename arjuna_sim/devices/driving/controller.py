"""The base's controller: it holds commands within limits, and ramps towards them."""

from __future__ import annotations

import math

from arjuna_core.errors import ArjunaError
from arjuna_core.twist import Velocity
from arjuna_sim.devices.driving.hold import CommandHold
from arjuna_sim.devices.driving.limits import Bound, Limits

_TOLERANCE = 1e-9
_STILL = Velocity()


class CommandError(ArjunaError, ValueError):
    """A velocity command is not finite."""


class Drive:
    """The base's controller: holds the last command and ramps towards it.

    Args:
        limits: Greatest speeds and accelerations, and how long commands hold.
    """

    def __init__(self, limits: Limits) -> None:
        self.limits = limits
        self._hold = CommandHold()
        self._cuts: dict[str, str] = {}
        self._said: set[str] = set()
        self.reset()

    def reset(self) -> None:
        """Stand still, with no command."""
        self._target = Velocity()
        self._current = Velocity()
        self._hold.reset()

    def command(self, velocity: Velocity, now: float) -> None:
        """Take a command at time `now` [s]; it is cut to the limits.

        Raises:
            CommandError: It is not finite.
        """
        if not velocity.is_finite:
            raise CommandError(f"{velocity} must be finite")
        limits = self.limits
        back, turn = limits.reverse, limits.turn
        self._target = Velocity(
            self._cut(velocity.x, limits.forward if velocity.x > 0.0 else back),
            y=self._cut(velocity.y, limits.forward),
            yaw_rate=self._cut(velocity.yaw_rate, turn),
        )
        self._hold.take(now, limits.hold)

    def _cut(self, speed: float, bound: Bound) -> float:
        """Return a speed within a bound; the first that each bound cuts is kept."""
        if abs(speed) <= bound.value:
            return speed
        self._cuts.setdefault(f"{bound.source} {bound.unit}", bound.text(speed))
        return math.copysign(bound.value, speed)

    def take_cuts(self) -> tuple[str, ...]:
        """Return which bounds have cut commands since the last call, each once."""
        new = self._cuts.keys() - self._said
        self._said |= new
        return tuple(text for key, text in self._cuts.items() if key in new)

    def velocity(self, now: float, dt: float) -> Velocity:
        """Return the velocity to hold from `now` for `dt` [s]."""
        limits = self.limits
        expired = now >= self._hold.ends(self._braking()) - _TOLERANCE
        target = _STILL if expired else self._target
        self._current = Velocity(
            _ramp(self._current.x, target.x, limits.linear_acceleration * dt),
            y=_ramp(self._current.y, target.y, limits.linear_acceleration * dt),
            yaw_rate=_ramp(
                self._current.yaw_rate, target.yaw_rate, limits.angular_acceleration * dt
            ),
        )
        return self._current

    def _braking(self) -> float:
        """Return how long the robot brakes to stand [s]."""
        limits, now = self.limits, self._current
        speed = max(abs(now.x), abs(now.y)) / limits.linear_acceleration
        return max(speed, abs(now.yaw_rate) / limits.angular_acceleration)


def _ramp(current: float, target: float, step: float) -> float:
    """Move towards a target by at most a step."""
    return current + max(-step, min(step, target - current))
