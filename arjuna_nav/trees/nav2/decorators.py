"""Nav2's own nodes with one child.

Source: nav2_behavior_tree, plugins/decorator.
"""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np

from arjuna_core.se2 import SE2
from arjuna_nav.planners import path as paths
from arjuna_nav.trees.exchange import Heard, Topic
from arjuna_nav.trees.node import Decorator, Status
from arjuna_nav.trees.ports import NUMBER, PATH, POSE, Port

GOAL_UPDATE = "goal_update"
"""The topic on which a goal is moved, as Nav2's."""
_SAME_GOAL = 0.05  # [m]


class _Gate(Decorator):
    """Ticks the child at first, while it runs, and whenever it is due; runs in between."""

    def tick(self) -> Status:
        """Tick the child where it is due."""
        first = self.status is Status.IDLE
        if first:
            self.restart()
        self.set_status(Status.RUNNING)
        if not (first or self.child.status is Status.RUNNING or self.is_due()):
            return Status.RUNNING
        status = self.child.execute()
        if status is Status.SUCCESS:
            self.restart()
        return status

    def restart(self) -> None:
        """Begin to wait for the next time."""
        raise NotImplementedError

    def is_due(self) -> bool:
        """Tell whether the child is to be ticked again."""
        raise NotImplementedError


class RateController(_Gate):
    """Ticks the child at most so often."""

    PORTS: ClassVar[dict[str, Port]] = {"hz": Port(NUMBER, 10.0)}
    _since = 0.0

    def restart(self) -> None:
        """Count from now."""
        self._since = self.running.state.now

    def is_due(self) -> bool:
        """Tell whether a period has passed."""
        return (self.running.state.now - self._since) * float(self.get("hz")) >= 1.0


class DistanceController(_Gate):
    """Ticks the child each time the robot has gone so far."""

    PORTS: ClassVar[dict[str, Port]] = {"distance": Port(NUMBER, 1.0)}
    _start: SE2 | None = None

    def restart(self) -> None:
        """Measure from here."""
        self._start = self.running.state.pose

    def is_due(self) -> bool:
        """Tell whether the robot has gone so far."""
        pose, start = self.running.state.pose, self._start
        return pose is not None and (
            start is None or pose.distance(start) >= float(self.get("distance"))
        )


class SpeedController(_Gate):
    """Ticks the child the more often the faster the robot drives."""

    PORTS: ClassVar[dict[str, Port]] = {
        "min_rate": Port(NUMBER, 0.1),
        "max_rate": Port(NUMBER, 1.0),
        "min_speed": Port(NUMBER, 0.0),
        "max_speed": Port(NUMBER, 0.5),
    }
    _since = 0.0

    def restart(self) -> None:
        """Count from now."""
        self._since = self.running.state.now

    def is_due(self) -> bool:
        """Tell whether a period has passed, by the speed."""
        low, high = self.get("min_speed"), self.get("max_speed")
        share = (abs(self.running.state.velocity.x) - low) / max(high - low, 1e-9)
        slow, fast = self.get("min_rate"), self.get("max_rate")
        rate = slow + min(max(share, 0.0), 1.0) * (fast - slow)
        return bool((self.running.state.now - self._since) * rate >= 1.0)


class SingleTrigger(Decorator):
    """Runs the child to its end once, and fails from then on."""

    _used = False

    def tick(self) -> Status:
        """Tick the child the first time."""
        if self._used:
            return Status.FAILURE
        self.set_status(Status.RUNNING)
        status = self.child.execute()
        self._used = status in (Status.SUCCESS, Status.FAILURE)
        return status

    def on_halt(self) -> None:
        """Let it run again."""
        self._used = False


class GoalUpdatedController(Decorator):
    """Ticks the child at first, while it runs, and when the goal has changed."""

    _goals: Any = None

    def tick(self) -> Status:
        """Tick the child where it is due."""
        board = self.running.root
        before, self._goals = self._goals, (board.get("goal"), board.get("goals"))
        first = self.status is Status.IDLE
        self.set_status(Status.RUNNING)
        if first or self.child.status is Status.RUNNING or self._goals != before:
            return self.child.execute()
        return Status.RUNNING


class GoalUpdater(Decorator):
    """Writes the goal that the topic goal_update moved it to, or the goal itself."""

    PORTS: ClassVar[dict[str, Port]] = {
        "input_goal": Port(POSE),
        "output_goal": Port(POSE, None, output=True),
    }

    def topics(self) -> set[Topic]:
        """Return the topic of moved goals too."""
        return super().topics() | {Topic(Heard.GOAL, GOAL_UPDATE)}

    def tick(self) -> Status:
        """Write it and tick the child."""
        self.set_status(Status.RUNNING)
        moved = self.running.state.moved_goal
        self.put("output_goal", self.get("input_goal") if moved is None else moved)
        return self.child.execute()


class PathLongerOnApproach(Decorator):
    """Runs the child where a new path to the same goal is much longer, near the goal."""

    PORTS: ClassVar[dict[str, Port]] = {
        "path": Port(PATH),
        "prox_len": Port(NUMBER, 3.0),
        "length_factor": Port(NUMBER, 2.0),
    }
    _path: Any = None

    def tick(self) -> Status:
        """Compare the path with the one before."""
        path, before = self.get("path"), self._path
        if self.status is Status.IDLE or self.child.status is not Status.RUNNING:
            self._path = path
            if before is None or path is before or not self._is_detour(path, before):
                return Status.SUCCESS
        self.set_status(Status.RUNNING)
        return self.child.execute()

    def _is_detour(self, path: Any, before: Any) -> bool:
        same_goal = bool(np.hypot(*(path[-1, :2] - before[-1, :2])) < _SAME_GOAL)
        length, old = paths.length(path), paths.length(before)
        near = old < self.get("prox_len")
        return bool(same_goal and near and length > self.get("length_factor") * old)
