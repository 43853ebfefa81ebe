"""Recovery behaviours: turn, drive a bit, wait."""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass
from typing import Protocol

from arjuna_core.config import param
from arjuna_core.se2 import SE2, wrap
from arjuna_nav.controllers.base import Velocity
from arjuna_nav.controllers.motion import rollout
from arjuna_nav.costmap.collision import first_collision
from arjuna_nav.costmap.costmap import Costmap
from arjuna_nav.costmap.footprint import Footprint


class BehaviorStatus(enum.Enum):
    """How a behaviour goes; `error_code` gives nav2_msgs' number for each kind."""

    RUNNING = enum.auto()
    SUCCEEDED = enum.auto()
    UNKNOWN = enum.auto()
    TIMEOUT = enum.auto()
    TF_ERROR = enum.auto()
    INVALID_INPUT = enum.auto()
    COLLISION_AHEAD = enum.auto()


_ORDER = (BehaviorStatus.UNKNOWN, BehaviorStatus.TIMEOUT, BehaviorStatus.TF_ERROR)
_INPUT_FIRST = (*_ORDER, BehaviorStatus.INVALID_INPUT, BehaviorStatus.COLLISION_AHEAD)
_COLLISION_FIRST = (*_ORDER, BehaviorStatus.COLLISION_AHEAD, BehaviorStatus.INVALID_INPUT)
_CODES = {  # BackUp and DriveOnHeading number their last two the other way round
    "spin": (700, (*_ORDER, BehaviorStatus.COLLISION_AHEAD)),  # what is not there is UNKNOWN
    "backup": (710, _INPUT_FIRST),
    "drive_on_heading": (720, _COLLISION_FIRST),
    "assisted_teleop": (730, _ORDER),
    "wait": (740, _ORDER),
}


def error_code(kind: str, status: BehaviorStatus) -> int:
    """Return the error code of nav2_msgs' action for a behaviour's end, 0 for success."""
    if status in (BehaviorStatus.SUCCEEDED, BehaviorStatus.RUNNING):
        return 0
    base, order = _CODES[kind]
    return base + (order.index(status) if status in order else 0)


@dataclass(frozen=True)
class BehaviorResult:
    """What to drive now, and how it goes.

    Attributes:
        status: RUNNING, or how it ended.
        v: Forward speed [m/s].
        w: Yaw rate [rad/s].
        progress: Feedback: angle turned [rad], distance driven [m] or time left [s].
        message: What went wrong, with numbers; empty while it goes well.
    """

    status: BehaviorStatus
    v: float = 0.0
    w: float = 0.0
    progress: float = 0.0
    message: str = ""


class Behavior(Protocol):
    """One motion from its start to its end; poses and costmap are of one frame.

    Without a costmap nothing is moved: such a tick ends as UNKNOWN.
    """

    def tick(self, pose: SE2, costmap: Costmap | None, now: float) -> BehaviorResult:
        """Return what to drive until the next tick; the first tick starts it."""
        ...


@dataclass(frozen=True)
class BehaviorConfig:
    """Parameters of the behaviours, by Nav2's names."""

    simulate_ahead_time: float = param(2.0, "time simulated ahead", unit="s", minimum=0.0)
    max_rotational_vel: float = param(1.0, "greatest yaw rate", unit="rad/s", minimum=0.01)
    min_rotational_vel: float = param(0.4, "least yaw rate", unit="rad/s", minimum=0.01)
    rotational_acc_lim: float = param(3.2, "deceleration", unit="rad/s^2", minimum=0.01)
    projection_time: float = param(
        1.0, "time teleoperation looks ahead, and a command of it holds", unit="s", minimum=0.01
    )
    simulation_time_step: float = param(0.1, "step of that look", unit="s", minimum=0.01)


