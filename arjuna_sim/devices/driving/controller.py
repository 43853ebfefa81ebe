"""The base's controller: it holds commands for a time, keeps them within limits, and ramps."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, replace

from arjuna_core.errors import ArjunaError
from arjuna_core.twist import Velocity
from arjuna_sim.devices.drive import DriveConfig
from arjuna_sim.model.settings import DriveSettings

ASSUMED = 1.0
"""Period of a sender of whom one command is known: `ros2 topic pub`'s default [s]."""
_LATE = 1.5  # of its period: a command ends where the next one is so late
_KEPT, _RANK = 9, 3  # gaps: of three senders that take turns a third are long
_STILL = Velocity()


@dataclass(frozen=True)
class HoldLimits:
    """Bounds of a command's hold.

    Attributes:
        least: A command holds so long at least; for ever if 0 [s].
        longest: And so long at most, unless `least` is longer [s].
        is_fixed: Whether each holds just `least`, and braking begins when that is out.
    """

    least: float = 0.5
    longest: float = 3.0
    is_fixed: bool = False


class CommandHold:
    """When the last command ends.

    A command holds for one and a half periods of its sender, within the limits: a quick sender that
    falls silent ends after the least time, a slow one never between two commands. The period is the
    third longest of the last nine gaps between commands, so that two late ones do not make a quick
    sender slow, and three slow senders that take turns are not taken for a quick one. It is unknown
    of the first command, and of one after more than one and a half seconds of silence in which the
    last one ended: then it is that silence, or a second where the limits do not allow for it.

    Only the times of commands count, so that it is the same whoever sends them, and in each run.
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Forget all commands."""
        self._gaps: deque[float] = deque(maxlen=_KEPT)
        self._last = self._ends = -math.inf
        self._room, self._assumed = 0.0, ASSUMED

    def take(self, now: float, limits: HoldLimits) -> None:
        """Take a command at a time [s]."""
        gap = now - self._last
        if (now >= self._ends and gap >= _LATE * ASSUMED) or gap < 0.0:
            self._gaps.clear()
            self._assumed = gap if 0.0 < gap <= limits.longest else ASSUMED
        else:
            self._gaps.append(gap)
        period = sorted(self._gaps or [self._assumed])[-_RANK:][0]
        hold = max(limits.least, min(_LATE * period, limits.longest))
        if limits.is_fixed or not limits.least:
            hold = limits.least or math.inf
        self._last, self._ends = now, now + hold
        # Braking begins at most 0.4 of the time-out before its end, and not before the next
        # command is late by 0.2 of its period.
        room = min(0.4 * limits.least, hold - 1.2 * period)
        self._room = 0.0 if limits.is_fixed else max(0.0, room)

    def ends(self, braking: float) -> float:
        """Return when the last command ends for a robot that takes some time to stand [s].

        It stands when the command is out where it can, without braking before the next is due.
        """
        return self._ends - min(braking, self._room)


