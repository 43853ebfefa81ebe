"""Driving as a person commands, short of collisions."""

from __future__ import annotations

import math

from arjuna_core.se2 import SE2
from arjuna_core.twist import STILL, Velocity
from arjuna_nav.behaviors.base import (
    BehaviorConfig,
    BehaviorResult,
    BehaviorStatus,
    TimedBehavior,
)
from arjuna_nav.controllers.motion import rollout
from arjuna_nav.costmap.collision import first_collision
from arjuna_nav.costmap.costmap import Costmap
from arjuna_nav.costmap.footprint import Footprint


class AssistedTeleop(TimedBehavior):
    """Drives as somebody commands, slower the nearer a collision, until they are done.

    Args:
        config: Time looked ahead.
        footprint: The robot.
        time_allowance: When to give up [s]; 0 never.

    Source: nav2_behaviors, AssistedTeleop. A command that ceases holds no longer than the time
        looked ahead.
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
        velocity = Velocity(self._command.x * part, yaw_rate=self._command.yaw_rate * part)
        return self._result(BehaviorStatus.RUNNING, velocity=velocity)

    def _safe_part(self, pose: SE2, costmap: Costmap, now: float) -> float:
        """Return the part of the time looked ahead that is free of collisions."""
        config = self._config
        if self._command == STILL or now - self._commanded_at > config.projection_time:
            return 0.0
        arc = rollout(pose, self._command, config.projection_time, costmap.frame.resolution)
        hit = first_collision(costmap, self._footprint, arc)
        if hit is None:
            return 1.0
        part = max(hit - 1, 0) / (len(arc) - 1)  # up to the last pose that is free
        return part if part * config.projection_time > config.simulation_time_step else 0.0
