"""Actions that ask nobody: entries of the blackboard, goals, paths, and the choice of plug-ins.

Source: nav2_behavior_tree, plugins/action; BehaviorTree.CPP 4, actions.
"""

from __future__ import annotations

import math
from operator import is_
from typing import Any, ClassVar

import numpy as np

from arjuna_core.se2 import SE2
from arjuna_nav.planners import path as paths
from arjuna_nav.trees.exchange import Topic, TopicKind
from arjuna_nav.trees.node import Framed, Status, TreeNode
from arjuna_nav.trees.ports import ANY, NUMBER, PATH, POSE, POSES, SCRIPT, TEXT, WHOLE, Port


class SetBlackboard(TreeNode):
    """Writes an entry."""

    value = Port(ANY)
    output_key = Port(ANY)

    def _tick(self) -> Status:
        self.named_entry("output_key").set(self.value)
        return Status.SUCCESS


class UnsetBlackboard(TreeNode):
    """Removes an entry."""

    key = Port(ANY)

    def _tick(self) -> Status:
        self.named_entry("key").set(None)
        return Status.SUCCESS


class Script(TreeNode):
    """Runs a script."""

    code = Port(SCRIPT)

    def _tick(self) -> Status:
        self.code.run(self.board)
        return Status.SUCCESS


class Sleep(TreeNode):
    """Runs for a while, then succeeds."""

    msec = Port(NUMBER)

    def _tick(self) -> Status:
        return Status.SUCCESS if self.elapsed >= self.msec else Status.RUNNING


class RemovePassedGoals(Framed):
    """Removes goals from the first on while the robot is near them; the last one stays."""

    input_goals = Port(POSES)
    output_goals = Port(POSES, None, output=True)
    radius = Port(NUMBER, 0.5)
    input_waypoint_statuses = Port(ANY, None)
    output_waypoint_statuses = Port(ANY, None, output=True)

    def _tick(self) -> Status:
        goals, pose = self.input_goals, self.tree.state.robot(base=self.robot_base_frame)
        if pose is None:
            return Status.FAILURE
        while len(goals) > 1 and pose.distance(goals[0]) <= self.radius:
            goals = goals[1:]
        self.output_goals = goals
        return Status.SUCCESS


class GetNextFewGoals(TreeNode):
    """Takes the first goals, at most so many; fails where there is none."""

    input_goals = Port(POSES)
    output_goals = Port(POSES, None, output=True)
    num_goals = Port(WHOLE)

    def _tick(self) -> Status:
        goals = self.input_goals
        if not goals:
            return Status.FAILURE
        self.output_goals = goals[: self.num_goals]
        return Status.SUCCESS


class AppendGoalPoseToGoals(TreeNode):
    """Puts a pose behind the goals."""

    goal_pose = Port(POSE)
    input_goals = Port(POSES, ())
    output_goals = Port(POSES, None, output=True)

    def _tick(self) -> Status:
        self.output_goals = (*self.input_goals, self.goal_pose)
        return Status.SUCCESS


class ExtractRouteNodesAsGoals(TreeNode):
    """Makes goals of a route's nodes; fails where it has none."""

    route = Port(POSES)
    goals = Port(POSES, None, output=True)

    def _tick(self) -> Status:
        route = self.route
        if not route:
            return Status.FAILURE
        self.goals = tuple(SE2(node.x, node.y) for node in route)
        return Status.SUCCESS


class _Selector(TreeNode):
    """Writes the plug-in that was chosen on a topic, or a default; an empty one is the server's."""

    SELECTED: ClassVar[str]

    def _tick(self) -> Status:
        chosen = self.tree.state.selected.get(self.topic("topic_name"), "")
        chosen = chosen or self.get(f"default_{self.SELECTED}")
        if chosen is None:
            return Status.FAILURE
        self.put(f"selected_{self.SELECTED}", chosen)
        return Status.SUCCESS

    def topics(self) -> set[Topic]:
        """Return the topic on which it is chosen."""
        return {Topic(TopicKind.CHOICE, self.topic("topic_name"))}


def _selector(name: str, selected: str) -> type[TreeNode]:
    ports = {
        "topic_name": Port(TEXT, f"{selected}_selector"),
        f"default_{selected}": Port(TEXT, None),
        f"selected_{selected}": Port(TEXT, "", output=True),
    }
    return type(name, (_Selector,), {"SELECTED": selected, **ports})


