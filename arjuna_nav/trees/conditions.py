"""Conditions: nodes that answer at once.

Source: nav2_behavior_tree, plugins/condition; BehaviorTree.CPP 4, actions.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, ClassVar

from arjuna_core.se2 import SE2
from arjuna_nav.planners import path as paths
from arjuna_nav.trees.asking import Asking
from arjuna_nav.trees.decorators import goals_of
from arjuna_nav.trees.exchange import Battery, Topic, TopicKind
from arjuna_nav.trees.node import Condition, Framed, Status, TreeNode
from arjuna_nav.trees.ports import (
    ANY,
    CODES,
    NUMBER,
    PATH,
    POSE,
    POSES,
    SCRIPT,
    TEXT,
    TRUTH,
    WHOLE,
    Port,
)

_Answered = tuple[Callable[[Any], bool], dict[str, Port]]


def _helps_with(*codes: int) -> _Answered:
    """Return a condition that succeeds where clearing or moving may mend an error."""
    return lambda node: node.error_code in codes, {"error_code": Port(WHOLE, 0)}


_SIMPLE: dict[str, _Answered] = {
    "AlwaysSuccess": (lambda node: True, {}),
    "AlwaysFailure": (lambda node: False, {}),
    "ScriptCondition": (lambda node: node.code.holds(node.board), {"code": Port(SCRIPT)}),
    "InitialPoseReceived": (
        lambda node: node.tree.state.pose is not None,
        {"initial_pose_received": Port(TEXT, "")},
    ),
    "ArePosesNear": (
        lambda node: node.ref_pose.distance(node.target_pose) <= node.tolerance,
        {
            "ref_pose": Port(POSE),
            "target_pose": Port(POSE),
            "tolerance": Port(NUMBER, 0.5),
            "global_frame": Port(TEXT, ""),
        },
    ),
    "AreErrorCodesPresent": (
        lambda node: node.error_code in node.error_codes_to_check,
        {"error_code": Port(WHOLE, 0), "error_codes_to_check": Port(CODES, frozenset())},
    ),
    # unknown, patience exceeded, no progress, no valid control
    "WouldAControllerRecoveryHelp": _helps_with(100, 104, 105, 106),
    # unknown, time-out, no valid path; to a pose and through poses
    "WouldAPlannerRecoveryHelp": _helps_with(200, 207, 208, 300, 307, 308),
    # unknown, time-out, failed to smooth, smoothed path in collision
    "WouldASmootherRecoveryHelp": _helps_with(500, 502, 503, 504),
    # unknown, time-out, no valid route
    "WouldARouteRecoveryHelp": _helps_with(400, 404, 405),
}


class _Simple(Condition):
    ANSWER: ClassVar[Callable[[Any], bool]]

    def _holds(self) -> bool:
        return type(self).ANSWER(self)


CONDITIONS: dict[str, type[Condition]] = {
    name: type(name, (_Simple,), {"ANSWER": staticmethod(answer), **ports})
    for name, (answer, ports) in _SIMPLE.items()
}
"""The conditions that remember nothing."""


class WasEntryUpdated(Condition):
    """Succeeds where an entry was written since the last tick of the node."""

    entry = Port(ANY)
    _written = 0

    def _holds(self) -> bool:
        before, self._written = self._written, self.named_entry("entry").written
        return self._written != before


class GoalUpdated(Condition):
    """Succeeds where the goal has changed since the last tick, in this branch of the tree."""

    goal = Port(POSE, None)
    goals = Port(POSES, None)
    _seen: Any = None

    def _holds(self) -> bool:
        before, self._seen = self._seen, goals_of(self)
        return self._remembers() and self._seen != before

    def _remembers(self) -> bool:
        return self.status is not Status.IDLE


class GlobalUpdatedGoal(GoalUpdated):
    """Succeeds where the goal has changed since the last tick in any branch, or is the first."""

    def _remembers(self) -> bool:
        return True


class TimeExpired(Condition):
    """Succeeds each time that a period has passed, from the first tick on."""

    seconds = Port(NUMBER, 1.0)
    _since = 0.0

    def _holds(self) -> bool:
        now, begins = self.tree.state.now, self._begins()
        passed = not begins and now - self._since >= self.seconds
        if begins or passed:
            self._since = now
        return passed

    def _begins(self) -> bool:
        return self.status is Status.IDLE


class PathExpiringTimer(TimeExpired):
    """Succeeds each time that a period has passed; a new path restarts it."""

    path = Port(PATH, None)
    _path: Any = ()  # neither a path nor none yet

    def _begins(self) -> bool:
        before, self._path = self._path, self.path
        return self._path is not before


class GoalReached(Framed, Condition):
    """Succeeds where the robot's frame is near the goal."""

    goal = Port(POSE)
    goal_reached_tol = Port(NUMBER, 0.25)

    def _holds(self) -> bool:
        pose = self.tree.state.robot(base=self.robot_base_frame)
        return pose is not None and pose.distance(self.goal) <= self.goal_reached_tol


