"""Navigation to a goal: a behavior tree is ticked until it has come there or has failed.

The tree says when to plan, follow, clear, recover and give up; `behavior_trees/` holds the default
one and Nav2's, `trees/` the nodes.
"""

from __future__ import annotations

import enum
from collections.abc import Sequence
from dataclasses import dataclass, fields
from itertools import pairwise
from typing import Any

from arjuna_core.config import duration_param, length_param, param, share_param, speed_param
from arjuna_core.se2 import SE2
from arjuna_nav.planners import path as paths
from arjuna_nav.trees.asking import RECOVERIES
from arjuna_nav.trees.blackboard import TreeError
from arjuna_nav.trees.exchange import Ask, StatusChange, TreeState, Withdraw
from arjuna_nav.trees.node import Status, Tree

PROBLEM = "outage"
"""Entry of the blackboard that says why the robot stands and waits."""


@dataclass(frozen=True)
class NavigatorConfig:
    """Entries of each tree's blackboard, by these names; in Nav2's trees they are numbers."""

    replanning_frequency: float = param(1.0, "Plans a second.", unit="Hz", minimum=0.01)
    number_of_retries: int = param(6, "Most recoveries.", minimum=0)
    spin_dist: float = param(1.57, "Angle of the recovery spin.", unit="rad")
    wait_duration: float = duration_param(5.0, "Duration of the recovery wait.")
    backup_dist: float = length_param(0.30, "Distance of the recovery backup.")
    backup_speed: float = speed_param(0.15, "Speed of the recovery backup.")
    passed_goal_radius: float = length_param(
        0.7, "Distance at which a pose before the last counts as passed."
    )
    same_way_deviation: float = length_param(
        0.5, "Greatest distance between two paths that count as the same."
    )
    shorter_ratio: float = share_param(
        0.9, "Length of a path against the old that is clearly shorter."
    )
    blocked_memory: float = duration_param(
        20.0, "How long a path along one that was blocked is compared by `blocked_ratio`."
    )
    blocked_ratio: float = share_param(0.7, "`shorter_ratio` of such a path.")
    outage_patience: float = duration_param(
        30.0,
        "How long to stand where the robot's pose or its surroundings are not known.",
        theirs=0.0,
    )


class Ending(enum.Enum):
    """The ends of navigation."""

    SUCCEEDED = enum.auto()
    ABORTED = enum.auto()
    CANCELED = enum.auto()


@dataclass(frozen=True)
class Finish:
    """The end of navigation, with the error that ended it."""

    ending: Ending
    error_code: int = 0
    error_msg: str = ""


@dataclass(frozen=True)
class EntryNames:
    """The blackboard's entries of the goal, of all goals on the way to it, and of the path."""

    goal: str = "goal"
    goals: str = "goals"
    path: str = "path"


class Navigator:
    """Drives to one goal, or through several to the last, by a tree.

    Args:
        tree: The tree; its blackboard has the goals and the configuration's entries, and the path
            once there is one.
        error_code_names: Entries of the blackboard that hold error codes.
        goals: Poses to drive to, in map.
        start: Time at which the goal came [s].
        names: What the entries of goals and path are called.
    """

    def __init__(
        self,
        tree: Tree,
        config: NavigatorConfig,
        error_code_names: Sequence[str],
        goals: tuple[SE2, ...],
        start: float,
        names: EntryNames = EntryNames(),
    ) -> None:
        self._tree, self._names = tree, names
        self._board = tree.blackboard
        self._codes = tuple(error_code_names)
        self._start = start
        self._outdated = False
        self._path = self._board.entry(names.path)
        self._followed: object = None
        for each in fields(NavigatorConfig):
            self._board.set(each.name, getattr(config, each.name))
        self._take_goals(goals)

    def _take_goals(self, goals: tuple[SE2, ...]) -> None:
        self._board.set(self._names.goal, goals[-1])
        self._board.set(self._names.goals, goals)
        self._board.set(RECOVERIES, 0)

    def tick(
        self, state: TreeState, goals: tuple[SE2, ...] | None = None, cancel: bool = False
    ) -> tuple[list[Ask | Withdraw], Finish | None]:
        """Return the requests to servers, in order, and once the end; `cancel` stops for good."""
        if cancel:
            return self._tree.halt(state), Finish(Ending.CANCELED)
        if goals is not None:
            self._take_goals(goals)
            self._start = state.now
            self._outdated = self._followed is not None  # its end is no success any more
        try:
            status, requests = self._tree.tick(state)
        except TreeError as error:
            return self._tree.halt(state), Finish(Ending.ABORTED, 0, str(error))
        if self._path.value is not self._followed:
            self._followed, self._outdated = self._path.value, False
        if status is Status.SUCCESS and not self._outdated:
            return requests, Finish(Ending.SUCCEEDED)
        going_on = status in (Status.RUNNING, Status.SUCCESS)
        return requests, None if going_on else self._failure()

    def _failure(self) -> Finish:
        """Return the end with the lowest of the error codes on the blackboard, as Nav2 does.

        Where the tree has no port for messages, it is what the code's action said.
        """
        codes = [(code, name) for name in self._codes for code in [self._board.get(name)] if code]
        said = self._tree.failures
        if not codes:
            last = next((f": {text}" for text in reversed(said.values()) if text), "")
            reason = f"the behavior tree failed, without an error code{last}"
            return Finish(Ending.ABORTED, 0, reason)
        code, name = min(codes)
        message = self._board.get(name.replace("error_code", "error_msg")) or said.get(int(code))
        return Finish(Ending.ABORTED, int(code), str(message or f"error code {code}"))

    def trouble(self) -> str:
        """Return why the robot stands and waits now, empty where it does not."""
        return str(self._board.get(PROBLEM) or "")

    def feedback(self, state: TreeState) -> dict[str, Any]:
        """Return the progress by the fields of NavigateToPose's feedback, in plain values.

        Before there is a path the distance is the straight one: clients take 0 for an arrival.

        Source: nav2_bt_navigator: the time remaining is distance by speed where the speed is above
            0.01 m/s and the distance above 0.1 m.
        """
        path, distance = self._path.value, 0.0
        speed, goals = state.mean_velocity().speed, self._board.get(self._names.goals)
        if path is not None and len(path) and state.pose is not None:
            distance = paths.remaining(path, state.pose)
        elif goals and state.pose is not None:
            distance = sum(a.distance(b) for a, b in pairwise((state.pose, *goals)))
        known = {} if state.pose is None else {"current_pose": state.pose}
        return known | {
            "navigation_time": state.now - self._start,
            "estimated_time_remaining": distance / speed
            if speed > 0.01 and distance > 0.1
            else 0.0,
            "number_of_recoveries": int(self._board.get(RECOVERIES) or 0),
            "distance_remaining": distance,
            "number_of_poses_remaining": len(goals or ()),
        }

    def take_changes(self) -> tuple[StatusChange, ...]:
        """Return the nodes' changes of status since the last call."""
        return self._tree.take_changes()
