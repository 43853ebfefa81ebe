"""Messages as core types, read by their fields alone: of rclpy, or of a recording without ROS."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from arjuna_core.grid import GridFrame, OccupancyGrid
from arjuna_core.scan import Scan
from arjuna_core.se2 import IDENTITY, SE2, yaw_of
from arjuna_core.timing import NANOSECONDS


def seconds(stamp: Any) -> float:
    """Return a Time or Duration message as seconds [s]."""
    return stamp.sec + stamp.nanosec / NANOSECONDS  # type: ignore[no-any-return]


def yaw(rotation: Any) -> float:
    """Return the rotation about z [rad] of a quaternion, which need not be normalised.

    Raises:
        ValueError: The quaternion is zero or not finite.
    """
    return yaw_of(rotation.x, rotation.y, rotation.z, rotation.w)


def se2_from_pose(message: Any) -> SE2:
    """Return a Pose message's planar part.

    Raises:
        ValueError: A coordinate is not finite or the quaternion is no rotation.
    """
    return SE2(*plane_of(message))


def plane_of(message: Any) -> tuple[float, float, float]:
    """Return x, y and yaw of a Pose message [m, m, rad]; raises as `se2_from_pose`."""
    x, y = message.position.x, message.position.y
    if not (math.isfinite(x) and math.isfinite(y)):
        raise ValueError(f"position ({x}, {y}) is not finite")
    return x, y, yaw(message.orientation)


def scan_from_msg(message: Any, T_base_sensor: SE2 = IDENTITY) -> Scan:
    """Return a LaserScan message as a Scan, seen from a sensor pose in the base frame."""
    return Scan(
        np.asarray(message.ranges, dtype=np.float64),
        message.angle_min,
        message.angle_increment,
        message.range_min,
        message.range_max,
        seconds(message.header.stamp),
        message.time_increment,
        T_base_sensor,
    )


def grid_from_msg(message: Any) -> OccupancyGrid:
    """Return an OccupancyGrid message as a grid.

    Raises:
        ValueError: The data's length contradicts the size, or the origin is no pose.
    """
    info = message.info
    # float32 on the wire: the nearest micrometre is the resolution that was meant
    resolution = round(float(info.resolution), 6)
    frame = GridFrame(resolution, info.width, info.height, se2_from_pose(info.origin))
    data = np.asarray(message.data, dtype=np.int8)
    if data.size != info.width * info.height:
        raise ValueError(f"{data.size} cells for a grid of {info.width} x {info.height}")
    return OccupancyGrid(frame, data.reshape(frame.shape), seconds(message.header.stamp))
