"""Nav2's own nodes with several children.

Source: nav2_behavior_tree, plugins/control.
"""

from __future__ import annotations

from typing import ClassVar

from arjuna_nav.trees.node import Control, Status
from arjuna_nav.trees.ports import WHOLE, Port

_ROUNDS = 100  # of children that end at once in one tick; what is left waits for the next


class PipelineSequence(Control):
    """A sequence that ticks all children up to the one that has come farthest, again and again."""

    _last = 0

    def tick(self) -> Status:
        """Tick from the first child; one behind the farthest may run on beside it."""
        self.set_status(Status.RUNNING)
        for index, child in enumerate(self.children):
            status = child.execute()
            if status is Status.FAILURE:
                return self._end(status)
            if status is Status.RUNNING and index >= self._last:
                self._last = index
                return status
        return self._end(Status.SUCCESS)

    def _end(self, status: Status) -> Status:
        self.reset_children()
        self._last = 0
        return status

    def on_halt(self) -> None:
        """Begin with the first child next time."""
        self._last = 0


class RecoveryNode(Control):
    """Runs the second child where the first fails, then the first again, so often and no more."""

    PORTS: ClassVar[dict[str, Port]] = {"number_of_retries": Port(WHOLE, 1)}
    CHILDREN = (2, 2)
    _retries = 0
    _recovering = False

    def tick(self) -> Status:
        """Tick the child whose turn it is."""
        self.set_status(Status.RUNNING)
        for _ in range(_ROUNDS):
            status = self.children[self._recovering].execute()
            if status is Status.RUNNING:
                return status
            if self._recovering:
                if status is not Status.SUCCESS:
                    return self._end(Status.FAILURE)
                self._retries += 1
            elif status is not Status.FAILURE or self._retries >= self.get("number_of_retries"):
                return self._end(status)
            self.children[self._recovering].reset()
            self._recovering = not self._recovering
        return Status.RUNNING

    def _end(self, status: Status) -> Status:
        self.reset_children()
        self.on_halt()
        return status

    def on_halt(self) -> None:
        """Begin with the first child next time, all retries left."""
        self._retries, self._recovering = 0, False


class RoundRobin(Control):
    """Ticks one child until it ends; the next time the next one; fails when all have in a row."""

    _index = 0
    _failed = 0

    def tick(self) -> Status:
        """Tick the child whose turn it is, and those after it while they fail."""
        self.set_status(Status.RUNNING)
        while self._failed < len(self.children):
            status = self.children[self._index].execute()
            if status is Status.RUNNING:
                return status
            self._index = (self._index + 1) % len(self.children)
            if status is Status.SUCCESS:
                self._failed = 0
                self.reset_children()
                return status
            self._failed += 1
        self.reset_children()
        self.on_halt()
        return Status.FAILURE

    def on_halt(self) -> None:
        """Begin with the first child next time."""
        self._index = self._failed = 0
