"""Velocity commands made drivable: limited in speed and acceleration, zero when they cease."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from arjuna_core.config import duration_param, fixed, param
from arjuna_core.errors import ConfigError
from arjuna_core.twist import STILL, Velocity
from arjuna_nav.controllers.motion import min_turning_radius, steered


@dataclass(frozen=True)
class SmoothingConfig:
    """Parameters of the velocity smoother, by Nav2's names; lists are [x, y, theta].

    Raises:
        ConfigError: A list is not of three, or a limit has the wrong sign.
    """

    smoothing_frequency: float = fixed(
        20.0, "Commands a second where none come.", unit="Hz", minimum=0.1
    )
    scale_velocities: bool = param(False, "Whether to keep the arc where one axis is limited.")
    feedback: str = param(
        "OPEN_LOOP",
        "What is driven now, as commanded or measured.",
        choices=("OPEN_LOOP", "CLOSED_LOOP"),
    )
    max_velocity: tuple[float, ...] = param((0.5, 0.0, 2.5), "Greatest speeds.", unit="m/s, rad/s")
    min_velocity: tuple[float, ...] = param(
        (-0.5, 0.0, -2.5), "Greatest speeds backwards, below 0.", unit="m/s, rad/s"
    )
    max_accel: tuple[float, ...] = param(
        (2.5, 0.0, 3.2), "Greatest accelerations.", unit="m/s^2, rad/s^2"
    )
    max_decel: tuple[float, ...] = param(
        (-2.5, 0.0, -3.2), "Greatest decelerations, below 0.", unit="m/s^2, rad/s^2"
    )
    deadband_velocity: tuple[float, ...] = param(
        (0.0, 0.0, 0.0), "Speeds below which the robot stands.", unit="m/s, rad/s"
    )
    velocity_timeout: float = duration_param(1.0, "How long a command holds.")
    smooth_at_once: bool = param(
        True,
        "Whether a command is smoothed as it comes; else, as Nav2, at smoothing_frequency alone.",
        theirs=False,
    )
    min_turning_radius: float = min_turning_radius(", whose arcs are kept and no tighter")

    def __post_init__(self) -> None:
        for name, sign in (
            ("max_velocity", 1.0),
            ("min_velocity", -1.0),
            ("max_accel", 1.0),
            ("max_decel", -1.0),
            ("deadband_velocity", 1.0),
        ):
            values = getattr(self, name)
            side = "0 or more" if sign > 0.0 else "0 or less"
            if len(values) != 3 or any(sign * value < 0.0 for value in values):
                raise ConfigError(f"'{name}' is {list(values)}; valid: [x, y, theta], each {side}")


class VelocitySmoother:
    """Follows the last command as fast as the limits allow.

    Source: nav2_velocity_smoother, VelocitySmoother::smootherTimer.
    """

    def __init__(self, config: SmoothingConfig) -> None:
        self._config = config
        self._command = STILL
        self._commanded_at = -math.inf
        self._before, self._before_at = STILL, -math.inf
        self._last, self._last_at = STILL, -math.inf
        self._resting = True

    def take(self, command: Velocity, now: float) -> None:
        """Follow a command from now [s] on."""
        self._command, self._commanded_at = command, now

    def tick(self, measured: Velocity, now: float) -> Velocity | None:
        """Return what to drive from now on; None where there is nothing to say.

        Of several commands at one time the last counts alone, as if there were no others.

        Args:
            measured: What the robot drives; used with CLOSED_LOOP.
            now: Time [s].
        """
        config, command = self._config, self._command
        if not self.has_command(now):
            if self._last == STILL or self._resting:
                self._resting = True
                return None
            command = STILL
        self._resting = False
        if now > self._last_at:
            self._before, self._before_at = self._last, self._last_at
        period = 1.0 / config.smoothing_frequency
        period = min(now - self._before_at, period) if config.smooth_at_once else period
        current = measured if config.feedback == "CLOSED_LOOP" else self._before
        self._last, self._last_at = self._step(current, command, period), now
        parts = zip(_values(self._last), self._config.deadband_velocity, strict=True)
        return _velocity([0.0 if abs(value) < least else value for value, least in parts])

    def has_command(self, now: float) -> bool:
        """Return whether the last command holds at a time [s]."""
        return now - self._commanded_at <= self._config.velocity_timeout

    def is_due(self, now: float) -> bool:
        """Return whether a velocity is due although no command came."""
        # 1 us for the rounding of sums of ticks.
        late = now - self._last_at > 1.0 / self._config.smoothing_frequency - 1e-6
        return late or not self._config.smooth_at_once

    def _step(self, current: Velocity, command: Velocity, period: float) -> Velocity:
        """Return the velocity a period [s] nearer to a command."""
        radius = self._config.min_turning_radius
        if radius > 0.0:  # between arcs ahead and back lies a stop: else it would bend tighter
            command = steered(STILL if current.x * command.x < 0.0 else command, radius)
        before = _values(current)
        goals = [
            min(max(value, self._config.min_velocity[axis]), self._config.max_velocity[axis])
            for axis, value in enumerate(_values(command))
        ]
        changes = [
            (goal - now, *self._bounds(now, goal, axis, period))
            for axis, (now, goal) in enumerate(zip(before, goals, strict=True))
        ]
        ratio = 1.0
        if self._config.scale_velocities or radius > 0.0:
            # An axis that cannot be driven holds none of the others back, whatever is measured.
            ratio = min((_allowed(*change) for change in changes if change[2]), default=1.0)
        steps = [min(max(ratio * change, low), high) for change, low, high in changes]
        return _velocity([now + step for now, step in zip(before, steps, strict=True)])

    def _bounds(self, now: float, goal: float, axis: int, period: float) -> tuple[float, float]:
        """Return the least and the greatest change within a period [s]."""
        config = self._config
        faster = abs(goal) >= abs(now) and now * goal >= 0.0
        limit = config.max_accel[axis] if faster else -config.max_decel[axis]
        limit *= period
        return -limit, limit


def _values(velocity: Velocity) -> tuple[float, float, float]:
    return velocity.x, velocity.y, velocity.yaw_rate


def _velocity(values: Sequence[float]) -> Velocity:
    return Velocity(values[0], y=values[1], yaw_rate=values[2])


def _allowed(change: float, low: float, high: float) -> float:
    """Return the part of a change that lies within its bounds."""
    if change > high:
        return high / change
    return low / change if change < low else 1.0
