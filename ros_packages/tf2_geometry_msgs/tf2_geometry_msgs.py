"""Transforms for messages of geometry_msgs."""

from __future__ import annotations

from typing import Any

import numpy as np
from geometry_msgs.msg import (
    PointStamped,
    Pose,
    PoseStamped,
    PoseWithCovarianceStamped,
    TransformStamped,
    Vector3Stamped,
)
from tf2_ros import TransformRegistration

from arjuna_core.pose3 import Pose3
from arjuna_core.ros.convert import pose3_from_transform, pose3_msg


def _motion(transform: TransformStamped) -> Pose3:
    return pose3_from_transform(transform.transform)


def _put(point: Any, values: Any) -> None:
    point.x, point.y, point.z = (float(value) for value in values)


def do_transform_point(point: PointStamped, transform: TransformStamped) -> PointStamped:
    moved = PointStamped(header=transform.header)
    p = point.point
    _put(moved.point, _motion(transform).apply(np.array([[p.x, p.y, p.z]]))[0])
    return moved


def do_transform_vector3(vector3: Vector3Stamped, transform: TransformStamped) -> Vector3Stamped:
    """Return a direction in the transform's frame: turned, not moved."""
    moved = Vector3Stamped(header=transform.header)
    v = vector3.vector
    _put(moved.vector, _motion(transform).rotation() @ np.array([v.x, v.y, v.z]))
    return moved


def do_transform_pose(pose: Pose, transform: TransformStamped) -> Pose:
    """Return a pose without a header in the transform's frame."""
    p, q = pose.position, pose.orientation
    return pose3_msg(_motion(transform) @ Pose3((p.x, p.y, p.z), (q.w, q.x, q.y, q.z)))


def do_transform_pose_stamped(pose: PoseStamped, transform: TransformStamped) -> PoseStamped:
    return PoseStamped(header=transform.header, pose=do_transform_pose(pose.pose, transform))


def transform_covariance(cov_in: Any, transform: TransformStamped) -> Any:
    """Return a covariance of position and rotation `(36,)` in the transform's frame."""
    rotation = _motion(transform).rotation()
    both = np.kron(np.eye(2), rotation)
    return (both @ np.array(cov_in, dtype=float).reshape(6, 6) @ both.T).reshape(36)


def do_transform_pose_with_covariance_stamped(
    pose: PoseWithCovarianceStamped, transform: TransformStamped
) -> PoseWithCovarianceStamped:
    """Return a pose with its covariance in the transform's frame."""
    moved = PoseWithCovarianceStamped(header=transform.header)
    moved.pose.pose = do_transform_pose(pose.pose.pose, transform)
    moved.pose.covariance = transform_covariance(pose.pose.covariance, transform)
    return moved


for _type, _function in (
    (PointStamped, do_transform_point),
    (Vector3Stamped, do_transform_vector3),
    (PoseStamped, do_transform_pose_stamped),
    (PoseWithCovarianceStamped, do_transform_pose_with_covariance_stamped),
):
    TransformRegistration().add(_type, _function)
