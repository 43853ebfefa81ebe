"""Nodes with several children: BehaviorTree.CPP's, then Nav2's.

A reactive node stops a running child when another replaces it, and leaves the statuses of the
others as they are, so that a condition such as GoalUpdated remembers what it saw. A child that a
condition skips counts as none; where all are skipped, so is the node.

Source: BehaviorTree.CPP 4, controls; nav2_behavior_tree, plugins/control.
"""

from __future__ import annotations

from typing import ClassVar

from arjuna_nav.trees.exchange import Topic, TopicKind
from arjuna_nav.trees.node import ENDED, Control, Maker, Status
from arjuna_nav.trees.ports import ANY, TEXT, WHOLE, Port


class _InTurn(Control):
    """Ticks one child after the other, and resumes with the one that ran."""

    CONTINUES: ClassVar[Status]
    ENDS: ClassVar[Status]
    KEEPS_INDEX: ClassVar[bool] = False
    _index = 0
    _skipped = 0

    def _tick(self) -> Status:
        if self._before is not Status.RUNNING:
            self._skipped = 0
        while self._index < len(self.children):
            status = self.children[self._index].execute()
            if status is Status.RUNNING:
                return status
            if status is self.ENDS:
                return self._end(status)
            self._skipped += status is Status.SKIPPED
            self._index += 1
        self._index = 0
        all_skipped = self._skipped == len(self.children)
        return self._end(Status.SKIPPED if all_skipped else self.CONTINUES)

    def _on_halt(self) -> None:
        self._index = self._index if self.KEEPS_INDEX else 0


class Sequence(_InTurn):
    """Succeeds when all children have, one after the other; fails with the first that fails."""

    CONTINUES, ENDS = Status.SUCCESS, Status.FAILURE


class SequenceWithMemory(Sequence):
    """A sequence that begins again with the child that failed."""

    KEEPS_INDEX = True


class Fallback(_InTurn):
    """Succeeds with the first child that does; fails when all have failed."""

    CONTINUES, ENDS = Status.FAILURE, Status.SUCCESS


class _Reactive(Control):
    """Ticks all children from the first in each tick."""

    CONTINUES: ClassVar[Status]
    ENDS: ClassVar[Status]

    def _tick(self) -> Status:
        skipped = 0
        for child in self.children:
            status = child.execute()
            if status is Status.RUNNING:
                for other in self.children:
                    if other is not child and other.status is Status.RUNNING:
                        other.halt()
                return status
            if status is self.ENDS:
                return self._end(status)
            skipped += status is Status.SKIPPED
        return self._end(Status.SKIPPED if skipped == len(self.children) else self.CONTINUES)


class ReactiveSequence(_Reactive):
    """A sequence whose earlier children are asked again while a later one runs."""

    CONTINUES, ENDS = Status.SUCCESS, Status.FAILURE


class ReactiveFallback(_Reactive):
    """A fallback whose earlier children are asked again while a later one runs."""

    CONTINUES, ENDS = Status.FAILURE, Status.SUCCESS


class Parallel(Control):
    """Ticks all children until enough have succeeded, or failed, or too few can; -1 means all."""

    success_count = Port(WHOLE, -1)
    failure_count = Port(WHOLE, 1)

    def _tick(self) -> Status:
        total, skipped = len(self.children), 0
        wanted, most = (
            _of_all(self.get(name), total) for name in ("success_count", "failure_count")
        )
        spared = self.success_count < 0
        for child in self.children:
            if child.status not in ENDED:
                skipped += child.execute() is Status.SKIPPED
            statuses = [each.status for each in self.children]
            failed = statuses.count(Status.FAILURE)
            if statuses.count(Status.SUCCESS) + spared * skipped >= wanted and skipped < total:
                return self._end(Status.SUCCESS)
            if failed == most or total - failed < wanted:
                return self._end(Status.FAILURE)
        return self._end(Status.SKIPPED) if skipped == total else Status.RUNNING


class ParallelAll(Control):
    """Ticks all children to their ends; fails where too many have failed; -1 means all."""

    max_failures = Port(WHOLE, 1)

    def _tick(self) -> Status:
        for child in self.children:
            if child.status not in ENDED:
                child.execute()
        statuses = [child.status for child in self.children]
        if Status.RUNNING in statuses:
            return Status.RUNNING
        self.reset_children()
        if statuses.count(Status.SKIPPED) == len(statuses):
            return Status.SKIPPED
        most = _of_all(self.max_failures, len(statuses))
        return Status.FAILURE if statuses.count(Status.FAILURE) >= most else Status.SUCCESS


def _of_all(count: int, total: int) -> int:
    """Return a number of children, where a negative one counts back from all."""
    return count if count >= 0 else max(total + count + 1, 0)


class _Choosing(Control):
    def _run(self, index: int) -> Status:
        """Tick the child chosen, or fail where there is none of that number."""
        for other, child in enumerate(self.children):
            if other != index and child.status is not Status.IDLE:
                child.reset()
        status = self.children[index].execute() if index < len(self.children) else Status.FAILURE
        return status if status is Status.RUNNING else self._end(status)


class WhileDoElse(_Choosing):
    """Runs the second child while the first succeeds, the third, if any, while it does not."""

    CHILDREN = (2, 3)
    _chosen = 0

    def _tick(self) -> Status:
        condition = self.children[0].execute()
        if condition is Status.RUNNING:
            return condition
        self._chosen = 1 if condition is Status.SUCCESS else 2
        return self._run(self._chosen)

    def _on_halt(self) -> None:
        self._chosen = 0


class IfThenElse(WhileDoElse):
    """Asks the first child once, then runs the second where it succeeded, else the third."""

    def _tick(self) -> Status:
        return self._run(self._chosen) if self._chosen else super()._tick()


