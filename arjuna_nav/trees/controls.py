"""BehaviorTree.CPP's nodes with several children.

A reactive node stops a child that runs when another takes its place, and leaves the statuses of the
others as they are, so that a condition such as GoalUpdated remembers what it saw.
"""

from __future__ import annotations

from typing import ClassVar

from arjuna_nav.trees.node import Control, Status
from arjuna_nav.trees.ports import WHOLE, Port


class _InTurn(Control):
    """Ticks one child after the other, and goes on where it was."""

    GOES_ON: ClassVar[Status]
    ENDS: ClassVar[Status]
    KEEPS_PLACE: ClassVar[bool] = False
    _index = 0

    def tick(self) -> Status:
        """Tick the children from where it was."""
        self.set_status(Status.RUNNING)
        while self._index < len(self.children):
            status = self.children[self._index].execute()
            if status is Status.RUNNING:
                return status
            if status is self.ENDS:
                return self._end(status, self._index if self.KEEPS_PLACE else 0)
            self._index += 1
        return self._end(self.GOES_ON, 0)

    def _end(self, status: Status, index: int) -> Status:
        self.reset_children()
        self._index = index
        return status

    def on_halt(self) -> None:
        """Begin with the first child next time, unless the place is kept."""
        self._index = self._index if self.KEEPS_PLACE else 0


class Sequence(_InTurn):
    """Succeeds when all children have, one after the other; fails with the first that fails."""

    GOES_ON, ENDS = Status.SUCCESS, Status.FAILURE


class SequenceWithMemory(Sequence):
    """A sequence that begins again with the child that failed."""

    KEEPS_PLACE = True


class Fallback(_InTurn):
    """Succeeds with the first child that does; fails when all have failed."""

    GOES_ON, ENDS = Status.FAILURE, Status.SUCCESS


class _Reactive(Control):
    """Ticks all children from the first in each tick."""

    GOES_ON: ClassVar[Status]
    ENDS: ClassVar[Status]

    def tick(self) -> Status:
        """Tick from the first child to the one that decides."""
        self.set_status(Status.RUNNING)
        for child in self.children:
            status = child.execute()
            if status is Status.RUNNING:
                for other in self.children:
                    if other is not child and other.status is Status.RUNNING:
                        other.halt()
                return status
            if status is self.ENDS:
                self.reset_children()
                return status
        self.reset_children()
        return self.GOES_ON


class ReactiveSequence(_Reactive):
    """A sequence whose earlier children are asked again while a later one runs."""

    GOES_ON, ENDS = Status.SUCCESS, Status.FAILURE


class ReactiveFallback(_Reactive):
    """A fallback whose earlier children are asked again while a later one runs."""

    GOES_ON, ENDS = Status.FAILURE, Status.SUCCESS


class Parallel(Control):
    """Ticks all children; ends when enough have succeeded or failed; -1 means all."""

    PORTS: ClassVar[dict[str, Port]] = {
        "success_count": Port(WHOLE, -1),
        "failure_count": Port(WHOLE, 1),
    }

    def tick(self) -> Status:
        """Tick the children that have not ended."""
        self.set_status(Status.RUNNING)
        ended = (Status.SUCCESS, Status.FAILURE)
        for child in self.children:
            if child.status not in ended:
                child.execute()
        statuses = [child.status for child in self.children]
        for status, port in ((Status.SUCCESS, "success_count"), (Status.FAILURE, "failure_count")):
            count = self.get(port)
            needed = count if count >= 0 else len(statuses) + count + 1
            if statuses.count(status) >= needed:
                self.reset_children()
                return status
        if all(status in ended for status in statuses):
            self.reset_children()
            return Status.FAILURE
        return Status.RUNNING


class IfThenElse(Control):
    """Runs the second child where the first succeeds, else the third, or fails."""

    CHILDREN = (2, 3)
    _chosen = 0

    def tick(self) -> Status:
        """Ask the first child once, then run the one it chose."""
        self.set_status(Status.RUNNING)
        if self._chosen == 0:
            condition = self.children[0].execute()
            if condition is Status.RUNNING:
                return condition
            self._chosen = 1 if condition is Status.SUCCESS else 2
        if self._chosen == len(self.children):
            return self._end(Status.FAILURE)
        status = self.children[self._chosen].execute()
        return status if status is Status.RUNNING else self._end(status)

    def _end(self, status: Status) -> Status:
        self.reset_children()
        self._chosen = 0
        return status

    def on_halt(self) -> None:
        """Ask again next time."""
        self._chosen = 0


class WhileDoElse(Control):
    """Runs the second child while the first succeeds, the third while it does not."""

    CHILDREN = (2, 3)

    def tick(self) -> Status:
        """Ask the first child, and run the one that it chooses now."""
        self.set_status(Status.RUNNING)
        condition = self.children[0].execute()
        if condition is Status.RUNNING:
            return condition
        chosen = 1 if condition is Status.SUCCESS else 2
        for index in {1, 2} - {chosen}:
            if index < len(self.children):
                self.children[index].reset()
        if chosen == len(self.children):
            self.reset_children()
            return Status.FAILURE
        status = self.children[chosen].execute()
        if status is not Status.RUNNING:
            self.reset_children()
        return status
