"""Messages to core types and back: the only module that knows both."""

from __future__ import annotations

import array
import math
from collections.abc import Mapping
from functools import cache, lru_cache
from types import MappingProxyType
from typing import Any

import numpy as np
from builtin_interfaces.msg import Duration, Time
from geometry_msgs.msg import Pose, PoseStamped, Quaternion, Transform, TransformStamped
from nav_msgs.msg import MapMetaData, Path
from nav_msgs.msg import OccupancyGrid as OccupancyGridMsg
from numpy.typing import NDArray
from sensor_msgs.msg import LaserScan, PointCloud2, PointField
from std_msgs.msg import Header

from arjuna_core.arrays import Floats
from arjuna_core.grid import OccupancyGrid
from arjuna_core.pose3 import Pose3, unit_quaternion
from arjuna_core.readings import grid_from_msg as grid_from_msg
from arjuna_core.readings import plane_of
from arjuna_core.readings import scan_from_msg as scan_from_msg
from arjuna_core.readings import se2_from_pose as se2_from_pose
from arjuna_core.readings import seconds as seconds
from arjuna_core.readings import yaw as yaw
from arjuna_core.ros.messages import maker
from arjuna_core.scan import Cloud, Scan
from arjuna_core.se2 import SE2
from arjuna_core.timing import NANOSECONDS
from arjuna_core.twist import Velocity

_REALS = {7: "f4", 8: "f8"}  # PointField.FLOAT32 and FLOAT64
_STAMP = "header.stamp.sec", "header.stamp.nanosec", "header.frame_id"
_PLANE = "position.x", "position.y", "orientation.z", "orientation.w"
_time, _duration = maker(Time, "sec", "nanosec"), maker(Duration, "sec", "nanosec")
_header = maker(Header, "stamp.sec", "stamp.nanosec", "frame_id")
_pose = maker(Pose, *_PLANE)
_pose_stamped = maker(PoseStamped, *_STAMP, *(f"pose.{name}" for name in _PLANE))
_transform_stamped = maker(
    TransformStamped,
    *(*_STAMP, "child_frame_id", "transform.translation.x", "transform.translation.y"),
    *("transform.rotation.z", "transform.rotation.w"),
)
_SPACE, _TURN = ("x", "y", "z"), ("x", "y", "z", "w")
_pose3 = maker(Pose, *(f"position.{i}" for i in _SPACE), *(f"orientation.{i}" for i in _TURN))
_transform3 = maker(
    TransformStamped,
    *("header", "child_frame_id", *(f"transform.translation.{i}" for i in _SPACE)),
    *(f"transform.rotation.{i}" for i in _TURN),
)


def time_msg(now: float) -> Time:
    """Return a time [s] as a Time message, to the nearest nanosecond."""
    return _time(*_whole(now))


def duration_msg(duration: float) -> Duration:
    """Return a duration [s] as a Duration message, to the nearest nanosecond."""
    return _duration(*_whole(duration))


@lru_cache(maxsize=16)
def _whole(time: float) -> tuple[int, int]:
    return divmod(round(time * NANOSECONDS), NANOSECONDS)


def header(frame_id: str, now: float) -> Header:
    """Return a header for a frame and a time [s]."""
    return _header(*_whole(now), frame_id)


def quaternion(yaw: float) -> Quaternion:
    """Return a rotation about z [rad] as a quaternion."""
    return Quaternion(z=math.sin(yaw / 2.0), w=math.cos(yaw / 2.0))


def pose_msg(pose: SE2) -> Pose:
    """Return a planar pose as a Pose message.

    rclpy writes a whole number of Python's into a float64 as 5e-324, without a word.
    """
    return _pose(*_plane(pose.x, pose.y, pose.theta))


def _plane(x: float, y: float, yaw: float) -> tuple[float, float, float, float]:
    """Return what a pose in the plane has but zeros: x, y [m], and its quaternion's z and w."""
    return float(x), float(y), math.sin(yaw / 2.0), math.cos(yaw / 2.0)


def pose_stamped(pose: SE2, frame_id: str, now: float) -> PoseStamped:
    """Return a planar pose in a frame at a time [s]."""
    plane = _plane(pose.x, pose.y, pose.theta)
    return _pose_stamped(*_whole(now), frame_id, *plane)


def transform_msg(T: SE2, parent: str, child: str, now: float) -> TransformStamped:
    """Return `T_parent_child` at a time [s] as a TransformStamped message."""
    plane = _plane(T.x, T.y, T.theta)
    return _transform_stamped(*_whole(now), parent, child, *plane)


def transform3_msg(T: Pose3, parent: str, child: str, now: float) -> TransformStamped:
    """Return `T_parent_child` in space at a time [s] as a TransformStamped message."""
    w, *turn = T.quaternion
    return _transform3(header(parent, now), child, *T.position, *turn, w)


def pose3_msg(pose: Pose3) -> Pose:
    """Return a pose of space as a Pose message."""
    w, *turn = pose.quaternion
    return _pose3(*pose.position, *turn, w)


def se2_from_transform(message: Transform) -> SE2:
    """Return a Transform message's planar part."""
    return SE2(message.translation.x, message.translation.y, yaw(message.rotation))


def pose3_from_transform(message: Transform) -> Pose3:
    """Return a Transform message in space; its quaternion need not be normalised."""
    at, turn = message.translation, message.rotation
    return Pose3((at.x, at.y, at.z), unit_quaternion(turn.w, turn.x, turn.y, turn.z))


