"""Nav2's actions on paths and poses.

Source: nav2_behavior_tree, plugins/action.
"""

from __future__ import annotations

import math
from operator import is_
from typing import Any, ClassVar

import numpy as np

from arjuna_core.se2 import SE2
from arjuna_nav.planners import path as paths
from arjuna_nav.trees.node import Status, TreeNode
from arjuna_nav.trees.ports import NUMBER, PATH, POSE, TEXT, WHOLE, Port


class _OfPaths(TreeNode):
    """Makes a path of others."""

    _sources: tuple[Any, ...] = ()
    _made: Any = None

    def write(self, made: Any, *sources: Any) -> Status:
        """Write it; where it is as before, of the same paths, as the same, not followed anew."""
        same = len(sources) == len(self._sources) and all(map(is_, sources, self._sources))
        if not same or not np.array_equal(made, self._made):
            self._made = made
        self._sources = sources
        self.put("output_path", self._made)
        return Status.SUCCESS


class TruncatePath(_OfPaths):
    """Leaves the end of a path out."""

    PORTS: ClassVar[dict[str, Port]] = {
        "distance": Port(NUMBER, 1.0),
        "input_path": Port(PATH),
        "output_path": Port(PATH, None, output=True),
    }

    def tick(self) -> Status:
        """Leave it out; a path that is shorter keeps its first pose."""
        path = self.get("input_path")
        left = paths.along(path[::-1])
        kept = int(np.count_nonzero(left >= self.get("distance")))
        return self.write(path[: max(kept, 1)], path)


class TruncatePathLocal(_OfPaths):
    """Leaves out of a path what is far from the robot, along the path, ahead and behind.

    On the same path the robot is looked for from where it was found last.
    """

    PORTS: ClassVar[dict[str, Port]] = {
        "input_path": Port(PATH),
        "output_path": Port(PATH, None, output=True),
        "distance_forward": Port(NUMBER, 8.0),
        "distance_backward": Port(NUMBER, 4.0),
        "robot_frame": Port(TEXT, ""),
        "transform_tolerance": Port(NUMBER, 0.2),
        "pose": Port(POSE, None),
        "angular_distance_weight": Port(NUMBER, 0.0),
        "max_robot_pose_search_dist": Port(NUMBER, math.inf),
    }
    _path: Any = None
    _at = 0

    def tick(self) -> Status:
        """Leave it out."""
        path, pose = self.get("input_path"), self.get("pose") or self.running.state.pose
        if not len(path):
            return self.write(path, path)
        if pose is None:
            return Status.FAILURE
        if path is not self._path:
            self._path, self._at = path, 0
        reach, turning = self.get("max_robot_pose_search_dist"), self.get("angular_distance_weight")
        self._at = paths.nearest(path, pose, self._at, max(reach, 0.0), turning)
        way = paths.along(path)
        ahead = way - way[self._at]
        kept = (ahead <= self.get("distance_forward")) & (-ahead <= self.get("distance_backward"))
        return self.write(path[kept], path)


class ConcatenatePaths(_OfPaths):
    """Joins two paths; one alone stays as it is."""

    PORTS: ClassVar[dict[str, Port]] = {
        "input_path1": Port(PATH, None),
        "input_path2": Port(PATH, None),
        "output_path": Port(PATH, None, output=True),
    }

    def tick(self) -> Status:
        """Join them."""
        both = [path for name in ("input_path1", "input_path2") for path in [self.get(name)]]
        parts = [path for path in both if path is not None and len(path)]
        if not parts:
            return Status.FAILURE
        return self.write(np.concatenate(parts), *parts)


class GetPoseFromPath(TreeNode):
    """Takes one pose of a path, -1 for the last."""

    PORTS: ClassVar[dict[str, Port]] = {
        "path": Port(PATH),
        "index": Port(WHOLE, 0),
        "pose": Port(POSE, None, output=True),
    }

    def tick(self) -> Status:
        """Take it; fail where the path has none there."""
        path, index = self.get("path"), self.get("index")
        if not -len(path) <= index < len(path):
            return Status.FAILURE
        self.put("pose", SE2(*path[index].tolist()))
        return Status.SUCCESS


class GetCurrentPose(TreeNode):
    """Tells where the robot is."""

    PORTS: ClassVar[dict[str, Port]] = {
        "global_frame": Port(TEXT, ""),
        "robot_base_frame": Port(TEXT, ""),
        "current_pose": Port(POSE, None, output=True),
    }

    def tick(self) -> Status:
        """Tell it; fail where it is not known."""
        pose = self.running.state.pose
        self.put("current_pose", pose)
        return Status.FAILURE if pose is None else Status.SUCCESS