@dataclass(frozen=True)
class Bound:
    """A greatest speed in either direction.

    Attributes:
        value: [m/s or rad/s].
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
class Ramp:
    """Greatest changes of a speed or turn rate, infinity for none [m/s^2 or rad/s^2].

    Attributes:
        up: Forward, or counter-clockwise.
        down: Backwards, or clockwise.
        jerk: Of the change itself [m/s^3 or rad/s^3].
    """

    up: float
    down: float
    jerk: float = math.inf

    def within(self, limit: float) -> Ramp:
        """Return it, no steeper than a limit."""
        return replace(self, up=min(self.up, limit), down=min(self.down, limit))

    def step(self, current: float, target: float, rate: float, dt: float) -> tuple[float, float]:
        """Return the speed after a step of time towards a target, and the change that led there.

        Args:
            rate: The change before.
        """
        if math.isinf(self.jerk):
            return current + max(-self.down * dt, min(self.up * dt, target - current)), 0.0
        gap, jolt = target - current, self.jerk * dt
        if abs(gap) <= jolt * dt and abs(rate) <= jolt:
            return target, 0.0
        # So steep that it is level again at the target, each step by one jolt.
        steep = math.sqrt(jolt * jolt / 4.0 + 2.0 * self.jerk * abs(gap)) - jolt / 2.0
        wanted = math.copysign(min(steep, abs(gap) / dt, self.up if gap > 0.0 else self.down), gap)
        rate = max(rate - jolt, min(rate + jolt, wanted))
        return current + rate * dt, rate

    def braking(self, speed: float) -> float:
        """Return how long it takes to stand [s]."""
        limit, size = self.down if speed > 0.0 else self.up, abs(speed)
        if math.isinf(self.jerk) or not size:
            return size / limit
        limit = min(limit, math.sqrt(size * self.jerk))
        return size / limit + limit / self.jerk


@dataclass(frozen=True)
class Limits:
    """Limits of a robot's commands, and of the time for which they hold.

    Attributes:
        forward: Greatest speed forward, and to the sides [m/s].
        reverse: Greatest speed backwards [m/s].
        turn: Greatest turn rate [rad/s].
        linear: Greatest changes of speed.
        angular: Greatest changes of turn rate.
        hold: How long commands hold.
    """

    forward: Bound
    reverse: Bound
    turn: Bound
    linear: Ramp
    angular: Ramp
    hold: HoldLimits


def limited(config: DriveConfig, settings: DriveSettings, steady: float = math.inf) -> Limits:
    """Return the limits: what parameters name, else the robot's file, else none.

    What the wheels can do at the ground bounds the accelerations: turning by twice that over the
    track.

    Args:
        steady: Greatest acceleration at which the robot neither slips nor tips [m/s^2].
    """
    # A steered robot turns as it rolls: its turn rate has no traction of its own.
    skids = settings.separation > 0.0 and not settings.steering
    turn = 2.0 / settings.separation if skids else math.inf
    up, down = settings.max_acceleration, settings.max_deceleration
    linear = _ramp(config.max_linear_acceleration, up, down, settings.max_jerk).within(steady)
    up, down = settings.max_turn_acceleration, settings.max_turn_deceleration
    angular = _ramp(config.max_angular_acceleration, up, down, settings.max_turn_jerk)
    own = f"plugin '{settings.plugin}' of the robot's file"
    speed, rate = config.max_linear_velocity, config.max_angular_velocity
    backwards = settings.max_reverse or settings.max_velocity
    return Limits(
        _bound("m/s", speed, "linear", settings.max_velocity, own),
        _bound("m/s", speed, "linear", backwards, own),
        _bound("rad/s", rate, "angular", settings.max_turn, own),
        linear,
        angular.within(min(linear.up, linear.down) * turn),
        _hold(config, settings),
    )


def _ramp(parameter: float | None, up: float, down: float, jerk: float) -> Ramp:
    """Return what a parameter names, else what the file does; 0 in the file is none."""
    most, jerk = parameter or up or math.inf, jerk or math.inf
    return Ramp(most, parameter or down or most, jerk)


def _bound(unit: str, parameter: float | None, kind: str, in_file: float, plugin: str) -> Bound:
    """Return a bound; 0 in the file is none."""
    # The physics' time step would not follow a faster robot [m/s, rad/s].
    bound = Bound(50.0, unit, "what the physics can step")
    if parameter is not None and parameter < bound.value:
        return Bound(parameter, unit, f"the parameter drive.max_{kind}_velocity")
    if parameter is None and 0.0 < in_file < bound.value:
        return Bound(in_file, unit, plugin)
    return bound


def _hold(config: DriveConfig, settings: DriveSettings) -> HoldLimits:
    if config.command_timeout is not None:
        return HoldLimits(config.command_timeout, config.command_timeout_max)
    if settings.command_timeout is not None:
        return HoldLimits(settings.command_timeout, is_fixed=True)
    # [s] Neither the parameters nor the robot's file name a time-out.
    return HoldLimits(0.5, config.command_timeout_max)


class CommandError(ArjunaError, ValueError):
    """A velocity command is not finite."""


class Drive:
    """The base's controller: holds the last command and ramps towards it.

    Args:
        limits: Of commands.
        steers: Whether the speed ramps along the command's arc, to which the wheels are steered.
    """

    def __init__(self, limits: Limits, steers: bool = False) -> None:
        self.limits, self._steers = limits, steers
        self._hold = CommandHold()
        self._cuts: dict[str, str] = {}
        self._said: set[str] = set()
        self.reset()

    def reset(self) -> None:
        """Stand still, with no command."""
        self._target = Velocity()
        self._current = Velocity()
        self._rates = [0.0, 0.0, 0.0]
        self._bend = 0.0
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
        # [s] Rounding of the times must not hold a command for one more tick.
        expired = now >= self._hold.ends(self._braking()) - 1e-9
        target = _STILL if expired else self._target
        was, (along, across, turning) = self._current, self._rates
        x, along = limits.linear.step(was.x, target.x, along, dt)
        y, across = limits.linear.step(was.y, target.y, across, dt)
        rate = target.yaw_rate
        if self._steers:
            self._bend = target.yaw_rate / target.x if target.x != 0.0 else self._bend
            rate = x * self._bend
        rate, turning = limits.angular.step(was.yaw_rate, rate, turning, dt)
        self._current, self._rates = Velocity(x, y=y, yaw_rate=rate), [along, across, turning]
        return self._current

    def _braking(self) -> float:
        """Return how long the robot brakes to stand [s]."""
        limits, now = self.limits, self._current
        speed = max(limits.linear.braking(now.x), limits.linear.braking(now.y))
        return max(speed, limits.angular.braking(now.yaw_rate))