SELECTORS: dict[str, type[TreeNode]] = {
    name: _selector(name, selected)
    for name, selected in (
        *(("PlannerSelector", "planner"), ("ControllerSelector", "controller")),
        *(("SmootherSelector", "smoother"), ("GoalCheckerSelector", "goal_checker")),
        ("ProgressCheckerSelector", "progress_checker"),
    )
}
"""The selectors of plug-ins."""


class _OfPaths(TreeNode):
    _sources: tuple[Any, ...] = ()
    _made: Any = None

    def _write(self, made: Any, *sources: Any) -> Status:
        """Write it; where it is as before, of the same paths, as the same array."""
        same = len(sources) == len(self._sources) and all(map(is_, sources, self._sources))
        if not same or not np.array_equal(made, self._made):
            self._made = made
        self._sources = sources
        self.output_path = self._made
        return Status.SUCCESS


class TruncatePath(_OfPaths):
    """Leaves out of a path what is near its end, but two poses; the last one faces the end.

    Where all of it is near, as of a robot that has come up to what it follows, both are its start:
    Nav2 keeps the pose after it, which is within its tolerances, and ours go to it exactly.
    """

    distance = Port(NUMBER, 1.0)
    input_path = Port(PATH)
    output_path = Port(PATH, None, output=True)

    def _tick(self) -> Status:
        path = self.input_path
        if not len(path):
            return self._write(path, path)
        gaps = path[-1, :2] - path[:, :2]
        far = np.flatnonzero(np.hypot(*gaps.T) >= self.distance)
        kept = path[: max(far[-1] + 1 if len(far) else 0, 2)].copy()
        if len(far) < 2:
            kept[:, :2], gaps = kept[0, :2], gaps[:1].repeat(len(kept), axis=0)
        dx, dy = gaps[len(kept) - 1].tolist()
        kept[-1, 2] = math.atan2(dy, dx)
        return self._write(kept, path)


class TruncatePathLocal(_OfPaths):
    """Leaves out of a path what is far from the robot, along the path, ahead and behind.

    On the same path the search begins at the index found last.
    """

    input_path = Port(PATH)
    output_path = Port(PATH, None, output=True)
    distance_forward = Port(NUMBER, 8.0)
    distance_backward = Port(NUMBER, 4.0)
    robot_frame = Port(TEXT, "")
    transform_tolerance = Port(NUMBER, 0.2)
    pose = Port(POSE, None)
    angular_distance_weight = Port(NUMBER, 0.0)
    max_robot_pose_search_dist = Port(NUMBER, math.inf)
    _path: Any = None
    _at = 0

    def _tick(self) -> Status:
        path = self.input_path
        pose = self.pose or self.tree.state.robot(base=self.robot_frame)
        if not len(path):
            return self._write(path, path)
        if pose is None:
            return Status.FAILURE
        if path is not self._path:
            self._path, self._at = path, 0
        reach, turning = self.max_robot_pose_search_dist, self.angular_distance_weight
        self._at = paths.nearest(path, pose, self._at, max(reach, 0.0), turning)
        lengths = paths.along(path)
        ahead = lengths - lengths[self._at]
        kept = (ahead <= self.distance_forward) & (-ahead <= self.distance_backward)
        return self._write(path[kept], path)


class ConcatenatePaths(_OfPaths):
    """Joins two paths; one alone stays as it is."""

    input_path1 = Port(PATH, None)
    input_path2 = Port(PATH, None)
    output_path = Port(PATH, None, output=True)

    def _tick(self) -> Status:
        both = (self.input_path1, self.input_path2)
        parts = [path for path in both if path is not None and len(path)]
        if not parts:
            return Status.FAILURE
        return self._write(np.concatenate(parts), *parts)


class GetPoseFromPath(TreeNode):
    """Takes one pose of a path, -1 for the last; fails where the path has none there."""

    path = Port(PATH)
    index = Port(WHOLE, 0)
    pose = Port(POSE, None, output=True)

    def _tick(self) -> Status:
        path, index = self.path, self.index
        if not -len(path) <= index < len(path):
            return Status.FAILURE
        self.pose = SE2(*path[index].tolist())
        return Status.SUCCESS


class GetCurrentPose(Framed):
    """Writes the robot's pose, seen from the navigator's frame; fails where it is not known."""

    current_pose = Port(POSE, None, output=True)

    def _tick(self) -> Status:
        pose = self.tree.state.robot(base=self.robot_base_frame)
        self.current_pose = pose
        return Status.FAILURE if pose is None else Status.SUCCESS
