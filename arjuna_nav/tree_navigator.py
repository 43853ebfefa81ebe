"""Navigation by a behavior tree, in the place of the navigator's own rules."""

from __future__ import annotations

from collections.abc import Sequence

from arjuna_core.se2 import SE2
from arjuna_nav.commands import Command, Ending, Feedback, Finish, NavigatorState, progress
from arjuna_nav.trees.asking import RECOVERIES
from arjuna_nav.trees.exchange import StatusChange, Topic
from arjuna_nav.trees.node import Status, Tree
from arjuna_nav.trees.ports import TreeError


class TreeNavigator:
    """Goes to one goal, or through several to the last, as a tree says.

    Args:
        tree: The tree; its blackboard has `goal` and `goals`, and `path` once there is one.
        error_code_names: Entries of the blackboard that hold error codes.
        goals: Where to go, in map.
        start: Time at which the goal came [s].
    """

    def __init__(
        self, tree: Tree, error_code_names: Sequence[str], goals: tuple[SE2, ...], start: float
    ) -> None:
        self._tree = tree
        self._codes = tuple(error_code_names)
        self.start = start
        self._outdated = False
        self._path: object = None
        self._take_goals(goals)

    @property
    def topics(self) -> set[Topic]:
        """The topics that the tree must be told of."""
        return self._tree.topics

    def tick(self, state: NavigatorState) -> list[Command]:
        """Return what to do now, in order; what is not named goes on as it is."""
        if state.cancel:
            return [*self._tree.halt(state.tree), Finish(Ending.CANCELED)]
        if state.goals is not None:
            self._take_goals(state.goals)
            self._outdated = self._path is not None  # it leads to where nobody wants to be any more
        try:
            status, asked = self._tree.tick(state.tree)
        except TreeError as error:
            return [*self._tree.halt(state.tree), Finish(Ending.ABORTED, 0, str(error))]
        path = self._tree.blackboard.get("path")
        if path is not self._path:
            self._path, self._outdated = path, False
        if status is Status.SUCCESS and not self._outdated:
            return [*asked, Finish(Ending.SUCCEEDED)]
        if status in (Status.RUNNING, Status.SUCCESS):
            return [*asked]
        return [*asked, self._failure()]

    def _take_goals(self, goals: tuple[SE2, ...]) -> None:
        board = self._tree.blackboard
        board.set("goal", goals[-1])
        board.set("goals", goals)
        board.set(RECOVERIES, 0)

    def _failure(self) -> Finish:
        """Say why the tree failed: by the lowest of the error codes on the blackboard."""
        board = self._tree.blackboard
        codes = [(code, name) for name in self._codes for code in [board.get(name)] if code]
        if not codes:
            return Finish(Ending.ABORTED, 0, "the behavior tree failed, without an error code")
        code, name = min(codes)
        message = board.get(name.replace("error_code", "error_msg"))
        return Finish(Ending.ABORTED, int(code), str(message or f"error code {code}"))

    def feedback(self, state: NavigatorState) -> Feedback:
        """Return how it goes."""
        board = self._tree.blackboard
        recoveries, left = int(board.get(RECOVERIES) or 0), len(board.get("goals") or ())
        return progress(state, self.start, board.get("path"), recoveries, left)

    def take_changes(self) -> tuple[StatusChange, ...]:
        """Return which nodes changed their status since this was asked last."""
        return self._tree.take_changes()
