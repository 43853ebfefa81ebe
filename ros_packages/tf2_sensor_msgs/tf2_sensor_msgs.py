"""Transforms for messages of sensor_msgs."""

from __future__ import annotations

from typing import Any

import numpy as np
from geometry_msgs.msg import Transform, TransformStamped
from numpy.typing import NDArray
from sensor_msgs.msg import PointCloud2
from sensor_msgs_py.point_cloud2 import create_cloud, read_points
from tf2_ros import TransformRegistration

from arjuna_core.pose3 import Pose3
from arjuna_core.ros.convert import pose3_from_transform


def transform_points(point_cloud: NDArray[Any], transform: Transform) -> NDArray[np.float64]:
    """Return points `(N, 3)` in the transform's frame."""
    return pose3_from_transform(transform).apply(np.asarray(point_cloud, np.float64))


def do_transform_cloud(cloud: PointCloud2, transform: TransformStamped) -> PointCloud2:
    """Return a cloud in the transform's frame; normals are turned, other fields stay."""
    points = read_points(cloud).copy()
    motion, names = pose3_from_transform(transform.transform), points.dtype.names or ()
    for axes, change in (
        (("x", "y", "z"), motion.apply),
        (("vp_x", "vp_y", "vp_z"), motion.apply),
        (("normal_x", "normal_y", "normal_z"), Pose3(quaternion=motion.quaternion).apply),
    ):
        if set(axes) <= set(names):
            moved = change(np.column_stack([points[name] for name in axes]).astype(np.float64))
            for number, name in enumerate(axes):
                points[name] = moved[:, number]
    organized = points.reshape(cloud.height, cloud.width) if cloud.height > 1 else points
    result = create_cloud(transform.header, cloud.fields, organized, cloud.point_step)
    result.is_dense = cloud.is_dense
    return result


TransformRegistration().add(PointCloud2, do_transform_cloud)
