"""The robot's pose, and the poses of messages."""

from __future__ import annotations

from typing import Any

from arjuna_core.arrays import Floats
from arjuna_core.ros.convert import poses_from_path, se2_from_pose
from arjuna_core.ros.goal_server import GoalError
from arjuna_core.ros.node import ManagedNode
from arjuna_core.ros.tf import TransformError
from arjuna_core.se2 import SE2
from arjuna_core.timing import other_clock

_ODOMETRY = "odom"  # where the base moves while it is in no map yet


def robot_pose(
    node: ManagedNode, frame: str, base: str, tolerance: float, *, any_clock: bool = False
) -> SE2:
    """Return the robot's newest pose in a frame.

    Args:
        node: Whose transforms and clock count.
        frame: The pose's.
        base: The robot's.
        tolerance: How old it may be [s].
        any_clock: Whether it may be stamped by another clock, which is logged, as in Nav2's
            servers without a costmap of their own.

    Raises:
        TransformError: It is not known, or too old.
    """
    transforms = node.transforms
    try:
        stamp = transforms.latest_common(frame, base)
    except TransformError as error:
        fixed = frame if transforms.base_below(frame) else _ODOMETRY
        missing = transforms.missing_base("robot_base_frame", base, fixed)
        raise TransformError(missing or str(error)) from error
    age = node.now - stamp
    if stamp and age > tolerance:
        remedy = other_clock(age)
        why = remedy or f"over the tolerance of {tolerance:g} s"
        problem = f"{frame} -> {base} is {age:.2f} s old, {why}"
        if not (any_clock and remedy):
            raise TransformError(problem)
        node.get_logger().warning(problem, once=True)
    return node.transforms.lookup(frame, base)


def pose_in(node: ManagedNode, frame: str, message: Any) -> SE2:
    """Return a PoseStamped message's pose in a frame.

    Raises:
        TransformError: It names no frame, the frames are not connected, or the pose is none.
    """
    source = message.header.frame_id.lstrip("/")
    if not source:
        raise TransformError(f"the pose's frame_id is empty; valid: '{frame}', or one it has")
    try:
        pose = se2_from_pose(message.pose)
    except ValueError as error:
        raise TransformError(f"invalid pose: {error}") from error
    return pose if source == frame else node.transforms.lookup(frame, source) @ pose


def poses_of(path: Any, code: int) -> Floats:
    """Return the poses `(N, 3)` of a goal's path, in its own frame.

    Raises:
        GoalError: It has none, or one that is invalid; with this code.
    """
    try:
        poses = poses_from_path(path)
    except ValueError as error:
        raise GoalError(code, str(error)) from error
    if not len(poses):
        raise GoalError(code, "the path has 0 poses, at least 1 is needed")
    return poses