class Spin:
    """Turns on the spot by an angle.

    Args:
        target_yaw: Angle [rad], positive to the left.
        config: Limits.
        footprint: The robot.
        time_allowance: When to give up [s]; 0 never.

    Source: nav2_behaviors, Spin.
    """

    def __init__(
        self, target_yaw: float, config: BehaviorConfig, footprint: Footprint, time_allowance: float
    ) -> None:
        self._target = target_yaw
        self._config = config
        self._footprint = footprint
        self._clock = _Allowance(time_allowance)
        self._last_yaw: float | None = None
        self._turned = 0.0

    def tick(self, pose: SE2, costmap: Costmap | None, now: float) -> BehaviorResult:
        """Return the yaw rate to drive."""
        if not math.isfinite(self._target):
            message = f"target_yaw {self._target} is not finite"
            return BehaviorResult(BehaviorStatus.INVALID_INPUT, message=message)
        if self._last_yaw is not None:
            self._turned += wrap(pose.theta - self._last_yaw)
        self._last_yaw = pose.theta
        left = abs(self._target) - abs(self._turned)
        if left <= 0.0:
            return BehaviorResult(BehaviorStatus.SUCCEEDED, progress=self._turned)
        if self._clock.exceeded(now):
            return self._clock.result(self._turned)
        config = self._config
        rate = math.sqrt(2.0 * config.rotational_acc_lim * left)
        rate = min(max(rate, config.min_rotational_vel), config.max_rotational_vel)
        command = Velocity(0.0, math.copysign(rate, self._target))
        duration = min(config.simulate_ahead_time, left / rate)
        return _safe(command, duration, pose, costmap, self._footprint, self._turned)


class DriveOnHeading:
    """Drives straight for a distance; a negative distance and speed drive back.

    Args:
        distance: How far [m].
        speed: How fast, of the same sign [m/s].
        config: Time simulated ahead.
        footprint: The robot.
        time_allowance: When to give up [s]; 0 never.

    Source: nav2_behaviors, DriveOnHeading and BackUp.
    """

    def __init__(
        self,
        distance: float,
        speed: float,
        config: BehaviorConfig,
        footprint: Footprint,
        time_allowance: float,
    ) -> None:
        self._distance = distance
        self._speed = speed
        self._config = config
        self._footprint = footprint
        self._clock = _Allowance(time_allowance)
        self._start: SE2 | None = None

    def tick(self, pose: SE2, costmap: Costmap | None, now: float) -> BehaviorResult:
        """Return the speed to drive."""
        if not 0.0 < self._distance * self._speed < math.inf:
            message = (
                f"distance {self._distance:g} and speed {self._speed:g} "
                "must have one sign and be finite"
            )
            return BehaviorResult(BehaviorStatus.INVALID_INPUT, message=message)
        if self._start is None:
            self._start = pose
        driven = self._start.distance(pose)
        left = abs(self._distance) - driven
        if left <= 0.0:
            return BehaviorResult(BehaviorStatus.SUCCEEDED, progress=driven)
        if self._clock.exceeded(now):
            return self._clock.result(driven)
        duration = min(self._config.simulate_ahead_time, left / abs(self._speed))
        command = Velocity(self._speed, 0.0)
        return _safe(command, duration, pose, costmap, self._footprint, driven)


def back_up(
    distance: float,
    speed: float,
    config: BehaviorConfig,
    footprint: Footprint,
    time_allowance: float,
) -> DriveOnHeading:
    """Return the behaviour that drives back; the signs of distance and speed do not matter.

    Source: nav2_behaviors, BackUp::onRun.
    """
    return DriveOnHeading(-abs(distance), -abs(speed), config, footprint, time_allowance)


class Wait:
    """Stands still for a time.

    Args:
        duration: How long [s].
    """

    def __init__(self, duration: float) -> None:
        self._duration = duration
        self._start: float | None = None

    def tick(self, pose: SE2, costmap: Costmap | None, now: float) -> BehaviorResult:
        """Return whether the time is over; `progress` is the time left [s]."""
        if self._start is None:
            self._start = now
        left = self._duration - (now - self._start)
        status = BehaviorStatus.SUCCEEDED if left <= 0.0 else BehaviorStatus.RUNNING
        return BehaviorResult(status, progress=max(left, 0.0))


