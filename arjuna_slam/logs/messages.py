"""The ROS messages that SLAM needs, read from their bytes by rosbags, so that no ROS is needed."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from rosbags.serde import SerdeError
from rosbags.typesys import Stores, TypesysError, get_types_from_msg, get_typestore

from arjuna_core.checks.rules import scan_problem, transform_problem
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2, is_upside_down, yaw_of

ROS1, ROS2 = "ros1", "cdr"
"""Encodings that can be read."""

SCAN, ODOMETRY = "sensor_msgs/msg/LaserScan", "nav_msgs/msg/Odometry"
TRANSFORMS = ("tf2_msgs/msg/TFMessage", "tf/msg/tfMessage")
_DEFINITION_MAX = 100_000  # characters; longer ones are not looked at


class MessageError(ValueError):
    """Bytes are no message of the type asked for."""


@dataclass(frozen=True)
class StampedTransform:
    """`T_parent_child` at a time.

    Attributes:
        stamp: Time [s].
        parent: Frame mapped into.
        child: Frame mapped from.
        transform: The planar part.
        upside_down: Whether the child's z axis points down in the parent.
    """

    stamp: float
    parent: str
    child: str
    transform: SE2
    upside_down: bool = False


@cache
def _types(encoding: str) -> Any:
    """Return the known definitions; the ones read here are the same from Dashing to Lyrical."""
    if encoding == ROS2:
        return get_typestore(Stores.ROS2_JAZZY)
    types = get_typestore(Stores.ROS1_NOETIC)
    transforms = "geometry_msgs/TransformStamped[] transforms"
    for kind in TRANSFORMS:
        if kind not in types.fielddefs:
            types.register(get_types_from_msg(transforms, kind))
    return types


def is_known(kind: str, encoding: str, definition: str) -> bool:
    """Tell whether a recording means the messages that are known by a type's name.

    Args:
        kind: The type.
        encoding: How its messages are encoded.
        definition: The recording's definition of the type; passed over where there is none or it
            cannot be read.
    """
    if not definition.strip():
        return True
    try:
        found = get_types_from_msg(definition[:_DEFINITION_MAX], kind)
    except (TypesysError, ValueError, RecursionError):
        return True
    known = _types(encoding).fielddefs
    return all(found[name][1] == known[name][1] for name in found.keys() & known.keys())


def read_scan(data: bytes, encoding: str = ROS2) -> tuple[Scan, str]:
    """Return a sensor_msgs/LaserScan as a scan, the sensor at the base, and its frame.

    Args:
        data: The message.
        encoding: How it is encoded.

    Raises:
        MessageError: The bytes are no such message.
    """
    m = _read(data, SCAN, encoding)
    problem = scan_problem(m)
    if problem is not None:
        raise MessageError(problem)
    numbers = m.angle_min, m.angle_increment, m.range_min, m.range_max
    with np.errstate(invalid="ignore"):  # damaged bytes
        ranges = np.asarray(m.ranges, dtype=np.float64)
    scan = Scan(ranges, *numbers, _seconds(m.header.stamp), m.time_increment)
    return scan, m.header.frame_id.lstrip("/")


def read_odometry(data: bytes, encoding: str = ROS2) -> StampedTransform:
    """Return a nav_msgs/Odometry's pose.

    Args:
        data: The message.
        encoding: How it is encoded.

    Raises:
        MessageError: The bytes are no such message.
    """
    m = _read(data, ODOMETRY, encoding)
    return _transform(m, m.pose.pose.position, m.pose.pose.orientation)


def read_transforms(
    data: bytes, encoding: str = ROS2, kind: str = TRANSFORMS[0]
) -> list[StampedTransform]:
    """Return the transforms of a tf2_msgs/TFMessage.

    Args:
        data: The message.
        encoding: How it is encoded.
        kind: Its type, one of `TRANSFORMS`.

    Raises:
        MessageError: The bytes are no such message.
    """
    found: Iterable[Any] = _read(data, kind, encoding).transforms
    for problem in map(transform_problem, found):
        if problem is not None:
            raise MessageError(problem)
    return [_transform(m, m.transform.translation, m.transform.rotation) for m in found]


def _read(data: bytes, kind: str, encoding: str) -> Any:
    types = _types(encoding)
    read = types.deserialize_cdr if encoding == ROS2 else types.deserialize_ros1
    try:
        return read(data, kind)
    except (SerdeError, IndexError) as error:
        raise MessageError(str(error)) from error


def _transform(message: Any, place: Any, q: Any) -> StampedTransform:
    parent, child = message.header.frame_id.lstrip("/"), message.child_frame_id.lstrip("/")
    rotation = q.x, q.y, q.z, q.w
    try:
        pose, upside_down = SE2(place.x, place.y, yaw_of(*rotation)), is_upside_down(*rotation)
    except ValueError as error:
        raise MessageError(str(error)) from error
    return StampedTransform(_seconds(message.header.stamp), parent, child, pose, upside_down)


def _seconds(stamp: Any) -> float:
    return float(stamp.sec) + float(stamp.nanosec) / 1e9
