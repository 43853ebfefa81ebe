"""Nav2's conditions.

Source: nav2_behavior_tree, plugins/condition.
"""

from __future__ import annotations

from typing import Any, ClassVar

from arjuna_nav.trees.node import Status, TreeNode
from arjuna_nav.trees.ports import CODES, NUMBER, PATH, POSE, POSES, TEXT, WHOLE, Port


class Condition(TreeNode):
    """A node that answers at once."""

    def tick(self) -> Status:
        """Answer."""
        return Status.SUCCESS if self.holds() else Status.FAILURE

    def holds(self) -> bool:
        """Tell whether it is so."""
        raise NotImplementedError


class AlwaysSuccess(Condition):
    """Succeeds."""

    def holds(self) -> bool:
        """It is so."""
        return True


class AlwaysFailure(Condition):
    """Fails."""

    def holds(self) -> bool:
        """It is not so."""
        return False


class GoalUpdated(Condition):
    """Whether the goal has changed since it was asked before, in this branch of the tree."""

    PORTS: ClassVar[dict[str, Port]] = {"goal": Port(POSE, None), "goals": Port(POSES, None)}
    _seen: Any = None

    def holds(self) -> bool:
        """Compare the goals with those seen before."""
        board = self.running.root
        goal, goals = self.get("goal"), self.get("goals")
        now = (goal or board.get("goal"), goals or board.get("goals"))
        before, self._seen = self._seen, now
        return self.remembers() and self._seen != before

    def remembers(self) -> bool:
        """Tell whether it was asked before."""
        return self.status is not Status.IDLE


class GlobalUpdatedGoal(GoalUpdated):
    """Whether the goal has changed since it was asked before, wherever the tree was since.

    The first time it is new.
    """

    def remembers(self) -> bool:
        """Count the first time too."""
        return True


class GoalReached(Condition):
    """Whether the robot is at a pose."""

    PORTS: ClassVar[dict[str, Port]] = {
        "goal": Port(POSE),
        "goal_reached_tol": Port(NUMBER, 0.25),
        "robot_base_frame": Port(TEXT, ""),
        "global_frame": Port(TEXT, ""),
    }

    def holds(self) -> bool:
        """Compare the robot's place with the pose's."""
        pose = self.running.state.pose
        return pose is not None and pose.distance(self.get("goal")) <= self.get("goal_reached_tol")


class InitialPoseReceived(Condition):
    """Whether it is known where the robot is."""

    PORTS: ClassVar[dict[str, Port]] = {"initial_pose_received": Port(TEXT, "")}

    def holds(self) -> bool:
        """Tell whether there is a pose."""
        return self.running.state.pose is not None


class ArePosesNear(Condition):
    """Whether two poses are near each other."""

    PORTS: ClassVar[dict[str, Port]] = {
        "ref_pose": Port(POSE),
        "target_pose": Port(POSE),
        "tolerance": Port(NUMBER, 0.5),
        "global_frame": Port(TEXT, ""),
    }

    def holds(self) -> bool:
        """Compare their places."""
        near = self.get("ref_pose").distance(self.get("target_pose")) <= self.get("tolerance")
        return bool(near)


class TimeExpired(Condition):
    """Whether so much time has passed since it was so before."""

    PORTS: ClassVar[dict[str, Port]] = {"seconds": Port(NUMBER, 1.0)}
    _since = 0.0

    def holds(self) -> bool:
        """Count from the first time."""
        now = self.running.state.now
        if self.status is Status.IDLE:
            self._since = now
            return False
        if now - self._since < self.get("seconds"):
            return False
        self._since = now
        return True


class PathExpiringTimer(Condition):
    """Whether so much time has passed since it was so before; a new path begins it anew."""

    PORTS: ClassVar[dict[str, Port]] = {"seconds": Port(NUMBER, 1.0), "path": Port(PATH, None)}
    _since: float | None = None
    _path: Any = None

    def holds(self) -> bool:
        """Count from the first time, or from when the path changed."""
        path, now = self.get("path"), self.running.state.now
        if self._since is None or path is not self._path:
            self._path, self._since = path, now
        if now - self._since < self.get("seconds"):
            return False
        self._since = now
        return True


class DistanceTraveled(Condition):
    """Whether the robot has gone so far since it was so before."""

    PORTS: ClassVar[dict[str, Port]] = {
        "distance": Port(NUMBER, 1.0),
        "global_frame": Port(TEXT, ""),
        "robot_base_frame": Port(TEXT, ""),
    }
    _start: Any = None

    def holds(self) -> bool:
        """Measure from the first time."""
        pose = self.running.state.pose
        if self.status is Status.IDLE or self._start is None:
            self._start = pose
            return False
        if pose is None or pose.distance(self._start) < self.get("distance"):
            return False
        self._start = pose
        return True


class AreErrorCodesPresent(Condition):
    """Whether an error code is among some."""

    PORTS: ClassVar[dict[str, Port]] = {
        "error_code": Port(WHOLE, 0),
        "error_codes_to_check": Port(CODES, frozenset()),
    }

    def codes(self) -> frozenset[int]:
        """Return the codes looked for."""
        found: frozenset[int] = self.get("error_codes_to_check")
        return found

    def holds(self) -> bool:
        """Compare the code."""
        return self.get("error_code") in self.codes()


class _RecoveryHelps(AreErrorCodesPresent):
    """Whether an error is one that clearing or moving may mend."""

    PORTS: ClassVar[dict[str, Port]] = {"error_code": Port(WHOLE, 0)}
    CODES: ClassVar[frozenset[int]]

    def codes(self) -> frozenset[int]:
        """Return the codes that may be mended."""
        return self.CODES


class WouldAControllerRecoveryHelp(_RecoveryHelps):
    """Unknown, patience exceeded, no progress, no valid control."""

    CODES = frozenset({100, 104, 105, 106})


class WouldAPlannerRecoveryHelp(_RecoveryHelps):
    """Unknown, time-out, no valid path; to a pose and through poses."""

    CODES = frozenset({200, 207, 208, 300, 307, 308})


class WouldASmootherRecoveryHelp(_RecoveryHelps):
    """Unknown, time-out, failed to smooth, smoothed path in collision."""

    CODES = frozenset({500, 502, 503, 504})


class WouldARouteRecoveryHelp(_RecoveryHelps):
    """Unknown, time-out, no valid route."""

    CODES = frozenset({400, 404, 405})
