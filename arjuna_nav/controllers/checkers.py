"""Goal and progress checkers: has the robot arrived, does it get on?"""

from __future__ import annotations

from dataclasses import dataclass

from arjuna_core.config import param
from arjuna_core.se2 import SE2, wrap


@dataclass(frozen=True)
class ProgressConfig:
    """Parameters of the progress checker, by Nav2's names."""

    plugin: str = param(
        "nav2_controller::SimpleProgressChecker",
        "Nav2's name of what is used.",
        choices=("nav2_controller::SimpleProgressChecker",),
    )
    required_movement_radius: float = param(
        0.5, "Distance to be moved in the time allowed.", unit="m", minimum=0.0
    )
    movement_time_allowance: float = param(10.0, "Time allowed.", unit="s", minimum=0.0)


class SimpleProgressChecker:
    """Asks that the robot moves some distance in some time.

    Args:
        config: Distance and time.

    Source: nav2_controller, SimpleProgressChecker.
    """

    def __init__(self, config: ProgressConfig) -> None:
        self._config = config
        self._since: tuple[SE2, float] | None = None

    def reset(self) -> None:
        """Start over with the next check."""
        self._since = None

    def check(self, pose: SE2, now: float) -> bool:
        """Tell whether the robot gets on.

        Args:
            pose: The robot's [m, m, rad].
            now: Time [s].
        """
        if self._since is None or self._moved(self._since[0], pose):
            self._since = (pose, now)
            return True
        return now - self._since[1] <= self._config.movement_time_allowance

    def _moved(self, before: SE2, pose: SE2) -> bool:
        return before.distance(pose) > self._config.required_movement_radius


@dataclass(frozen=True)
class GoalConfig:
    """Parameters of the goal checker, by Nav2's names."""

    plugin: str = param(
        "nav2_controller::SimpleGoalChecker",
        "Nav2's name of what is used.",
        choices=("nav2_controller::SimpleGoalChecker",),
    )
    xy_goal_tolerance: float = param(0.25, "Distance from the goal.", unit="m", minimum=0.0)
    yaw_goal_tolerance: float = param(0.25, "Angle from the goal's.", unit="rad", minimum=0.0)
    stateful: bool = param(True, "Whether the position, once reached, counts as reached.")


class SimpleGoalChecker:
    """Tells whether position and heading are within their tolerances.

    Args:
        config: Tolerances.

    Source: nav2_controller, SimpleGoalChecker.
    """

    def __init__(self, config: GoalConfig) -> None:
        self._config = config
        self._position_reached = False

    def reset(self) -> None:
        """Forget that the position was reached."""
        self._position_reached = False

    def reached(self, pose: SE2, goal: SE2) -> bool:
        """Tell whether the robot has arrived; both poses are of one frame."""
        if not self._position_reached and pose.distance(goal) > self._config.xy_goal_tolerance:
            return False
        self._position_reached = self._config.stateful
        return abs(wrap(goal.theta - pose.theta)) <= self._config.yaw_goal_tolerance
