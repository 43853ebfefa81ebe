"""Nodes with one child: BehaviorTree.CPP's, then Nav2's.

Source: BehaviorTree.CPP 4, decorators; nav2_behavior_tree, plugins/decorator.
"""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np

from arjuna_core.se2 import SE2
from arjuna_nav.planners import path as paths
from arjuna_nav.trees.exchange import Topic, TopicKind
from arjuna_nav.trees.node import ENDED, Decorator, Framed, Status
from arjuna_nav.trees.ports import (
    ANY,
    NUMBER,
    PATH,
    POSE,
    POSES,
    SCRIPT,
    STATUS,
    TEXT,
    TRUTH,
    WHOLE,
    Kind,
    Port,
    literal,
)

GOAL_UPDATE = "goal_update"
"""The topic on which a goal is moved, as Nav2's."""


class _Mapped(Decorator):
    ANSWERS: ClassVar[dict[Status, Status]]

    def _tick(self) -> Status:
        status = self.child.execute()
        return self.ANSWERS.get(status, status)


_S, _F = ENDED
MAPPED: dict[str, type[Decorator]] = {
    name: type(name, (_Mapped,), {"ANSWERS": answers})
    for name, answers in {
        "Inverter": {_S: _F, _F: _S},
        "ForceSuccess": {_F: _S},
        "ForceFailure": {_S: _F},
        "KeepRunningUntilFailure": {_S: Status.RUNNING},
    }.items()
}
"""The decorators that turn one status into another."""


class _Counted(Decorator):
    """Runs the child again, once a tick, while it ends with one status; -1 times is without end."""

    limit: Port
    AGAIN: ClassVar[Status]
    _count = 0

    def _tick(self) -> Status:
        status = self.child.execute()
        if status not in ENDED:
            return status
        limit: int = self.limit
        self._count += 1
        if status is self.AGAIN and (limit < 0 or self._count < limit):
            return Status.RUNNING
        self._count = 0
        return status

    def _on_halt(self) -> None:
        self._count = 0


COUNTED: dict[str, type[Decorator]] = {
    "Repeat": type("Repeat", (_Counted,), {"limit": Port(WHOLE, name="num_cycles"), "AGAIN": _S}),
    "RetryUntilSuccessful": type(
        "RetryUntilSuccessful",
        (_Counted,),
        {"limit": Port(WHOLE, name="num_attempts"), "AGAIN": _F},
    ),
}
"""The decorators that run their child again while it succeeds, or fails."""


class _Once(Decorator):
    """Runs the child to its end once."""

    _answer: Status | None = None

    def _tick(self) -> Status:
        if self._answer is not None:
            return self._answer
        status = self.child.execute()
        if status in ENDED:
            self._answer = self._later(status)
        return status

    def _later(self, status: Status) -> Status:
        """Return the answer from then on, to a child that ended so."""
        raise NotImplementedError


class RunOnce(_Once):
    """Runs the child to its end once, and is skipped from then on, or answers the same."""

    then_skip = Port(TRUTH, True)

    def _later(self, status: Status) -> Status:
        return Status.SKIPPED if self.then_skip else status


class SingleTrigger(_Once):
    """Runs the child to its end once, and fails from then on, until the node is idle again."""

    def _tick(self) -> Status:
        if self._before in (Status.IDLE, Status.SKIPPED):
            self._answer = None
        return super()._tick()

    def _later(self, status: Status) -> Status:
        return Status.FAILURE


class Timeout(Decorator):
    """Fails where the child runs for too long."""

    msec = Port(NUMBER)

    def _tick(self) -> Status:
        if self.elapsed < self.msec:
            return self.child.execute()
        self.child.reset()
        return Status.FAILURE


class Delay(Decorator):
    """Ticks the child after a while."""

    delay_msec = Port(NUMBER)

    def _tick(self) -> Status:
        return Status.RUNNING if self.elapsed < self.delay_msec else self.child.execute()


class Precondition(Decorator):
    """Runs the child where a script holds as it begins, else answers `else`."""

    condition = Port(SCRIPT, name="if")
    otherwise = Port(STATUS, "FAILURE", name="else")

    def _tick(self) -> Status:
        if self.child.status is Status.RUNNING or self.condition.holds(self.board):
            return self.child.execute()
        return Status[self.otherwise]


class _Loop(Decorator):
    """Runs the child for each value of a list, as '1;2;3', until it fails."""

    queue = Port(ANY)
    if_empty = Port(STATUS, "SUCCESS")
    value = Port(ANY, None, output=True)
    KIND: ClassVar[Kind]
    _remaining: tuple[Any, ...] = ()

    def _tick(self) -> Status:
        if self._before is not Status.RUNNING:
            queue = self.queue
            parts = queue.split(";") if isinstance(queue, str) else queue
            self._remaining = tuple(part for part in parts if str(part).strip())
            if not self._remaining:
                return Status[self.if_empty]
        if self.child.status is not Status.RUNNING:
            value = Port(self.KIND), f"{self.name}: port 'queue'"
            self.value = literal(str(self._remaining[0]).strip(), *value)
            self._remaining = self._remaining[1:]
        status = self.child.execute()
        ended = status is Status.FAILURE or (status is not Status.RUNNING and not self._remaining)
        return status if ended else Status.RUNNING


LOOPS: dict[str, type[Decorator]] = {
    name: type(name, (_Loop,), {"KIND": kind})
    for name, kind in (
        *(("LoopString", TEXT), ("LoopInt", WHOLE)),
        *(("LoopDouble", NUMBER), ("LoopBool", TRUTH)),
    )
}
"""The loops by the type of their values."""


