"""Arjuna's own nodes: replanning, keeping a path while it is free, and standing through an outage.

`behavior_trees/navigate_to_pose.xml` shows them at work, `behavior_trees/README.md` explains them.
"""

from __future__ import annotations

import math

from arjuna_core.se2 import SE2
from arjuna_nav.planners import path as paths
from arjuna_nav.trees.node import Condition, Decorator, Maker, Status
from arjuna_nav.trees.ports import CODES, NUMBER, PATH, TEXT, TRUTH, WHOLE, Port


class ReplanningController(Decorator):
    """Ticks the child at first, while it runs, once a period, and at once for a new goal.

    A period begins with the child; RateController's begins with the child's success.
    """

    hz = Port(NUMBER, 1.0)
    _began = -math.inf
    _period = 0.0
    _goal_written = 0

    def __init__(self, maker: Maker) -> None:
        super().__init__(maker)
        self._goal = self.tree.blackboard.entry("goal")

    def _tick(self) -> Status:
        now, written = self.tree.state.now, self._goal.written
        is_new = written != self._goal_written or self._before in (Status.IDLE, Status.SKIPPED)
        if is_new or self.child.status is not Status.RUNNING:
            if not is_new and now - self._began < self._period:
                return Status.RUNNING
            self._began, self._goal_written = now, written
            self._period = 1.0 / self.hz
        return self.child.execute()


class IsPathPreferred(Condition):
    """Succeeds where the robot stays on its path although there is a new one, so as not to waver.

    It fails where the new path is nearly the same, driven ahead and back in the same parts, or
    clearly shorter, where the robot has left the old one, and where that leads to another goal or
    is blocked. One along a path that was blocked a while ago has to be much shorter: a narrow gap
    that is seen open from one side and blocked from the other would be left and taken for ever.
    """

    path = Port(PATH, None)
    new_path = Port(PATH)
    same_way_deviation = Port(NUMBER, 0.5)
    shorter_ratio = Port(NUMBER, 0.9)
    free = Port(TRUTH, True)
    blocked_memory = Port(NUMBER, 20.0)
    blocked_ratio = Port(NUMBER, 0.7)
    _blocked_at = -math.inf

    def _holds(self) -> bool:
        old, new, pose = self.path, self.new_path, self.tree.state.pose
        now, goal_came = self.tree.state.now, self.tree.blackboard.entry("goal").written
        if old is not None and pose is not None and not self.free:
            self._blocked_at, self._blocked = now, paths.ahead(old, pose)
            return False
        if old is None or pose is None or goal_came > self.named_entry("path").written:
            return False
        rest, most = paths.ahead(old, pose), self.same_way_deviation
        beside = pose.distance(SE2.from_array(rest[0]))
        # A steered robot that changes between ahead and back with each plan gets nowhere.
        alike = paths.directions(rest) in ([], paths.directions(new))
        if beside > most or (alike and paths.deviation(new, rest) <= most):
            return False
        remembered = now - self._blocked_at <= self.blocked_memory
        doubtful = remembered and paths.deviation(self._blocked, new) <= most
        ratio = self.blocked_ratio if doubtful else self.shorter_ratio
        return bool(paths.length(new) > ratio * (beside + paths.length(rest)))


class WaitOutOutage(Decorator):
    """Stands and ticks the child again each period while it fails with an error of an outage.

    Where the robot's pose or its surroundings are not known, no recovery helps, and clearing
    costmaps then does harm. An outage lasts while each try fails; once it has lasted for longer
    than `patience` [s] the node fails as its child did.
    """

    error_code = Port(WHOLE, 0)
    error_msg = Port(TEXT, "")
    # TF_ERROR, CONTROLLER_TIMED_OUT; TF_ERROR, TIMEOUT of planning, to a pose and through poses
    error_codes = Port(CODES, frozenset({102, 107, 202, 207, 302, 307}))
    patience = Port(NUMBER, 30.0)
    hz = Port(NUMBER, 1.0)
    problem = Port(TEXT, None, output=True)
    _since = _last = -math.inf
    _period = 0.0
    _reported = False

    def _tick(self) -> Status:
        now = self.tree.state.now
        if self._reported:
            if now - self._last < self._period:
                return Status.RUNNING
            if now - self._last >= 2.0 * self._period:
                self.problem = None
                self._reported = False
        status = self.child.execute()
        if status is not Status.FAILURE or self.error_code not in self.error_codes:
            return status
        self._period = 1.0 / self.hz
        if now - self._last > 3.0 * self._period:
            self._since = now
        self._last, self._reported = now, True
        self.problem = self.error_msg
        return Status.RUNNING if now - self._since < self.patience else status
