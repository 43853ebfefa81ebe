"""Navigation to a goal: when to plan, follow, clear, recover and give up.

The rules are those of Nav2's default tree, navigate_to_pose_w_replanning_and_recovery:

1. Plan, follow the path, and plan again each second while following.
2. Where planning fails, clear the global costmap and try once more; where following fails, clear
   the local costmap and try once more.
3. Where that fails too, recover: clear both costmaps, spin, wait or back up, one after the other
   in turn; then start over. After six recoveries, or at an error no recovery mends, give up.

Two rules are ours. Where the robot's place or what is round it is not known (TF_ERROR, or a costmap
is too old), it stands and tries again each second, for a while: no recovery mends that, and to
clear costmaps in the dark is none. And a path is kept while it is free, unless the new one is
nearly the same or clearly shorter, so that the robot does not waver between two ways round an
obstacle.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from arjuna_core.config import param
from arjuna_core.se2 import SE2
from arjuna_nav.attempt import Attempt, Step
from arjuna_nav.commands import (
    GLOBAL_COSTMAP,
    LOCAL_COSTMAP,
    CheckPath,
    Clear,
    Command,
    ComputePath,
    Ending,
    Feedback,
    Finish,
    Follow,
    NavigatorState,
    Outcome,
    Recover,
    Recovery,
    Stop,
    progress,
)
from arjuna_nav.controllers.base import ControlStatus
from arjuna_nav.planners import path as paths
from arjuna_nav.planners.base import PlanStatus

PLAN_ERRORS_TO_RETRY = frozenset({PlanStatus.UNKNOWN, PlanStatus.NO_VALID_PATH})
FOLLOW_ERRORS_TO_RETRY = frozenset(
    {
        ControlStatus.UNKNOWN,
        ControlStatus.PATIENCE_EXCEEDED,
        ControlStatus.FAILED_TO_MAKE_PROGRESS,
        ControlStatus.NO_VALID_CONTROL,
    }
)
OUTAGES = frozenset(
    {
        PlanStatus.TF_ERROR,
        PlanStatus.TIMEOUT,
        ControlStatus.TF_ERROR,
        ControlStatus.CONTROLLER_TIMED_OUT,
    }
)


@dataclass(frozen=True)
class NavigatorConfig:
    """What Nav2's default tree has written into it."""

    replanning_frequency: float = param(1.0, "Plans a second.", unit="Hz", minimum=0.01)
    number_of_retries: int = param(6, "Most recoveries.", minimum=0)
    spin_dist: float = param(1.57, "Angle of the recovery spin.", unit="rad")
    wait_duration: float = param(5.0, "Duration of the recovery wait.", unit="s", minimum=0.0)
    backup_dist: float = param(0.30, "Distance of the recovery backup.", unit="m", minimum=0.0)
    backup_speed: float = param(0.15, "Speed of the recovery backup.", unit="m/s", minimum=0.0)
    passed_goal_radius: float = param(
        0.7, "Distance at which a pose on the way counts as passed.", unit="m", minimum=0.0
    )
    same_way_deviation: float = param(
        0.5, "How far apart two paths may be and be the same way.", unit="m", minimum=0.0
    )
    shorter_ratio: float = param(
        0.9, "Length of a path against the old that is clearly shorter.", minimum=0.0, maximum=1.0
    )
    outage_patience: float = param(
        30.0,
        "How long to stand where the place or the surroundings are not known.",
        unit="s",
        minimum=0.0,
    )


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
    _planning: Attempt = field(
        default_factory=lambda: Attempt(GLOBAL_COSTMAP, PLAN_ERRORS_TO_RETRY)
    )
    _following: Attempt = field(
        default_factory=lambda: Attempt(LOCAL_COSTMAP, FOLLOW_ERRORS_TO_RETRY)
    )
    _recovery: Recovery | None = None
    _turn: int = 0
    _still_to_clear: frozenset[str] = frozenset()
    _asked_at: float = -np.inf
    _path_valid: bool | None = None
    _path_outdated: bool = False
    _outage: Outcome = field(default_factory=Outcome)
    _outage_since: float = -np.inf
    _outage_at: float = -np.inf

    def trouble(self, now: float) -> str:
        """Return why the robot stands and waits now, empty where it does not."""
        return self._outage.message if now - self._outage_at < 2.0 * self._period else ""

    @property
    def _period(self) -> float:
        return 1.0 / self.config.replanning_frequency

    def tick(self, state: NavigatorState) -> list[Command]:
        """Return what to do now, in order; what is not named goes on as it is."""
        if state.cancel:
            return [Finish(Ending.CANCELED)]
        commands = [] if state.goals is None else self._take_goals(state.goals)
        if self._recovery is not None:
            commands += self._recover(state)
        if self._recovery is None:
            commands += self._navigate(state)
        return commands

    def feedback(self, state: NavigatorState) -> Feedback:
        """Return how it goes."""
        return progress(state, self.start, self.path, self.recoveries, len(self.goals))

    def _take_goals(self, goals: tuple[SE2, ...]) -> list[Command]:
        """Go somewhere else; the old path is followed until the new one is there."""
        self.goals = goals
        self._path_outdated = True
        self._planning.reset()
        self._asked_at = -np.inf
        if self._recovery is None:
            return []
        self._recovery = None
        return [Stop()]

    def _navigate(self, state: NavigatorState) -> list[Command]:
        """Follow the path and plan the next; an outcome that stands ends both."""
        followed = self._follow(state)
        if isinstance(followed, Outcome):
            return self._finish_or_recover(followed, state.now)
        planned = self._plan(state)
        if isinstance(planned, Outcome):
            return self._finish_or_recover(planned, state.now)
        return followed + planned

    def _follow(self, state: NavigatorState) -> list[Command] | Outcome:
        """Take how following ended; the path of a goal that was replaced leads to no success."""
        attempt = self._following
        if attempt.is_cleared(state) and self.path is not None:
            attempt.step = Step.RUNNING
            return [Follow(self.path)]
        if attempt.step is not Step.RUNNING or state.follow is None:
            return []
        if state.follow.code:
            self._path_outdated = True  # it led into trouble: the next one is better
            return attempt.failed(state.follow)
        attempt.step = Step.IDLE
        return [] if self._path_outdated else state.follow

    def _plan(self, state: NavigatorState) -> list[Command] | Outcome:
        """Ask for paths and take them."""
        attempt = self._planning
        if state.path_valid is not None:
            self._path_valid = state.path_valid
        if attempt.step is Step.RUNNING and state.plan is not None:
            if state.plan.status is not PlanStatus.SUCCEEDED:
                return attempt.failed(Outcome(state.plan.status, state.plan.message))
            attempt.reset()
            keeps = self._keeps_path(state.plan.path, state.T_map_base)
            return [] if keeps else self._take_path(state.plan.path)
        due = attempt.step is Step.IDLE and self._is_replanning_due(state.now)
        return self._ask_path(state) if due or attempt.is_cleared(state) else []

    def _is_replanning_due(self, now: float) -> bool:
        if now - self._outage_at < self._period:
            return False
        return self.path is None or now - self._asked_at >= self._period

    def _ask_path(self, state: NavigatorState) -> list[Command]:
        self._drop_passed_goals(state.T_map_base)
        self._planning.step = Step.RUNNING
        self._asked_at, self._path_valid = state.now, None
        check = [] if self.path is None else [CheckPath(self.path)]
        return [*check, ComputePath(self.goals)]

    def _drop_passed_goals(self, T_map_base: SE2 | None) -> None:
        radius = self.config.passed_goal_radius
        while len(self.goals) > 1 and T_map_base and T_map_base.distance(self.goals[0]) <= radius:
            self.goals = self.goals[1:]

    def _keeps_path(self, new: NDArray[np.float64], T_map_base: SE2 | None) -> bool:
        """Tell whether to stay on the present path although there is a new one."""
        if self.path is None or T_map_base is None or self._path_outdated or not self._path_valid:
            return False
        rest = paths.ahead(self.path, T_map_base)
        beside = T_map_base.distance(SE2.from_array(rest[0]))
        if beside > self.config.same_way_deviation:
            return False  # the robot is not on it any more
        if paths.deviation(new, rest) <= self.config.same_way_deviation:
            return False
        return paths.length(new) > self.config.shorter_ratio * (beside + paths.length(rest))

    def _take_path(self, path: NDArray[np.float64]) -> list[Command]:
        self.path, self._path_outdated = path, False
        if self._following.step is Step.CLEARING:
            return []
        self._following.step = Step.RUNNING
        return [Follow(path)]

    def _finish_or_recover(self, outcome: Outcome, now: float) -> list[Command]:
        if outcome.code == 0:
            return [Finish(Ending.SUCCEEDED)]
        self.path = None
        self._planning.reset()
        self._following.reset()
        if outcome.code in OUTAGES and self._bears(outcome, now):
            return [Stop()]
        mendable = outcome.code in PLAN_ERRORS_TO_RETRY | FOLLOW_ERRORS_TO_RETRY
        if not mendable or self.recoveries >= self.config.number_of_retries:
            return [Finish(Ending.ABORTED, outcome.code, outcome.message)]
        self.recoveries += 1
        return [Stop(), *self._next_recovery()]

    def _bears(self, outage: Outcome, now: float) -> bool:
        """Tell whether to wait for the end of an outage; one goes on while each try fails."""
        if now - self._outage_at > 3.0 * self._period:
            self._outage_since = now
        self._outage, self._outage_at = outage, now
        return now - self._outage_since < self.config.outage_patience

    def _next_recovery(self) -> list[Command]:
        kinds = tuple(Recovery)
        self._recovery = kinds[self._turn % len(kinds)]
        self._turn += 1
        if self._recovery is not Recovery.CLEAR:
            return [Recover(self._recovery)]
        self._still_to_clear = frozenset({LOCAL_COSTMAP, GLOBAL_COSTMAP})
        return [Clear(LOCAL_COSTMAP), Clear(GLOBAL_COSTMAP)]

    def _recover(self, state: NavigatorState) -> list[Command]:
        """Wait for the recovery's end; where one fails, the next is tried in its place."""
        if self._recovery is Recovery.CLEAR:
            self._still_to_clear -= state.cleared
            if not self._still_to_clear:
                self._recovery = None
        elif state.behavior is not None:
            if state.behavior.code:
                return self._next_recovery()  # ends: clearing never fails
            self._recovery = None
        return []
