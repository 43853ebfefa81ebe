"""Goal checkers beside the simple one: also at rest, and by the position alone."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from arjuna_core.config import param
from arjuna_core.se2 import SE2
from arjuna_core.twist import STILL, Velocity
from arjuna_nav.controllers.checkers import GoalConfig, SimpleGoalChecker, is_there


@dataclass(frozen=True)
class StoppedGoalConfig(GoalConfig):
    """Parameters of the stopped goal checker, by Nav2's names."""

    trans_stopped_velocity: float = param(
        0.25, "Speed that counts as standing.", unit="m/s", minimum=0.0
    )
    rot_stopped_velocity: float = param(
        0.25, "Yaw rate that counts as standing.", unit="rad/s", minimum=0.0
    )


class StoppedGoalChecker(SimpleGoalChecker):
    """Asks that the robot has arrived and stands.

    Args:
        config: Tolerances and velocities.

    Source: nav2_controller, StoppedGoalChecker.
    """

    Config: ClassVar[type[Any]] = StoppedGoalConfig

    def __init__(self, config: StoppedGoalConfig) -> None:
        super().__init__(config)
        self._v_max, self._w_max = config.trans_stopped_velocity, config.rot_stopped_velocity

    def reached(self, pose: SE2, goal: SE2, velocity: Velocity = STILL) -> bool:
        """Tell whether the robot has arrived and stands; both poses are of one frame."""
        stands = abs(velocity.x) <= self._v_max and abs(velocity.yaw_rate) <= self._w_max
        return super().reached(pose, goal, velocity) and stands


@dataclass(frozen=True)
class PositionGoalConfig:
    """Parameters of the position goal checker, by Nav2's names."""

    xy_goal_tolerance: float = param(0.25, "Distance from the goal.", unit="m", minimum=0.0)
    stateful: bool = param(True, "Whether the position, once reached, counts as reached.")


class PositionGoalChecker:
    """Tells whether the position is within its tolerance, whatever the heading.

    Args:
        config: Tolerance.

    Source: nav2_controller, PositionGoalChecker.
    """

    Config: ClassVar[type[Any]] = PositionGoalConfig

    def __init__(self, config: PositionGoalConfig) -> None:
        self.xy_tolerance = config.xy_goal_tolerance
        self._stateful = config.stateful
        self._reached = False

    def reset(self) -> None:
        """Forget that the position was reached."""
        self._reached = False

    def reached(self, pose: SE2, goal: SE2, velocity: Velocity = STILL) -> bool:
        """Tell whether the robot has arrived; both poses are of one frame."""
        there = is_there(pose, goal, self.xy_tolerance, self._reached)
        self._reached = there and self._stateful
        return there
