"""Navigation to a goal: when to plan, follow, clear, recover and give up.

The rules are those of Nav2's default tree, navigate_to_pose_w_replanning_and_recovery:

1. Plan, follow the path, and plan again each second while following.
2. Where planning fails, clear the global costmap and try once more; where following fails, clear
   the local costmap and try once more.
3. Where that fails too, recover: clear both costmaps, spin, wait or back up, one after the other
   in turn; then start over. After six recoveries, or at an error no recovery mends, give up.

One rule is ours: a path is kept while it is free, unless the new one is nearly the same or clearly
shorter, so that the robot does not waver between two ways round an obstacle.
"""

from __future__ import annotations

import enum
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from arjuna_core.config import param
from arjuna_core.se2 import SE2
from arjuna_nav.controllers.base import ControlStatus
from arjuna_nav.planners import path as paths
from arjuna_nav.planners.base import PlanResult, PlanStatus

GLOBAL_COSTMAP = "global_costmap"
LOCAL_COSTMAP = "local_costmap"
PLAN_ERRORS_TO_RETRY = frozenset({PlanStatus.UNKNOWN, PlanStatus.TIMEOUT, PlanStatus.NO_VALID_PATH})
FOLLOW_ERRORS_TO_RETRY = frozenset(
    {
        ControlStatus.UNKNOWN,
        ControlStatus.PATIENCE_EXCEEDED,
        ControlStatus.FAILED_TO_MAKE_PROGRESS,
        ControlStatus.NO_VALID_CONTROL,
    }
)


class Recovery(enum.Enum):
    """What is done in turn to get on again."""

    CLEAR = enum.auto()
    SPIN = enum.auto()
    WAIT = enum.auto()
    BACK_UP = enum.auto()


class Ending(enum.Enum):
    """How navigation ended."""

    SUCCEEDED = enum.auto()
    ABORTED = enum.auto()
    CANCELED = enum.auto()


@dataclass(frozen=True)
class NavigatorConfig:
    """What Nav2's default tree has written into it."""

    replanning_frequency: float = param(1.0, "plans a second", unit="Hz", minimum=0.01)
    number_of_retries: int = param(6, "most recoveries", minimum=0)
    spin_dist: float = param(1.57, "angle of the recovery spin", unit="rad")
    wait_duration: float = param(5.0, "duration of the recovery wait", unit="s", minimum=0.0)
    backup_dist: float = param(0.30, "distance of the recovery backup", unit="m", minimum=0.0)
    backup_speed: float = param(0.15, "speed of the recovery backup", unit="m/s", minimum=0.0)
    passed_goal_radius: float = param(
        0.7, "distance at which a pose on the way counts as passed", unit="m", minimum=0.0
    )
    same_way_deviation: float = param(
        0.5, "how far apart two paths may be and be the same way", unit="m", minimum=0.0
    )
    shorter_ratio: float = param(
        0.9, "length of a path against the old that is clearly shorter", minimum=0.0, maximum=1.0
    )


@dataclass(frozen=True)
class Outcome:
    """How something asked for ended.

    Attributes:
        code: nav2_msgs' error code, 0 for success.
        message: What went wrong; empty on success.
    """

    code: int = 0
    message: str = ""


@dataclass(frozen=True)
class NavigatorState:
    """What the navigator is told at each tick. Outcomes are told once.

    Attributes:
        now: Time [s].
        T_map_base: Pose of the robot, None where it is not known.
        speed: Forward speed [m/s].
        plan: Outcome of the path asked for last.
        path_valid: Whether the path asked about last is free.
        follow: Outcome of following the path given last.
        behavior: Outcome of the recovery asked for last.
        cleared: Costmaps that have been cleared.
        goals: New goals, to be gone to from now on.
        cancel: Whether to stop for good.
    """

    now: float
    T_map_base: SE2 | None = None
    speed: float = 0.0
    plan: PlanResult | None = None
    path_valid: bool | None = None
    follow: Outcome | None = None
    behavior: Outcome | None = None
    cleared: frozenset[str] = frozenset()
    goals: tuple[SE2, ...] | None = None
    cancel: bool = False


@dataclass(frozen=True)
class Finish:
    """How navigation ended, with the error that ended it."""

    ending: Ending
    error_code: int = 0
    error_msg: str = ""


