"""The base, parameters and results of the recovery behaviours."""

from __future__ import annotations

import abc
import enum
from dataclasses import dataclass
from typing import Protocol

from arjuna_core.config import duration_param, param, yaw_rate_param
from arjuna_core.errors import ArjunaError
from arjuna_core.se2 import SE2
from arjuna_core.twist import STILL, Velocity
from arjuna_nav.controllers.motion import min_turning_radius, rollout
from arjuna_nav.costmap.collision import collision_ahead
from arjuna_nav.costmap.costmap import Costmap
from arjuna_nav.costmap.footprint import Footprint


class InvalidGoalError(ArjunaError, ValueError):
    """The goal of a behaviour makes no sense."""


class BehaviorStatus(enum.Enum):
    """The state of a behaviour; the names are those of nav2_msgs' error codes."""

    RUNNING = enum.auto()
    SUCCEEDED = enum.auto()
    UNKNOWN = enum.auto()
    TIMEOUT = enum.auto()
    TF_ERROR = enum.auto()
    INVALID_INPUT = enum.auto()
    COLLISION_AHEAD = enum.auto()


@dataclass(frozen=True)
class BehaviorResult:
    """The velocity to drive now, and the state of the behaviour.

    Attributes:
        progress: Feedback: angle turned [rad], distance driven [m], time driven or left [s].
        message: What went wrong, with numbers; empty while it goes well.
    """

    status: BehaviorStatus
    velocity: Velocity = STILL
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

    simulate_ahead_time: float = duration_param(2.0, "Time simulated ahead.")
    max_rotational_vel: float = yaw_rate_param(1.0, "Greatest yaw rate.")
    min_rotational_vel: float = param(0.4, "Least yaw rate; below 0 any.", unit="rad/s")
    rotational_acc_lim: float = param(3.2, "Deceleration.", unit="rad/s^2", minimum=0.01)
    projection_time: float = duration_param(
        1.0, "Time teleoperation looks ahead, and a command of it holds.", minimum=0.01
    )
    simulation_time_step: float = duration_param(0.1, "Step of that prediction.", minimum=0.01)
    min_turning_radius: float = min_turning_radius(", for which `spin` fails")
    teleop_by_last_free: bool = param(
        True,
        "Whether the last step that is free says how much slower teleoperation drives; else, as"
        " Nav2, the first that collides.",
        theirs=False,
    )


class TimedBehavior(abc.ABC):
    """A behaviour that drives until it is done, its time is over or a collision lies ahead.

    Args:
        time_allowance: When to give up [s]; 0 never.

    Source: nav2_behaviors, TimedBehavior.
    """

    def __init__(self, config: BehaviorConfig, footprint: Footprint, time_allowance: float) -> None:
        self._config = config
        self._footprint = footprint
        self._allowance = time_allowance
        self._started: float | None = None
        self._progress = 0.0

    def tick(self, pose: SE2, costmap: Costmap | None, now: float) -> BehaviorResult:
        """Return what to drive until the next tick; the first tick starts it."""
        if self._started is None:
            self._started = now
        elapsed = now - self._started
        if self._is_done(pose, elapsed):
            return self._result(BehaviorStatus.SUCCEEDED)
        if 0.0 < self._allowance < elapsed:
            message = f"time allowance of {self._allowance:g} s exceeded"
            return self._result(BehaviorStatus.TIMEOUT, message)
        if costmap is None:
            return self._result(BehaviorStatus.UNKNOWN, "no local costmap has come")
        return self._drive(pose, costmap, now)

    @abc.abstractmethod
    def _is_done(self, pose: SE2, elapsed: float) -> bool:
        """Bring the progress up to date and return whether that is all."""

    @abc.abstractmethod
    def _drive(self, pose: SE2, costmap: Costmap, now: float) -> BehaviorResult:
        """Return the velocity, or the collision ahead."""

    def _result(
        self, status: BehaviorStatus, message: str = "", velocity: Velocity = STILL
    ) -> BehaviorResult:
        return BehaviorResult(status, velocity, self._progress, message)

    def _unless_it_collides(
        self, velocity: Velocity, time_left: float, pose: SE2, costmap: Costmap
    ) -> BehaviorResult:
        """Return a velocity, or COLLISION_AHEAD where driving it for a time would collide."""
        duration = min(self._config.simulate_ahead_time, time_left)
        moved = self._footprint.base_velocity(velocity)
        arc = rollout(pose, moved, duration, costmap.frame.resolution)
        if problem := collision_ahead(costmap, self._footprint, arc):
            return self._result(BehaviorStatus.COLLISION_AHEAD, problem)
        return self._result(BehaviorStatus.RUNNING, velocity=velocity)
