"""Goal and progress checkers: whether the robot has arrived, and whether it makes progress."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar, Protocol

from arjuna_core.config import (
    angle_param,
    duration_param,
    length_param,
    param,
    speed_param,
    yaw_rate_param,
)
from arjuna_core.se2 import SE2, wrap
from arjuna_core.twist import STILL, Velocity


class ProgressChecker(Protocol):
    """Says whether the robot makes progress; made of its `Config`."""

    def reset(self) -> None:
        """Start over with the next check."""
        ...

    def check(self, pose: SE2, now: float) -> bool:
        """Return whether the robot, at a pose and a time [s], makes progress."""
        ...

    def failure_message(self) -> str:
        """Say what it did not do."""
        ...


class GoalChecker(Protocol):
    """Says whether the robot has arrived; made of its `Config`.

    Attributes:
        xy_tolerance: Distance at which the position counts as reached [m].
    """

    xy_tolerance: float

    def reset(self) -> None:
        """Forget what was reached."""
        ...

    def reached(self, pose: SE2, goal: SE2, velocity: Velocity = STILL) -> bool:
        """Return whether the robot has arrived; both poses are of one frame."""
        ...


@dataclass(frozen=True)
class ProgressConfig:
    """Parameters of the progress checker, by Nav2's names."""

    required_movement_radius: float = length_param(0.5, "Distance to be moved in the time allowed.")
    movement_time_allowance: float = duration_param(10.0, "Time allowed.")


class SimpleProgressChecker:
    """Requires that the robot moves some distance in some time.

    Source: nav2_controller, SimpleProgressChecker.
    """

    Config: ClassVar[type[Any]] = ProgressConfig

    def __init__(self, config: ProgressConfig) -> None:
        self._config = config
        self._since: tuple[SE2, float] | None = None

    def reset(self) -> None:
        self._since = None

    def check(self, pose: SE2, now: float) -> bool:
        if self._since is None or self._moved(self._since[0], pose):
            self._since = (pose, now)
            return True
        return now - self._since[1] <= self._config.movement_time_allowance

    def failure_message(self) -> str:
        config = self._config
        return (
            f"moved less than {config.required_movement_radius:g} m in "
            f"{config.movement_time_allowance:g} s"
        )

    def _moved(self, before: SE2, pose: SE2) -> bool:
        return before.distance(pose) > self._config.required_movement_radius


@dataclass(frozen=True)
class PoseProgressConfig(ProgressConfig):
    """Parameters of the pose progress checker, by Nav2's names."""

    required_movement_angle: float = angle_param(0.5, "Or angle to be turned in the time allowed.")


class PoseProgressChecker(SimpleProgressChecker):
    """Requires that the robot moves some distance or turns some angle in some time.

    Source: nav2_controller, PoseProgressChecker.
    """

    Config: ClassVar[type[Any]] = PoseProgressConfig

    _config: PoseProgressConfig

    def failure_message(self) -> str:
        angle = self._config.required_movement_angle
        return f"turned less than {angle:g} rad and {super().failure_message()}"

    def _moved(self, before: SE2, pose: SE2) -> bool:
        turned = abs(wrap(pose.theta - before.theta))
        return super()._moved(before, pose) or turned > self._config.required_movement_angle


def is_there(pose: SE2, goal: SE2, tolerance: float, was_there: bool, pushed: float = 0.15) -> bool:
    """Return whether a robot is at a goal, or still is: nobody has pushed it away.

    Args:
        goal: In the same frame.
        tolerance: Greatest distance from the goal [m].
        was_there: Whether it was there and is to be taken as there.
        pushed: Distance beyond the tolerance that only a push explains [m].
    """
    return pose.distance(goal) - tolerance <= (pushed if was_there else 0.0)


@dataclass(frozen=True)
class PositionGoalConfig:
    """Parameters of the position goal checker, by Nav2's names."""

    xy_goal_tolerance: float = length_param(0.25, "Distance from the goal.")
    stateful: bool = param(True, "Whether the position, once reached, counts as reached.")
    pushed_distance: float = length_param(
        0.15,
        "Distance beyond the tolerance from which it counts no more: the robot was pushed.",
        theirs=1e6,
    )
    path_length_tolerance: float = length_param(
        1.0,
        "How much longer than straight the way to the goal may be, else its loop is driven first.",
        theirs=1e6,
    )


class PositionGoalChecker:
    """Says whether the position is within its tolerance, whatever the heading.

    Source: nav2_controller, PositionGoalChecker.
    """

    Config: ClassVar[type[Any]] = PositionGoalConfig

    def __init__(self, config: Any) -> None:
        self._config = config
        self.xy_tolerance: float = config.xy_goal_tolerance
        self.detour: float = config.path_length_tolerance
        self._reached = False

    def reset(self) -> None:
        self._reached = False

    def reached(self, pose: SE2, goal: SE2, velocity: Velocity = STILL) -> bool:
        pushed = self._config.pushed_distance
        there = is_there(pose, goal, self.xy_tolerance, self._reached, pushed)
        self._reached = there and self._config.stateful
        return there


@dataclass(frozen=True)
class GoalConfig(PositionGoalConfig):
    """Parameters of the goal checker, by Nav2's names."""

    yaw_goal_tolerance: float = angle_param(0.25, "Angle from the goal's.")
    symmetric_yaw_tolerance: bool = param(False, "Whether the robot may arrive backwards.")


class SimpleGoalChecker(PositionGoalChecker):
    """Says whether position and heading are within their tolerances.

    Source: nav2_controller, SimpleGoalChecker.
    """

    Config: ClassVar[type[Any]] = GoalConfig

    def reached(self, pose: SE2, goal: SE2, velocity: Velocity = STILL) -> bool:
        if not super().reached(pose, goal, velocity):
            return False
        off = abs(wrap(goal.theta - pose.theta))
        if self._config.symmetric_yaw_tolerance:
            off = min(off, math.pi - off)
        return bool(off <= self._config.yaw_goal_tolerance)


@dataclass(frozen=True)
class StoppedGoalConfig(GoalConfig):
    """Parameters of the stopped goal checker, by Nav2's names."""

    trans_stopped_velocity: float = speed_param(0.25, "Speed that counts as standing.")
    rot_stopped_velocity: float = yaw_rate_param(0.25, "Yaw rate that counts as standing.")


class StoppedGoalChecker(SimpleGoalChecker):
    """Requires that the robot has arrived and stands.

    Source: nav2_controller, StoppedGoalChecker.
    """

    Config: ClassVar[type[Any]] = StoppedGoalConfig

    def reached(self, pose: SE2, goal: SE2, velocity: Velocity = STILL) -> bool:
        stands = (
            velocity.speed <= self._config.trans_stopped_velocity
            and abs(velocity.yaw_rate) <= self._config.rot_stopped_velocity
        )
        return super().reached(pose, goal, velocity) and stands