@dataclass
class Command:
    """What to do now. What is not named goes on as it is.

    Attributes:
        stop: Stop following and any recovery; comes before all else.
        clear: Costmaps to clear.
        check_path: Path to be checked for obstacles, at once with `compute_path`.
        compute_path: Goals to plan through from where the robot is, the last one to end at.
        follow: Path to follow from now on.
        recovery: Recovery behaviour to run; never CLEAR, which `clear` says.
        finish: The end; nothing comes after it.
    """

    stop: bool = False
    clear: tuple[str, ...] = ()
    check_path: NDArray[np.float64] | None = None
    compute_path: tuple[SE2, ...] | None = None
    follow: NDArray[np.float64] | None = None
    recovery: Recovery | None = None
    finish: Finish | None = None


@dataclass(frozen=True)
class Feedback:
    """How navigation goes, as NavigateToPose's feedback has it.

    Attributes:
        navigation_time: Since the goal came [s].
        estimated_time_remaining: At the present speed [s]; 0 where that says nothing.
        number_of_recoveries: So far.
        distance_remaining: Along the path [m].
        number_of_poses_remaining: Goals not yet passed.
    """

    navigation_time: float
    estimated_time_remaining: float
    number_of_recoveries: int
    distance_remaining: float
    number_of_poses_remaining: int


class _Step(enum.Enum):
    IDLE = enum.auto()
    RUNNING = enum.auto()
    CLEARING = enum.auto()


@dataclass
class _Attempt:
    """Something that is tried once more after a costmap was cleared."""

    costmap: str
    retryable: frozenset[int]
    step: _Step = _Step.IDLE
    retried: bool = False

    def reset(self) -> None:
        self.step, self.retried = _Step.IDLE, False

    def fail(self, outcome: Outcome, command: Command) -> Outcome | None:
        """Clear for another try and return None, or return the outcome that stands."""
        if self.retried or outcome.code not in self.retryable:
            self.reset()
            return outcome
        self.step, self.retried = _Step.CLEARING, True
        command.clear += (self.costmap,)
        return None


