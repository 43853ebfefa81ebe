"""What bounds a base's commands: parameters, else the robot's file, and what its wheels hold."""

from __future__ import annotations

import math
from dataclasses import dataclass

from arjuna_sim.devices.drive import DriveConfig
from arjuna_sim.devices.driving.hold import HoldLimits
from arjuna_sim.model.settings import DriveSettings

_TIMEOUT = 0.5  # of commands, where neither parameters nor the robot's file name one [s]
_SOUND = 50.0  # [m/s, rad/s] beyond which the physics' time step would not follow


@dataclass(frozen=True)
class Bound:
    """A greatest speed either way.

    Attributes:
        value: [m/s or rad/s].
        unit: Of the value.
        source: Who says so.
    """

    value: float
    unit: str
    source: str

    def text(self, speed: float) -> str:
        """Return what becomes of a speed beyond it."""
        return (
            f"a command of {speed:.4g} {self.unit} is cut to"
            f" {math.copysign(self.value, speed):.4g} {self.unit}, by {self.source}"
        )


@dataclass(frozen=True)
class Limits:
    """What a robot's commands are cut to, and how long they hold.

    Attributes:
        forward: Greatest speed forward, and to the sides [m/s].
        reverse: Greatest speed backwards [m/s].
        turn: Greatest turn rate [rad/s].
        linear_acceleration: Greatest change of speed, infinity for none [m/s^2].
        angular_acceleration: Greatest change of turn rate, infinity for none [rad/s^2].
        hold: How long commands hold.
    """

    forward: Bound
    reverse: Bound
    turn: Bound
    linear_acceleration: float
    angular_acceleration: float
    hold: HoldLimits


def limited(config: DriveConfig, settings: DriveSettings, steady: float = math.inf) -> Limits:
    """Return the limits: what parameters name, else the robot's file, else none.

    What the wheels can do at the ground bounds the accelerations: turning by twice that over the
    track.

    Args:
        config: The parameters.
        settings: What the robot's file says.
        steady: Greatest acceleration at which the robot neither slips nor tips [m/s^2].
    """
    turn = 2.0 / settings.separation if settings.separation > 0.0 else math.inf
    linear, angular = config.max_linear_acceleration, config.max_angular_acceleration
    linear = min(linear or settings.max_acceleration or math.inf, steady)
    own = f"plugin '{settings.plugin}' of the robot's file"
    speed, rate = config.max_linear_velocity, config.max_angular_velocity
    backwards = settings.max_reverse or settings.max_velocity
    return Limits(
        _bound("m/s", speed, "linear", settings.max_velocity, own),
        _bound("m/s", speed, "linear", backwards, own),
        _bound("rad/s", rate, "angular", settings.max_turn, own),
        linear,
        min(angular or settings.max_turn_acceleration or math.inf, linear * turn),
        _hold(config, settings),
    )


def _bound(unit: str, parameter: float | None, kind: str, in_file: float, plugin: str) -> Bound:
    """Return a bound; 0 in the file is none."""
    bound = Bound(_SOUND, unit, "what the physics can step")
    if parameter is not None and parameter < bound.value:
        return Bound(parameter, unit, f"the parameter drive.max_{kind}_velocity")
    if parameter is None and 0.0 < in_file < bound.value:
        return Bound(in_file, unit, plugin)
    return bound


def _hold(config: DriveConfig, settings: DriveSettings) -> HoldLimits:
    """Return how long commands hold: by the parameter, else the robot's controllers."""
    if config.command_timeout is not None:
        return HoldLimits(config.command_timeout, config.command_timeout_max)
    if settings.command_timeout is not None:
        return HoldLimits(settings.command_timeout, is_fixed=True)
    return HoldLimits(_TIMEOUT, config.command_timeout_max)
