"""Turning on the spot."""

from __future__ import annotations

import math

from arjuna_core.se2 import SE2, wrap
from arjuna_core.twist import Velocity
from arjuna_nav.behaviors.base import (
    BehaviorConfig,
    BehaviorResult,
    InvalidGoalError,
    TimedBehavior,
)
from arjuna_nav.costmap.costmap import Costmap
from arjuna_nav.costmap.footprint import Footprint


class Spin(TimedBehavior):
    """Turns on the spot by an angle.

    Args:
        target_yaw: Angle [rad], positive to the left.
        config: Limits.
        footprint: The robot.
        time_allowance: When to give up [s]; 0 never.

    Raises:
        InvalidGoalError: The angle is not finite.

    Source: nav2_behaviors, Spin.
    """

    def __init__(
        self, target_yaw: float, config: BehaviorConfig, footprint: Footprint, time_allowance: float
    ) -> None:
        super().__init__(config, footprint, time_allowance)
        if not math.isfinite(target_yaw):
            raise InvalidGoalError(f"target_yaw {target_yaw} is not finite")
        self._target = target_yaw
        self._last_yaw: float | None = None

    def _is_done(self, pose: SE2, elapsed: float) -> bool:
        if self._last_yaw is not None:
            self._progress += wrap(pose.theta - self._last_yaw)
        self._last_yaw = pose.theta
        return self._left() <= 0.0

    def _left(self) -> float:
        return abs(self._target) - abs(self._progress)

    def _drive(self, pose: SE2, costmap: Costmap, now: float) -> BehaviorResult:
        config = self._config
        rate = math.sqrt(2.0 * config.rotational_acc_lim * self._left())
        rate = min(max(rate, config.min_rotational_vel), config.max_rotational_vel)
        velocity = Velocity(yaw_rate=math.copysign(rate, self._target))
        return self._unless_it_collides(velocity, self._left() / rate, pose, costmap)