@dataclass
class Navigator:
    """Goes to one goal, or through several to the last.

    Args:
        config: Rates and amounts.
        goals: Where to go, in map.
        start: Time at which the goal came [s].
    """

    config: NavigatorConfig
    goals: tuple[SE2, ...]
    start: float
    recoveries: int = 0
    path: NDArray[np.float64] | None = None
    _planning: _Attempt = field(
        default_factory=lambda: _Attempt(GLOBAL_COSTMAP, PLAN_ERRORS_TO_RETRY)
    )
    _following: _Attempt = field(
        default_factory=lambda: _Attempt(LOCAL_COSTMAP, FOLLOW_ERRORS_TO_RETRY)
    )
    _recovery: Recovery | None = None
    _turn: int = 0
    _still_to_clear: frozenset[str] = frozenset()
    _asked_at: float = -np.inf
    _path_valid: bool | None = None
    _path_outdated: bool = False

    def tick(self, state: NavigatorState) -> Command:
        """Return what to do now, given what has happened since the last tick."""
        command = Command()
        if state.cancel:
            return self._finish(command, Ending.CANCELED, Outcome())
        if state.goals is not None:
            self._take_goals(state.goals, command)
        if self._recovery is not None:
            self._recover(state, command)
        if self._recovery is None and command.finish is None:
            self._navigate(state, command)
        return command

    def feedback(self, state: NavigatorState) -> Feedback:
        """Return how it goes.

        Source: nav2_bt_navigator: the time left is distance by speed where the speed is above
            0.01 m/s and the distance above 0.1 m.
        """
        distance = 0.0
        if self.path is not None and state.T_map_base is not None:
            distance = paths.remaining(self.path, state.T_map_base)
        speed = abs(state.speed)
        left = distance / speed if speed > 0.01 and distance > 0.1 else 0.0
        return Feedback(state.now - self.start, left, self.recoveries, distance, len(self.goals))

    def _take_goals(self, goals: tuple[SE2, ...], command: Command) -> None:
        """Go somewhere else; the old path is followed until the new one is there."""
        self.goals = goals
        self._path_outdated = True
        self._planning.reset()
        self._asked_at = -np.inf
        if self._recovery is not None:
            self._recovery = None
            command.stop = True

    def _navigate(self, state: NavigatorState, command: Command) -> None:
        failure = self._plan(state, command) or self._follow(state, command)
        if failure is not None:
            self._give_up_or_recover(failure, command)

    def _plan(self, state: NavigatorState, command: Command) -> Outcome | None:
        """Ask for paths and take them; return a failure that stands."""
        attempt = self._planning
        if state.path_valid is not None:
            self._path_valid = state.path_valid
        if attempt.step is _Step.CLEARING and attempt.costmap in state.cleared:
            self._ask_path(state, command)
        elif attempt.step is _Step.RUNNING and state.plan is not None:
            if state.plan.status is not PlanStatus.SUCCEEDED:
                return attempt.fail(Outcome(state.plan.status, state.plan.message), command)
            attempt.reset()
            if not self._keeps_path(state.plan.path, state.T_map_base):
                self._take_path(state.plan.path, command)
        elif attempt.step is _Step.IDLE and self._is_replanning_due(state.now):
            self._ask_path(state, command)
        return None

    def _is_replanning_due(self, now: float) -> bool:
        return self.path is None or now - self._asked_at >= 1.0 / self.config.replanning_frequency

    def _ask_path(self, state: NavigatorState, command: Command) -> None:
        self._drop_passed_goals(state.T_map_base)
        self._planning.step = _Step.RUNNING
        self._asked_at, self._path_valid = state.now, None
        command.compute_path = self.goals
        command.check_path = self.path

    def _drop_passed_goals(self, T_map_base: SE2 | None) -> None:
        radius = self.config.passed_goal_radius
        while len(self.goals) > 1 and T_map_base and T_map_base.distance(self.goals[0]) <= radius:
            self.goals = self.goals[1:]

    def _keeps_path(self, new: NDArray[np.float64], T_map_base: SE2 | None) -> bool:
        """Tell whether to stay on the present path although there is a new one."""
        if self.path is None or T_map_base is None or self._path_outdated or not self._path_valid:
            return False
        rest = paths.ahead(self.path, T_map_base)
        if paths.deviation(new, rest) <= self.config.same_way_deviation:
            return False
        return paths.length(new) > self.config.shorter_ratio * paths.length(rest)

    def _take_path(self, path: NDArray[np.float64], command: Command) -> None:
        self.path, self._path_outdated = path, False
        if self._following.step is not _Step.CLEARING:
            self._following.step = _Step.RUNNING
            command.follow = path

    def _follow(self, state: NavigatorState, command: Command) -> Outcome | None:
        """Take how following ended; return a failure that stands."""
        attempt = self._following
        if attempt.step is _Step.CLEARING and attempt.costmap in state.cleared:
            attempt.step, command.follow = _Step.RUNNING, self.path
        elif attempt.step is _Step.RUNNING and state.follow is not None:
            if state.follow.code:
                self._path_outdated = True  # it led into trouble: the next one is better
                return attempt.fail(state.follow, command)
            attempt.step = _Step.IDLE
            if not self._path_outdated and command.follow is None:
                self._finish(command, Ending.SUCCEEDED, Outcome())
        return None

    def _give_up_or_recover(self, failure: Outcome, command: Command) -> None:
        self.path = None
        self._planning.reset()
        self._following.reset()
        mendable = failure.code in PLAN_ERRORS_TO_RETRY | FOLLOW_ERRORS_TO_RETRY
        if not mendable or self.recoveries >= self.config.number_of_retries:
            self._finish(command, Ending.ABORTED, failure)
            return
        command.stop, command.clear = True, ()
        command.compute_path = command.check_path = command.follow = None
        self.recoveries += 1
        self._next_recovery(command)

    def _next_recovery(self, command: Command) -> None:
        kinds = tuple(Recovery)
        self._recovery = kinds[self._turn % len(kinds)]
        self._turn += 1
        if self._recovery is Recovery.CLEAR:
            command.clear = (LOCAL_COSTMAP, GLOBAL_COSTMAP)
            self._still_to_clear = frozenset(command.clear)
        else:
            command.recovery = self._recovery

    def _recover(self, state: NavigatorState, command: Command) -> None:
        """Wait for the recovery's end; where one fails, the next is tried in its place."""
        if self._recovery is Recovery.CLEAR:
            self._still_to_clear -= state.cleared
            if not self._still_to_clear:
                self._recovery = None
        elif state.behavior is not None and state.behavior.code == 0:
            self._recovery = None
        elif state.behavior is not None:
            self._next_recovery(command)  # ends: clearing never fails

    def _finish(self, command: Command, ending: Ending, error: Outcome) -> Command:
        command.stop, command.clear = True, ()
        command.check_path = command.compute_path = command.follow = None
        command.finish = Finish(ending, error.code, error.message)
        return command
