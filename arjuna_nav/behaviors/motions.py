"""The behaviours: a spin, a straight drive, a drive by a person's commands, a wait.

Source: nav2_behaviors: Spin, DriveOnHeading and BackUp, AssistedTeleop, Wait.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from arjuna_core.config import param, speed_param
from arjuna_core.se2 import SE2, wrap
from arjuna_core.twist import STILL, Velocity
from arjuna_nav.behaviors.base import (
    BehaviorConfig,
    BehaviorResult,
    BehaviorStatus,
    InvalidGoalError,
    TimedBehavior,
)
from arjuna_nav.controllers.motion import braking_speed, rollout
from arjuna_nav.costmap.collision import first_collision
from arjuna_nav.costmap.costmap import Costmap
from arjuna_nav.costmap.footprint import Footprint


class Spin(TimedBehavior):
    """Turns on the spot by an angle [rad], positive to the left.

    Raises:
        InvalidGoalError: The angle is not finite, or the robot is steered.
    """

    def __init__(
        self, target_yaw: float, config: BehaviorConfig, footprint: Footprint, time_allowance: float
    ) -> None:
        super().__init__(config, footprint, time_allowance)
        if not math.isfinite(target_yaw):
            raise InvalidGoalError(f"target_yaw {target_yaw} is not finite")
        if config.min_turning_radius > 0.0:
            bend = f"it bends by min_turning_radius = {config.min_turning_radius:g} m at the least"
            raise InvalidGoalError(f"the robot cannot turn on the spot: {bend}")
        self._target = target_yaw
        self._last_yaw: float | None = None

    def _is_done(self, pose: SE2, elapsed: float) -> bool:
        if self._last_yaw is not None:
            self._progress += wrap(pose.theta - self._last_yaw)
        self._last_yaw = pose.theta
        return self._remaining() <= 0.0

    def _remaining(self) -> float:
        return abs(self._target) - abs(self._progress)

    def _drive(self, pose: SE2, costmap: Costmap, now: float) -> BehaviorResult:
        config = self._config
        rate = braking_speed(self._remaining(), config.rotational_acc_lim, 0.0)
        rate = min(max(rate, config.min_rotational_vel), config.max_rotational_vel)
        velocity = Velocity(yaw_rate=math.copysign(rate, self._target))
        return self._unless_it_collides(velocity, self._remaining() / rate, pose, costmap)


@dataclass(frozen=True)
class DriveConfig:
    """Parameters of one straight drive, by the names of Nav2 after Jazzy; Jazzy has no ramp."""

    acceleration_limit: float = param(
        0.0, "How fast it gains speed; 0: at once.", unit="m/s^2", minimum=0.0
    )
    deceleration_limit: float = param(
        0.0, "How fast it loses speed before the end, below 0; 0: at once.", unit="m/s^2", maximum=0
    )
    minimum_speed: float = speed_param(0.0, "Least speed, whatever the goal and the limits say.")


class DriveOnHeading(TimedBehavior):
    """Drives straight for a distance [m] at a speed [m/s]; both negative drive back.

    Source: nav2_behaviors, DriveOnHeading::onCycleUpdate.

    Raises:
        InvalidGoalError: Distance and speed have two signs, or one is 0 or not finite.
    """

    def __init__(
        self,
        distance: float,
        speed: float,
        config: BehaviorConfig,
        footprint: Footprint,
        time_allowance: float,
        ramp: DriveConfig | None = None,
    ) -> None:
        super().__init__(config, footprint, time_allowance)
        if not 0.0 < distance * speed < math.inf:
            pair = f"distance {distance:g} and speed {speed:g}"
            raise InvalidGoalError(f"{pair} must have one sign and be finite")
        self._distance = abs(distance)
        self._speed = speed
        self._ramp = ramp or DriveConfig()
        self._driven, self._driven_at = 0.0, math.inf  # last speed and its time
        self._start: SE2 | None = None

    def _is_done(self, pose: SE2, elapsed: float) -> bool:
        self._start = self._start or pose
        self._progress = self._start.distance(pose)
        return self._progress >= self._distance

    def _drive(self, pose: SE2, costmap: Costmap, now: float) -> BehaviorResult:
        remaining, speed = self._distance - self._progress, self._ramped(now)
        velocity = Velocity(math.copysign(speed, self._speed))
        time_left = remaining / speed if speed else 0.0
        return self._unless_it_collides(velocity, time_left, pose, costmap)

    def _ramped(self, now: float) -> float:
        """Return the speed within the limits of the ramp."""
        ramp, speed = self._ramp, abs(self._speed)
        if ramp.acceleration_limit:
            since = max(now - self._driven_at, 0.0)
            speed = min(speed, self._driven + ramp.acceleration_limit * since)
        if ramp.deceleration_limit:
            remaining = self._distance - self._progress
            speed = min(speed, braking_speed(remaining, -ramp.deceleration_limit, 0.0))
        self._driven, self._driven_at = max(speed, ramp.minimum_speed), now
        return self._driven


class AssistedTeleop(TimedBehavior):
    """Drives as a person commands, slower the nearer a collision, until they are done.

    A command that ceases holds no longer than the time looked ahead.
    """

    def __init__(self, config: BehaviorConfig, footprint: Footprint, time_allowance: float) -> None:
        super().__init__(config, footprint, time_allowance)
        self._command = STILL
        self._commanded_at = -math.inf
        self._finished = False

    def take(self, command: Velocity, now: float) -> None:
        """Drive by a command from now [s] on."""
        self._command, self._commanded_at = command, now

    def finish(self) -> None:
        """Be done at the next tick."""
        self._finished = True

    def _is_done(self, pose: SE2, elapsed: float) -> bool:
        self._progress = elapsed
        return self._finished

    def _drive(self, pose: SE2, costmap: Costmap, now: float) -> BehaviorResult:
        part = self._safe_part(pose, costmap, now)
        return self._result(BehaviorStatus.RUNNING, velocity=self._command.scaled(part))

    def _safe_part(self, pose: SE2, costmap: Costmap, now: float) -> float:
        """Return the part of the time looked ahead that is free of collisions."""
        config = self._config
        if self._command == STILL or now - self._commanded_at > config.projection_time:
            return 0.0
        moved = self._footprint.base_velocity(self._command)
        arc = rollout(pose, moved, config.projection_time, costmap.frame.resolution)
        hit = first_collision(costmap, self._footprint, arc)
        if hit is None:
            return 1.0
        step = config.simulation_time_step / config.projection_time
        part = max(hit - 1, 0) / (len(arc) - 1)  # up to the last pose that is free
        if not config.teleop_by_last_free:
            part = math.ceil(hit / (len(arc) - 1) / step - 1e-9) * step
        return part if part > step + 1e-9 else 0.0


class Wait:
    """Stands still for a duration [s]."""

    def __init__(self, duration: float) -> None:
        self._duration = duration
        self._start: float | None = None

    def tick(self, pose: SE2, costmap: Costmap | None, now: float) -> BehaviorResult:
        """Return whether the time is over; `progress` is the time remaining [s]."""
        if self._start is None:
            self._start = now
        remaining = self._duration - (now - self._start)
        status = BehaviorStatus.SUCCEEDED if remaining <= 0.0 else BehaviorStatus.RUNNING
        return BehaviorResult(status, progress=max(remaining, 0.0))
