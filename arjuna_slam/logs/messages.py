"""Scans, odometry and transforms of decoded ROS messages."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from arjuna_core.bags.decoder import DecodeError
from arjuna_core.checks.rules import scan_problem, transform_problem
from arjuna_core.pose3 import Pose3
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2, yaw_of


@dataclass(frozen=True)
class StampedTransform:
    """`T_parent_child` at a time.

    Attributes:
        stamp: Time [s].
        parent: Frame mapped into.
        child: Frame mapped from.
        transform: The planar part.
        mount: The transform in space.
    """

    stamp: float
    parent: str
    child: str
    transform: SE2
    mount: Pose3


def scan_of(message: Any) -> tuple[Scan, str]:
    """Return a sensor_msgs/LaserScan as a scan, the sensor at the base, and its frame.

    Raises:
        DecodeError: Its values are no scan's.
    """
    problem = scan_problem(message)
    if problem is not None:
        raise DecodeError(problem)
    numbers = message.angle_min, message.angle_increment, message.range_min, message.range_max
    with np.errstate(invalid="ignore"):  # damaged bytes
        ranges = np.asarray(message.ranges, dtype=np.float64)
    scan = Scan(ranges, *numbers, _seconds(message.header.stamp), message.time_increment)
    return scan, message.header.frame_id.lstrip("/")


def odometry_of(message: Any) -> StampedTransform:
    """Return the pose of a nav_msgs/Odometry.

    Raises:
        DecodeError: Its values are no pose's.
    """
    return _transform(message, message.pose.pose.position, message.pose.pose.orientation)


def transforms_of(message: Any) -> list[StampedTransform]:
    """Return the transforms of a tf2_msgs/TFMessage.

    Raises:
        DecodeError: The values of one are no transform's.
    """
    for problem in map(transform_problem, message.transforms):
        if problem is not None:
            raise DecodeError(problem)
    return [
        _transform(m, m.transform.translation, m.transform.rotation) for m in message.transforms
    ]


def _transform(message: Any, position: Any, q: Any) -> StampedTransform:
    parent, child = message.header.frame_id.lstrip("/"), message.child_frame_id.lstrip("/")
    try:
        pose = SE2(position.x, position.y, yaw_of(q.x, q.y, q.z, q.w))
    except ValueError as error:
        raise DecodeError(str(error)) from error
    mount = Pose3((position.x, position.y, position.z), (q.w, q.x, q.y, q.z))
    return StampedTransform(_seconds(message.header.stamp), parent, child, pose, mount)


def _seconds(stamp: Any) -> float:
    return float(stamp.sec) + float(stamp.nanosec) / 1e9