class _Switch(_Choosing):
    """Runs the child of the case that a variable has now, or else the last."""

    variable = Port(ANY, "")

    def _tick(self) -> Status:
        value = self.variable
        variable = f"{value:g}" if isinstance(value, float) else str(value)
        cases = [self.get(name) for name in self.PORTS if name != "variable"]
        return self._run(cases.index(variable) if variable in cases else len(cases))


SWITCHES: dict[str, type[Control]] = {
    f"Switch{count}": type(
        f"Switch{count}",
        (_Switch,),
        {
            **{f"case_{k}": Port(TEXT) for k in range(1, count + 1)},
            "CHILDREN": (count + 1, count + 1),
        },
    )
    for count in range(2, 7)
}
"""Switch2 to Switch6."""


class PersistentSequence(Control):
    """A sequence whose place is an entry of the blackboard, so that it lasts beyond a halt."""

    current_child_idx = Port(WHOLE, 0, output=True)

    def _tick(self) -> Status:
        index = self.current_child_idx
        while index < len(self.children):
            status = self.children[index].execute()
            if status is Status.FAILURE:
                self.current_child_idx = 0
                return self._end(status)
            if status is Status.RUNNING:
                return status
            index += 1
            self.current_child_idx = index
        self.current_child_idx = 0
        return self._end(Status.SUCCESS)


class NonblockingSequence(Control):
    """Ticks all children again and again; succeeds when all do so in one tick."""

    def _tick(self) -> Status:
        running = False
        for child in self.children:
            status = child.execute()
            if status is Status.FAILURE:
                return self._end(status)
            running = running or status is Status.RUNNING
        return Status.RUNNING if running else self._end(Status.SUCCESS)


class PauseResumeController(Control):
    """Runs the first child, and, from a call of one service to that of another, the second.

    Where it changes over, it runs the third child first, or the fourth on the way back.
    """

    CHILDREN = (1, 4)
    pause_service_name = Port(TEXT)
    resume_service_name = Port(TEXT)
    _at = 0
    _requested: int | None = None

    def __init__(self, maker: Maker) -> None:
        super().__init__(maker)
        self.tree.calls[self.topic("pause_service_name")] = self._pause
        self.tree.calls[self.topic("resume_service_name")] = self._resume

    def topics(self) -> set[Topic]:
        """Return the services that the node offers, and what those below it listen to."""
        names = self.pause_service_name, self.resume_service_name
        return super().topics() | {Topic(TopicKind.CALL, name) for name in names}

    def _pause(self) -> str:
        return self._request(2, self._at != 1 or self._requested is not None, "is paused already")

    def _resume(self) -> str:
        return self._request(3, self._at == 1 and self._requested is None, "is not paused")

    def _request(self, child: int, fits: bool, otherwise: str) -> str:
        """Note which child is to run; return why not, or nothing."""
        if self.status is Status.IDLE:
            return f"{self.name} does not run"
        if not fits:
            return f"{self.name} {otherwise}"
        self._requested = child
        return ""

    def _tick(self) -> Status:
        if self._requested is not None:
            self.reset_children()
            self._at, self._requested = self._requested, None
        has_child = self._at < len(self.children)
        status = self.children[self._at].execute() if has_child else Status.SUCCESS
        if status is Status.FAILURE or (status is Status.SUCCESS and self._at == 0):
            return self._end(status)
        if status is Status.SUCCESS:
            self._at = {2: 1, 3: 0}.get(self._at, self._at)
        return Status.RUNNING

    def _on_halt(self) -> None:
        self._at, self._requested = 0, None


class PipelineSequence(Control):
    """A sequence that ticks all children up to the one that has come farthest, again and again."""

    _last = 0

    def _tick(self) -> Status:
        for index, child in enumerate(self.children):
            status = child.execute()
            if status is Status.FAILURE:
                return self._end(status)
            if status is Status.RUNNING and index >= self._last:
                self._last = index
                return status
        return self._end(Status.SUCCESS)

    def _on_halt(self) -> None:
        self._last = 0


class RecoveryNode(Control):
    """Runs the second child where the first fails, then the first again, a number of times."""

    number_of_retries = Port(WHOLE, 1)
    CHILDREN = (2, 2)
    _retries = 0
    _recovering = False

    def _tick(self) -> Status:
        # At most 100 children that end at once in one tick; the rest waits for the next.
        for _ in range(100):
            status = self.children[self._recovering].execute()
            if status is Status.RUNNING:
                return status
            if self._recovering:
                if status is not Status.SUCCESS:
                    return self._end(Status.FAILURE)
                self._retries += 1
            elif status is not Status.FAILURE or self._retries >= self.number_of_retries:
                return self._end(status)
            self.children[self._recovering].reset()
            self._recovering = not self._recovering
        return Status.RUNNING

    def _on_halt(self) -> None:
        self._retries, self._recovering = 0, False


class RoundRobin(Control):
    """Ticks one child until it ends; the next time the next one; fails when all have in a row."""

    _index = 0
    _failed = 0

    def _tick(self) -> Status:
        skipped = 0
        while self._failed + skipped < len(self.children):
            status = self.children[self._index].execute()
            if status is Status.RUNNING:
                return status
            self._index = (self._index + 1) % len(self.children)
            if status is Status.SUCCESS:
                self._failed = 0
                self.reset_children()
                return status
            self._failed += status is Status.FAILURE
            skipped += status is Status.SKIPPED
        return self._end(Status.SKIPPED if skipped == len(self.children) else Status.FAILURE)

    def _on_halt(self) -> None:
        self._index = self._failed = 0