class SkipUnlessUpdated(Decorator):
    """Runs the child where an entry was written since it last began, else answers SKIPPED."""

    entry = Port(ANY)
    OTHERWISE: ClassVar[Status] = Status.SKIPPED
    _written = 0

    def _tick(self) -> Status:
        if self.child.status is not Status.RUNNING:
            before, self._written = self._written, self.named_entry("entry").written
            if self._written == before:
                return self.OTHERWISE
        return self.child.execute()


class WaitValueUpdated(SkipUnlessUpdated):
    """Runs the child where an entry was written since it last began, else waits for that."""

    OTHERWISE = Status.RUNNING


class _Gate(Decorator):
    """Ticks the child at first, while it runs, and whenever it is due; runs in between."""

    def _tick(self) -> Status:
        first = self._before in (Status.IDLE, Status.SKIPPED)
        if first:
            self._restart()
        if not (first or self.child.status is Status.RUNNING or self._is_due()):
            return Status.RUNNING
        status = self.child.execute()
        if status is Status.SUCCESS:
            self._restart()
        return status

    def _restart(self) -> None:
        raise NotImplementedError

    def _is_due(self) -> bool:
        raise NotImplementedError


class RateController(_Gate):
    """Ticks the child at most so often."""

    hz = Port(NUMBER, 10.0)
    _since = 0.0

    def _restart(self) -> None:
        self._since = self.tree.state.now

    def _is_due(self) -> bool:
        return (self.tree.state.now - self._since) * self._rate() >= 1.0

    def _rate(self) -> float:
        return float(self.hz)


class SpeedController(RateController):
    """Ticks the child the more often the faster the robot drives, judged at the end of a period."""

    min_rate = Port(NUMBER, 0.1)
    max_rate = Port(NUMBER, 1.0)
    min_speed = Port(NUMBER, 0.0)
    max_speed = Port(NUMBER, 0.5)
    filter_duration = Port(NUMBER, 0.3)  # of Nav2's documented example; the navigator's holds
    goal = Port(POSE, None)
    goals = Port(POSES, None)
    _now = 0.0

    def _tick(self) -> Status:
        if self._before in (Status.IDLE, Status.SKIPPED):
            self._now = (self.min_rate + self.max_rate) / 2.0
        return super()._tick()

    def _is_due(self) -> bool:
        due = super()._is_due()
        if due:
            low, high = self.min_speed, self.max_speed
            share = (self.tree.state.mean_velocity().speed - low) / max(high - low, 1e-9)
            slow, fast = self.min_rate, self.max_rate
            self._now = float(slow + min(max(share, 0.0), 1.0) * (fast - slow))
        return due

    def _rate(self) -> float:
        return self._now


class DistanceController(Framed, _Gate):
    """Ticks the child each time the robot has gone so far."""

    distance = Port(NUMBER, 1.0)
    _start: SE2 | None = None

    def _restart(self) -> None:
        self._start = self._robot()

    def _robot(self) -> SE2 | None:
        return self.tree.state.robot(self.global_frame, self.robot_base_frame)

    def _is_due(self) -> bool:
        pose, start = self._robot(), self._start
        return pose is not None and (start is None or pose.distance(start) >= float(self.distance))


def goals_of(node: Any) -> tuple[Any, Any]:
    """Return the goal and the goals of a node's ports, else those that the tree drives to."""
    board = node.tree.blackboard
    return node.goal or board.get("goal"), node.goals or board.get("goals")


class GoalUpdatedController(Decorator):
    """Ticks the child at first, while it runs, and when the goal has changed."""

    goal = Port(POSE, None)
    goals = Port(POSES, None)
    _goals: Any = None

    def _tick(self) -> Status:
        before, self._goals = self._goals, goals_of(self)
        first = self._before in (Status.IDLE, Status.SKIPPED)
        if first or self.child.status is Status.RUNNING or self._goals != before:
            return self.child.execute()
        return Status.RUNNING


class GoalUpdater(Decorator):
    """Writes the goal that the topic goal_update moved it to, or the goal itself."""

    input_goal = Port(POSE)
    output_goal = Port(POSE, None, output=True)
    input_goals = Port(POSES, None)
    output_goals = Port(POSES, None, output=True)

    def topics(self) -> set[Topic]:
        """Return the topics that the node and those below it listen to."""
        return super().topics() | {Topic(TopicKind.GOAL, GOAL_UPDATE)}

    def _tick(self) -> Status:
        moved = self.tree.state.moved_goal
        self.output_goal = self.input_goal if moved is None else moved
        if (goals := self.input_goals) is not None:
            self.output_goals = goals
        return self.child.execute()


class PathLongerOnApproach(Decorator):
    """Runs the child where a new path to the same goal is much longer, near the goal."""

    path = Port(PATH)
    prox_len = Port(NUMBER, 3.0)
    length_factor = Port(NUMBER, 2.0)
    _path: Any = None

    def _tick(self) -> Status:
        path, before = self.path, self._path
        if self.child.status is not Status.RUNNING:
            self._path = path
            if before is None or path is before or not self._is_detour(path, before):
                return Status.SUCCESS
        return self.child.execute()

    def _is_detour(self, path: Any, before: Any) -> bool:
        # Ends less than 5 cm apart are the same goal.
        same_goal = bool(np.hypot(*(path[-1, :2] - before[-1, :2])) < 0.05)
        length, old = paths.length(path), paths.length(before)
        near = old < self.prox_len
        return bool(same_goal and near and length > self.length_factor * old)
