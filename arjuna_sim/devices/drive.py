"""From a velocity command to wheel speeds: limits, time-out and skid-steer kinematics."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from arjuna_core.config import param
from arjuna_core.errors import ArjunaError
from arjuna_sim.model.settings import DriveSettings

_TOLERANCE = 1e-9
_BRAKES = 0.4  # of the time-out, at most: a client at 4 Hz is not braked between commands


class CommandError(ArjunaError, ValueError):
    """A velocity command is no pair of finite numbers."""


@dataclass(frozen=True)
class Velocity:
    """A planar velocity of the robot's base.

    Attributes:
        v: Forward [m/s].
        w: Turn, counter-clockwise [rad/s].
        side: To the left [m/s].

    Raises:
        CommandError: A value is not finite.
    """

    v: float = 0.0
    w: float = 0.0
    side: float = 0.0

    def __post_init__(self) -> None:
        if not (math.isfinite(self.v) and math.isfinite(self.w) and math.isfinite(self.side)):
            values = f"v={self.v}, w={self.w}, side={self.side}"
            raise CommandError(f"velocity ({values}) must be finite")


_STILL = Velocity()


@dataclass(frozen=True)
class DriveConfig:
    """Limits of the base, and the kinematics that calibration found."""

    max_linear_velocity: float = param(1.0, "Greatest speed.", unit="m/s", minimum=0.0)
    max_angular_velocity: float = param(2.0, "Greatest turn rate.", unit="rad/s", minimum=0.0)
    max_linear_acceleration: float = param(
        2.5, "Greatest change of speed.", unit="m/s^2", minimum=0.01
    )
    max_angular_acceleration: float = param(
        3.2, "Greatest change of turn rate.", unit="rad/s^2", minimum=0.01
    )
    command_timeout: float = param(
        0.5,
        "The robot stands so long after the last command, where it can brake within two fifths of"
        " that; else it begins then.",
        unit="s",
        minimum=0.02,
    )
    effective_track_width: float = param(
        0.0,
        "Track of the ideal two-wheeled robot that turns like this one as its wheels slip;"
        " 0 takes the URDF's, else its wheel separation.",
        unit="m",
        minimum=0.0,
        read_only=True,
    )
    effective_wheel_radius: float = param(
        0.0,
        "Radius that makes wheel turns into distance; 0 takes the URDF's.",
        unit="m",
        minimum=0.0,
        read_only=True,
    )


@dataclass(frozen=True)
class Kinematics:
    """An ideal two-wheeled robot that stands for the skid-steer one.

    Source: Mandow et al., Experimental kinematics for wheeled skid-steer mobile robots, IROS 2007
    (symmetric case: one effective track).

    Attributes:
        track: Effective track width [m].
        radius: Effective wheel radius [m].
    """

    track: float
    radius: float

    def wheel_speeds(self, velocity: Velocity) -> tuple[float, float]:
        """Return the left and right wheels' speeds [rad/s] for a velocity of the base."""
        across = velocity.w * self.track / 2
        return (velocity.v - across) / self.radius, (velocity.v + across) / self.radius

    def base_motion(self, left: float, right: float) -> tuple[float, float]:
        """Return the base's path and turn for the left and right wheels' turns [rad], or rates.

        Returns:
            Path [m] and turn [rad], or speed [m/s] and turn rate [rad/s].
        """
        mean, difference = (left + right) / 2, right - left
        return mean * self.radius, difference * self.radius / self.track

    def motion(
        self, turns: NDArray[np.float64], angles: NDArray[np.float64]
    ) -> tuple[float, float, float]:
        """Return path [m], way to the side [m] and turn [rad] for turns of left and right [rad]."""
        left, right = turns.tolist()
        path, turn = self.base_motion(left, right)
        return path, 0.0, turn


def kinematics_of(settings: DriveSettings, config: DriveConfig) -> Kinematics:
    """Return what was calibrated, or else what the robot's file says."""
    return Kinematics(
        config.effective_track_width or settings.effective_track,
        config.effective_wheel_radius or settings.effective_radius,
    )


def limited(config: DriveConfig, settings: DriveSettings, steady: float = math.inf) -> DriveConfig:
    """Return the limits, lowered to those that the robot's file names.

    What the wheels can do at the ground bounds the turning: twice that over the track.

    Args:
        config: The limits.
        settings: What the robot's file says.
        steady: Greatest acceleration at which the robot neither slips nor tips [m/s^2].
    """
    turn = 2.0 / settings.separation if settings.separation > 0.0 else math.inf
    speed = settings.max_velocity or math.inf
    acceleration = min(settings.max_acceleration or math.inf, steady)
    return replace(
        config,
        max_linear_velocity=min(config.max_linear_velocity, speed),
        max_linear_acceleration=min(config.max_linear_acceleration, acceleration),
        max_angular_acceleration=min(config.max_angular_acceleration, acceleration * turn),
    )


class Drive:
    """The base's controller: holds the last command and ramps towards it.

    Args:
        config: Limits and time-out.
    """

    def __init__(self, config: DriveConfig) -> None:
        self.config = config
        self.reset()

    def reset(self) -> None:
        """Stand still, with no command."""
        self._target = Velocity()
        self._current = Velocity()
        self._expires = -math.inf

    def command(self, velocity: Velocity, now: float) -> None:
        """Take a command at time `now` [s]; it is clipped to the limits."""
        limit_v, limit_w = self.config.max_linear_velocity, self.config.max_angular_velocity
        fastest = max(abs(velocity.v), abs(velocity.side))
        if fastest > limit_v or abs(velocity.w) > limit_w:
            velocity = Velocity(
                max(-limit_v, min(limit_v, velocity.v)),
                max(-limit_w, min(limit_w, velocity.w)),
                max(-limit_v, min(limit_v, velocity.side)),
            )
        self._target = velocity
        self._expires = now + self.config.command_timeout

    def velocity(self, now: float, dt: float) -> Velocity:
        """Return the velocity to hold from `now` for `dt` [s]."""
        expired = now >= self._expires - self._braking() - _TOLERANCE
        target = _STILL if expired else self._target
        self._current = Velocity(
            _ramp(self._current.v, target.v, self.config.max_linear_acceleration * dt),
            _ramp(self._current.w, target.w, self.config.max_angular_acceleration * dt),
            _ramp(self._current.side, target.side, self.config.max_linear_acceleration * dt),
        )
        return self._current

    def _braking(self) -> float:
        """Return how long before a command's end the robot must brake to stand by then [s]."""
        config, now = self.config, self._current
        speed = max(abs(now.v), abs(now.side)) / config.max_linear_acceleration
        turn = abs(now.w) / config.max_angular_acceleration
        return min(max(speed, turn), _BRAKES * config.command_timeout)


def _ramp(current: float, target: float, step: float) -> float:
    """Move towards a target by at most a step."""
    return current + max(-step, min(step, target - current))