class AssistedTeleop:
    """Drives as somebody commands, slower the nearer a collision, until they are done.

    Args:
        config: Time looked ahead.
        footprint: The robot.
        time_allowance: When to give up [s]; 0 never.

    Source: nav2_behaviors, AssistedTeleop. A command that ceases holds no longer than the time
        looked ahead.
    """

    def __init__(self, config: BehaviorConfig, footprint: Footprint, time_allowance: float) -> None:
        self._config = config
        self._footprint = footprint
        self._clock = _Allowance(time_allowance)
        self._start: float | None = None
        self._command = Velocity()
        self._commanded_at = -math.inf
        self._done = False

    def take(self, command: Velocity, now: float) -> None:
        """Drive by a command from now [s] on."""
        self._command, self._commanded_at = command, now

    def finish(self) -> None:
        """Be done at the next tick."""
        self._done = True

    def tick(self, pose: SE2, costmap: Costmap | None, now: float) -> BehaviorResult:
        """Return what to drive; `progress` is the time since the start [s]."""
        if self._start is None:
            self._start = now
        elapsed = now - self._start
        if self._done:
            return BehaviorResult(BehaviorStatus.SUCCEEDED, progress=elapsed)
        if self._clock.exceeded(now):
            return self._clock.result(elapsed)
        if costmap is None:
            message = "no local costmap has come"
            return BehaviorResult(BehaviorStatus.UNKNOWN, progress=elapsed, message=message)
        part = self._safe_part(pose, costmap, now)
        v, w = self._command.v * part, self._command.w * part
        return BehaviorResult(BehaviorStatus.RUNNING, v, w, elapsed)

    def _safe_part(self, pose: SE2, costmap: Costmap, now: float) -> float:
        """Return the part of the time looked ahead that is free of collisions."""
        config = self._config
        if now - self._commanded_at > config.projection_time:
            return 0.0
        arc = rollout(pose, self._command, config.projection_time, costmap.frame.resolution)
        hit = first_collision(costmap, self._footprint, arc)
        if hit is None:
            return 1.0
        part = max(hit - 1, 0) / (len(arc) - 1)  # up to the last pose that is free
        return part if part * config.projection_time > config.simulation_time_step else 0.0


class _Allowance:
    """A limit of time that runs from the first question."""

    def __init__(self, allowance: float) -> None:
        self._allowance = allowance
        self._start: float | None = None

    def exceeded(self, now: float) -> bool:
        if self._start is None:
            self._start = now
        return 0.0 < self._allowance < now - self._start

    def result(self, progress: float) -> BehaviorResult:
        message = f"time allowance of {self._allowance:g} s exceeded"
        return BehaviorResult(BehaviorStatus.TIMEOUT, progress=progress, message=message)


def _safe(
    command: Velocity,
    duration: float,
    pose: SE2,
    costmap: Costmap | None,
    footprint: Footprint,
    progress: float,
) -> BehaviorResult:
    """Return the command, or COLLISION_AHEAD where driving it for a time would collide."""
    if costmap is None:
        message = "no local costmap has come"
        return BehaviorResult(BehaviorStatus.UNKNOWN, progress=progress, message=message)
    arc = rollout(pose, command, duration, costmap.frame.resolution)
    hit = first_collision(costmap, footprint, arc)
    if hit is None:
        return BehaviorResult(BehaviorStatus.RUNNING, command.v, command.w, progress)
    message = f"collision ahead at ({arc[hit, 0]:.2f}, {arc[hit, 1]:.2f})"
    return BehaviorResult(BehaviorStatus.COLLISION_AHEAD, progress=progress, message=message)