class IsGoalNearby(Framed, Condition):
    """Succeeds where a path has less than some length left from the robot on.

    On the same path the search begins at the index found last, where it has a limit.
    """

    path = Port(PATH, None)
    proximity_threshold = Port(NUMBER, 1.0)
    max_robot_pose_search_dist = Port(NUMBER, -1.0)
    _path: Any = None
    _at = 0

    def _holds(self) -> bool:
        pose = self.tree.state.robot(base=self.robot_base_frame)
        path, reach = self.path, self.max_robot_pose_search_dist
        if path is None or not len(path) or pose is None:
            return False
        if path is not self._path or reach < 0.0:
            self._path, self._at = path, 0
        self._at = paths.nearest(path, pose, self._at, reach if reach >= 0.0 else math.inf)
        return bool(paths.length(path[self._at :]) < self.proximity_threshold)


class IsWithinPathTrackingBounds(Condition):
    """Fails where the robot is too far from the path that it follows, to one side or in heading.

    The errors are measured here: Nav2's messages of Jazzy have no feedback of tracking.
    """

    max_error_left = Port(NUMBER, 0.5)
    max_error_right = Port(NUMBER, 0.5)
    max_error_heading = Port(NUMBER, 3.14)
    tracking_feedback = Port(ANY, None)

    def _holds(self) -> bool:
        pose = self.tree.state.pose
        asking = (node for node in self.tree.asking if isinstance(node, Asking))
        path = next((n.asked["path"] for n in asking if n.KIND == "FollowPath" and n.asked), None)
        if pose is None or path is None or not len(path):
            return True
        error = SE2.from_array(path[paths.nearest(path, pose)]).inverse() @ pose
        most = abs(self.max_error_left if error.y >= 0.0 else self.max_error_right)
        return bool(abs(error.y) <= most and abs(error.theta) <= abs(self.max_error_heading))


class DistanceTraveled(Framed, Condition):
    """Succeeds each time that the robot has covered a distance, from the first tick on."""

    distance = Port(NUMBER, 1.0)
    _start: Any = None

    def _holds(self) -> bool:
        pose = self.tree.state.robot(self.global_frame, self.robot_base_frame)
        if self.status is Status.IDLE or self._start is None:
            self._start = pose
            return False
        if pose is None or pose.distance(self._start) < self.distance:
            return False
        self._start = pose
        return True


class IsStuck(Condition):
    """Succeeds where the robot was stopped at once, as by a wall, between two odometries."""

    _last: tuple[float, float] | None = None
    _stuck = False

    def _holds(self) -> bool:
        state = self.tree.state
        now, speed = state.measured_at, state.velocity.speed
        if self._last is not None and now > self._last[0]:
            # 10 m/s^2, as in Nav2: no robot brakes so hard by itself, so it was stopped.
            self._stuck = (self._last[1] - speed) / (now - self._last[0]) > 10.0
        self._last = now, speed
        return self._stuck


class IsStopped(TreeNode):
    """Succeeds once the robot has stood for a while; fails while it moves."""

    velocity_threshold = Port(NUMBER, 0.01)
    duration_stopped = Port(NUMBER, 1000.0)
    _since = math.inf

    def _tick(self) -> Status:
        now, velocity = self.tree.state.now, self.tree.state.velocity
        if max(velocity.speed, abs(velocity.yaw_rate)) >= self.velocity_threshold:
            self._since = math.inf
            return Status.FAILURE
        self._since = min(self._since, now)
        if now - self._since <= self.duration_stopped / 1000.0:
            return Status.RUNNING
        self._since = math.inf
        return Status.SUCCESS


class TransformAvailable(Condition):
    """Succeeds where a transform is known, and from then on."""

    child = Port(TEXT)
    parent = Port(TEXT)
    _known = False

    def _holds(self) -> bool:
        state = self.tree.state
        self._known = self._known or state.transform(self.parent, self.child) is not None
        return self._known


class IsBatteryCharging(Condition):
    """Succeeds where a battery is being charged; fails while nothing is known of it."""

    battery_topic = Port(TEXT, "/battery_status")

    def topics(self) -> set[Topic]:
        """Return the topics that the node listens to."""
        return {Topic(TopicKind.BATTERY, self.topic("battery_topic"))}

    def _holds(self) -> bool:
        battery = self.tree.state.batteries.get(self.topic("battery_topic"))
        return battery is not None and self._judge(battery)

    def _judge(self, battery: Battery) -> bool:
        return battery.charges


class IsBatteryLow(IsBatteryCharging):
    """Succeeds where a battery has no more than some share (0..1), or voltage, left."""

    min_battery = Port(NUMBER)
    is_voltage = Port(TRUTH, False)

    def _judge(self, battery: Battery) -> bool:
        charge = battery.voltage if self.is_voltage else battery.share
        return bool(charge <= self.min_battery)