def cloud_from_msg(
    message: PointCloud2, T_base_sensor: Pose3, most: int = 30_000, height: str = ""
) -> Cloud:
    """Return the points of a PointCloud2 message that are finite, seen from the robot's base.

    Args:
        message: The message, its layout as `cloud_problem` wants it.
        T_base_sensor: Pose of its frame in the base.
        most: Of more points every second, third, ... is taken.
        height: A field that holds the points' heights; empty where the base's are.

    Raises:
        ValueError: It has no such field of reals.
    """
    position, stamp = np.array(T_base_sensor.position), seconds(message.header.stamp)
    if message.width * message.height == 0:
        return Cloud(np.zeros((0, 3)), position, stamp)
    order = ">" if message.is_bigendian else "<"
    fields = {each.name: each for each in message.fields}
    if height and (height not in fields or fields[height].datatype not in _REALS):
        raise ValueError(f"the cloud has no field '{height}' of float32 or float64")
    shape, strides = (message.height, message.width), (message.row_step, message.point_step)
    step = -(-message.width * message.height // most)
    names = [*"xyz", height] if height else [*"xyz"]
    points = np.empty((-(-message.width * message.height // step), len(names)))
    for column, name in enumerate(names):
        kind, offset = order + _REALS[fields[name].datatype], fields[name].offset
        values: NDArray[Any] = np.ndarray(shape, kind, message.data, offset, strides)
        points[:, column] = values.reshape(-1)[::step]
    finite = np.isfinite(points[:, :3])
    if not finite.all():
        points = points[finite.all(axis=1)]
    placed = T_base_sensor.apply(points[:, :3])
    if height:
        placed[:, 2] = points[:, 3]
    return Cloud(placed, position, stamp)


def scan_msg(scan: Scan, frame_id: str, scan_time: float) -> LaserScan:
    """Return a Scan as a LaserScan message; `scan_time` is the sweep's period [s]."""
    return LaserScan(
        header=header(frame_id, scan.stamp),
        angle_min=scan.angle_min,
        angle_max=scan.angle_min + scan.angle_increment * (len(scan.ranges) - 1),
        angle_increment=scan.angle_increment,
        time_increment=scan.time_increment,
        scan_time=scan_time,
        range_min=scan.range_min,
        range_max=scan.range_max,
        ranges=array.array("f", scan.ranges.astype(np.float32).tobytes()),
    )


def grid_msg(grid: OccupancyGrid, frame_id: str, now: float) -> OccupancyGridMsg:
    """Return a grid as an OccupancyGrid message stamped with a time [s]."""
    info = MapMetaData(
        map_load_time=time_msg(grid.stamp),
        resolution=grid.frame.resolution,
        width=grid.frame.width,
        height=grid.frame.height,
        origin=pose_msg(grid.frame.origin),
    )
    data = array.array("b", grid.data.tobytes())
    return OccupancyGridMsg(header=header(frame_id, now), info=info, data=data)


def path_msg(poses: Floats, frame_id: str, now: float) -> Path:
    """Return poses `(N, 3) float64` of `x, y, yaw` as a Path message."""
    sec, nanosec = _whole(now)
    stamped = [
        _pose_stamped(sec, nanosec, frame_id, *_plane(x, y, theta))
        for x, y, theta in np.asarray(poses, np.float64).tolist()
    ]
    return Path(header=header(frame_id, now), poses=stamped)


def poses_from_path(message: Path) -> Floats:
    """Return a Path message's poses as `(N, 3) float64` of `x, y, yaw`.

    Raises:
        ValueError: A pose is not finite.
    """
    rows = [plane_of(item.pose) for item in message.poses]
    return np.array(rows, dtype=np.float64).reshape(-1, 3)


PLANAR = np.array([0, 1, 5, 6, 7, 11, 30, 31, 35])
"""Places of x, y and yaw in a message's 6 x 6 covariance, row by row."""


def planar_covariance(covariance: Floats) -> Floats:
    """Spread a `(3, 3)` covariance of x, y, yaw over a pose message's `(36,) float64`."""
    full = np.zeros(36)
    full[PLANAR] = np.asarray(covariance).ravel()
    return full


def velocity_from_twist(message: Any) -> Velocity:
    """Return the planar part of a Twist."""
    return Velocity(message.linear.x, y=message.linear.y, yaw_rate=message.angular.z)


def covariance_from_pose(covariance: Any) -> Floats:
    """Return the `(3, 3)` covariance of x, y, yaw in a pose message's 36 values."""
    planar: Floats = np.asarray(covariance, dtype=np.float64)[PLANAR].reshape(3, 3)
    return planar


_TYPES = {"<f4": PointField.FLOAT32, "<u2": PointField.UINT16}


def cloud_msg(
    points: NDArray[Any],
    frame: str,
    now: float,
    channels: Mapping[str, NDArray[Any]] = MappingProxyType({}),
) -> PointCloud2:
    """Return points `(N, 3)` [m] at a time [s], and values `(N,)` of theirs by name."""
    others = [(name, values.dtype) for name, values in channels.items()]
    kind = np.dtype([*((axis, np.dtype("<f4")) for axis in "xyz"), *others])
    packed = np.zeros(len(points), kind)
    for name, values in (*zip("xyz", points.T, strict=True), *channels.items()):
        packed[name] = values
    data = array.array("B", packed.tobytes())
    layout = {"height": 1, "width": len(points), "point_step": kind.itemsize, "row_step": len(data)}
    stamped = header(frame, now)
    return PointCloud2(header=stamped, fields=_fields(kind), data=data, is_dense=True, **layout)


@cache
def _fields(kind: np.dtype[Any]) -> list[PointField]:
    assert kind.fields is not None
    return [
        PointField(name=name, offset=offset, datatype=_TYPES[each.str], count=1)
        for name, (each, offset, *_) in kind.fields.items()
    ]
