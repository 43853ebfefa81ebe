"""Driving straight, ahead or back."""

from __future__ import annotations

import math

from arjuna_core.se2 import SE2
from arjuna_core.twist import Velocity
from arjuna_nav.behaviors.base import (
    BehaviorConfig,
    BehaviorResult,
    InvalidGoalError,
    TimedBehavior,
)
from arjuna_nav.costmap.costmap import Costmap
from arjuna_nav.costmap.footprint import Footprint


class DriveOnHeading(TimedBehavior):
    """Drives straight for a distance; a negative distance and speed drive back.

    Args:
        distance: How far [m].
        speed: How fast, of the same sign [m/s].
        config: Time simulated ahead.
        footprint: The robot.
        time_allowance: When to give up [s]; 0 never.

    Raises:
        InvalidGoalError: Distance and speed have two signs, or one is 0 or not finite.

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
        super().__init__(config, footprint, time_allowance)
        if not 0.0 < distance * speed < math.inf:
            pair = f"distance {distance:g} and speed {speed:g}"
            raise InvalidGoalError(f"{pair} must have one sign and be finite")
        self._distance = abs(distance)
        self._speed = speed
        self._start: SE2 | None = None

    def _is_done(self, pose: SE2, elapsed: float) -> bool:
        self._start = self._start or pose
        self._progress = self._start.distance(pose)
        return self._progress >= self._distance

    def _drive(self, pose: SE2, costmap: Costmap, now: float) -> BehaviorResult:
        time_left = (self._distance - self._progress) / abs(self._speed)
        return self._unless_it_collides(Velocity(self._speed), time_left, pose, costmap)
