"""Following a path to its end: controller, progress and goal checker together."""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from arjuna_core.config import param
from arjuna_core.se2 import SE2
from arjuna_core.twist import STILL, Velocity
from arjuna_nav.controllers import (
    ControlStatus,
    RegulatedPurePursuit,
    RegulatedPurePursuitConfig,
)
from arjuna_nav.controllers.checkers import (
    GoalConfig,
    ProgressConfig,
    SimpleGoalChecker,
    SimpleProgressChecker,
)
from arjuna_nav.costmap import Costmap
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.planners import path as paths


@dataclass(frozen=True)
class FollowerConfig:
    """Parameters of following, by Nav2's names."""

    controller_frequency: float = param(
        20.0, "Commands a second.", unit="Hz", minimum=1.0, read_only=True
    )
    failure_tolerance: float = param(
        0.3, "How long a controller may fail before following does; below 0 for ever.", unit="s"
    )
    FollowPath: RegulatedPurePursuitConfig = field(default_factory=RegulatedPurePursuitConfig)
    progress_checker: ProgressConfig = field(default_factory=ProgressConfig)
    general_goal_checker: GoalConfig = field(default_factory=GoalConfig)


class FollowState(enum.Enum):
    """How following goes."""

    RUNNING = enum.auto()
    SUCCEEDED = enum.auto()
    FAILED = enum.auto()


@dataclass(frozen=True)
class FollowResult:
    """What to drive now, and how following goes.

    Attributes:
        state: Whether it goes on.
        velocity: What to drive.
        error: Why it failed.
        message: What went wrong, with numbers; empty while it goes well.
        distance: Left along the path [m].
    """

    state: FollowState
    velocity: Velocity = STILL
    error: ControlStatus = ControlStatus.SUCCEEDED
    message: str = ""
    distance: float = 0.0

    @staticmethod
    def failed(error: ControlStatus, message: str) -> FollowResult:
        """Return the end of a path that is not followed any more."""
        return FollowResult(FollowState.FAILED, error=error, message=message)


class PathFollower:
    """Runs a controller until the goal checker says that the robot has arrived.

    Args:
        config: Parameters.
        footprint: The robot.

    Attributes:
        speed_limit: Greatest forward speed from now on [m/s]; inf for none.

    Source: nav2_controller, ControllerServer::computeControl.
    """

    def __init__(self, config: FollowerConfig, footprint: Footprint) -> None:
        self._config = config
        self._footprint = footprint
        self._progress = SimpleProgressChecker(config.progress_checker)
        self._goal = SimpleGoalChecker(config.general_goal_checker)
        self._controller = self._make_controller()
        self._end: SE2 | None = None
        self._failing_since: float | None = None
        self.speed_limit = math.inf

    @property
    def carrot(self) -> SE2 | None:
        """What the controller aims at, seen from the robot; None where it aims at nothing."""
        return self._controller.carrot

    def _make_controller(self) -> RegulatedPurePursuit:
        config = self._config
        tolerance = config.general_goal_checker.xy_goal_tolerance
        period = 1.0 / config.controller_frequency
        return RegulatedPurePursuit(config.FollowPath, self._footprint, tolerance, period)

    def start(self, path: NDArray[np.float64], now: float) -> None:
        """Follow a path from now [s] on, as a new task."""
        self._progress.reset()
        self._goal.reset()
        self._failing_since = None
        self._controller = self._make_controller()  # the last goal's arrival is not this one's
        self.change(path)

    def change(self, path: NDArray[np.float64]) -> None:
        """Follow another path to the same or a new end; progress goes on being counted.

        Raises:
            PathError: The path is empty or of the wrong shape.
        """
        self._controller.set_path(path)
        end = SE2.from_array(path[-1])
        if self._end is not None and self._end.distance(end) > 1e-3:
            self._goal.reset()
        self._end = end

    def tick(self, pose: SE2, velocity: Velocity, costmap: Costmap, now: float) -> FollowResult:
        """Return what to drive; pose and costmap are of the path's frame."""
        assert self._end is not None
        if not self._progress.check(pose, now):
            return FollowResult.failed(ControlStatus.FAILED_TO_MAKE_PROGRESS, self._no_progress())
        if self._goal.reached(pose, self._end):
            return FollowResult(FollowState.SUCCEEDED)
        self._controller.speed_limit = self.speed_limit
        control = self._controller.compute(pose, velocity, costmap, now)
        distance = paths.length(self._controller.path)
        if control.status is ControlStatus.SUCCEEDED:
            self._failing_since = None
            return FollowResult(FollowState.RUNNING, control.velocity, distance=distance)
        return self._bear(control.status, control.message, now, distance)

    def _bear(
        self, status: ControlStatus, message: str, now: float, distance: float
    ) -> FollowResult:
        """Stand still while a controller fails for less than the tolerance."""
        if self._failing_since is None:
            self._failing_since = now
        tolerance = self._config.failure_tolerance
        if tolerance < 0.0 or now - self._failing_since < tolerance:
            return FollowResult(FollowState.RUNNING, message=message, distance=distance)
        exceeded = ControlStatus.PATIENCE_EXCEEDED if tolerance > 0.0 else status
        return FollowResult.failed(exceeded, f"{message}; for over {tolerance:g} s")

    def _no_progress(self) -> str:
        config = self._config.progress_checker
        return (
            f"moved less than {config.required_movement_radius:g} m in "
            f"{config.movement_time_allowance:g} s"
        )
