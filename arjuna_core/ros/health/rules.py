"""Limits and consistency rules of what a message holds; they import no ROS.

The limits are far more than any robot needs and far less than hurts.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from arjuna_core.timing import NANOSECONDS

GREATEST = 1e12  # of a number, its sign aside: squares of it stay exact enough
FARTHEST = 1e7  # from the origin of a frame [m]: beyond it a float32 resolves no metre
FUTURE = 10.0  # a measurement's stamp ahead of the clock [s]
TEXT = 4096  # characters of a name, a path or a frame
DOCUMENT = 2**24  # characters of a description or a file's text
DOCUMENTS = ("resource_string", "data", "text", "description", "string_value")  # hold such
LISTED = 2**21  # bytes of a message of lists alone, as a path: 20 000 poses, 0.1 s to read
OUTLINE = 20.0  # from a robot's origin to a corner of its outline [m]
BEAMS = 20_000  # of a scan
CELLS = 2**25  # of a map: 290 m x 290 m at 5 cm
FINEST, COARSEST = 0.004, 100.0  # edge of a map's cell [m]
POSES = 15_000  # of a path: 750 m, one each five centimetres
CORNERS = 1000  # of a polygon
CALLS = 1000  # parameters of one request to a node, and names of any list
_COSTMAP = "nav2_msgs/msg/Costmap"
ITEMS = 10_000  # of a list of a type that LONGEST does not name
LONGEST = {  # items of a list, by their type
    **dict.fromkeys(("geometry_msgs/PoseStamped", "geometry_msgs/Pose"), POSES),
    **dict.fromkeys(("geometry_msgs/Point32", "geometry_msgs/Point"), CORNERS),
    **dict.fromkeys(("rcl_interfaces/Parameter", "string"), CALLS),
    **dict.fromkeys(("double", "float"), 2**20),
    **dict.fromkeys(("uint8", "int8", "octet"), 2**26),
}

_MEASUREMENTS = ("LaserScan", "Odometry", "Imu", "JointState", "PointCloud2", "Image", "Range")
_PARAMETER_TYPES = 9  # rcl_interfaces/ParameterType, the last
_REALS = {7: 4, 8: 8}  # bytes of PointField.FLOAT32 and FLOAT64


def rotation_problem(rotation: Any) -> str | None:
    """Return why a quaternion, which need not be normalised, is no rotation."""
    x, y, z, w = rotation.x, rotation.y, rotation.z, rotation.w
    if 1e-12 <= x * x + y * y + z * z + w * w <= GREATEST:
        return None
    return f"quaternion ({x}, {y}, {z}, {w}) is no rotation"


def duration_problem(duration: Any) -> str | None:
    """Return why a duration, or a time, has too many nanoseconds."""
    if duration.nanosec < NANOSECONDS:
        return None
    return f"{duration.nanosec} ns; valid: less than {NANOSECONDS}"


def time_problem(time: Any) -> str | None:
    """Return why a time cannot be."""
    return duration_problem(time) or (f"{time.sec} s; valid: from 0" if time.sec < 0 else None)


def stamp_problem(message: Any, now: float) -> str | None:
    """Return why a measurement's stamp is implausible; None while the clock stands at 0."""
    if now <= 0.0 or type(message).__name__ not in _MEASUREMENTS:
        return None
    ahead = message.header.stamp.sec - now
    if ahead <= FUTURE:
        return None
    return f"its stamp is {ahead:.0f} s ahead of the clock; does its sender use sim time?"


def scan_problem(scan: Any) -> str | None:
    """Return why a scan's geometry cannot be; ranges may be inf or NaN (REP 117)."""
    beams = len(scan.ranges)
    if not 1 <= beams <= BEAMS:
        return f"{beams} beams; valid: 1 to {BEAMS}"
    if beams > 1 and not 1e-6 <= abs(scan.angle_increment) <= math.tau:
        return f"angle_increment is {scan.angle_increment} rad; valid: 1e-6 to 2 pi, or negative"
    sweep = abs(scan.angle_increment) * (beams - 1)
    if not (sweep <= 2.0 * math.tau and abs(scan.angle_min) <= 2.0 * math.tau):  # NaN is neither
        return f"{beams} beams from {scan.angle_min} rad, each {scan.angle_increment} rad on"
    if not 0.0 <= scan.range_min < scan.range_max <= FARTHEST:
        return f"ranges from {scan.range_min} to {scan.range_max} m; valid: 0 <= min < max"
    if not abs(scan.time_increment) * beams <= FUTURE:
        return f"{beams} beams, each {scan.time_increment} s on"
    return None


def range_problem(reading: Any) -> str | None:
    """Return why a sonar's cone cannot be; its range may be inf or NaN."""
    if not 0.0 < reading.field_of_view <= math.tau:
        return f"field_of_view is {reading.field_of_view} rad; valid: above 0, to 2 pi"
    if not 0.0 <= reading.min_range <= reading.max_range <= FARTHEST:
        return f"ranges from {reading.min_range} to {reading.max_range} m; valid: 0 <= min <= max"
    return None


def cloud_problem(cloud: Any) -> str | None:
    """Return why a cloud's layout cannot be; points may be inf or NaN."""
    size, row = cloud.width * cloud.height, cloud.width * cloud.point_step
    if cloud.row_step < row or cloud.row_step * cloud.height > len(cloud.data):
        layout = f"{cloud.height} rows of {cloud.width} points, {cloud.point_step} bytes each"
        return f"{len(cloud.data)} bytes for {layout}, {cloud.row_step} bytes a row"
    fields = {each.name: each for each in cloud.fields}
    for name in "xyz" if size else "":
        sort = fields[name].datatype if name in fields else 0
        if sort not in _REALS or fields[name].offset + _REALS[sort] > cloud.point_step:
            return f"'{name}' is no field of a point; valid: float32 or float64 within point_step"
    return None


def grid_problem(grid: Any) -> str | None:
    """Return why a map cannot be."""
    return _cells_problem(grid.info.resolution, grid.info.width, grid.info.height, grid.data)


def costmap_problem(costmap: Any) -> str | None:
    """Return why a costmap cannot be."""
    data = costmap.metadata
    return _cells_problem(data.resolution, data.size_x, data.size_y, costmap.data)


def _cells_problem(resolution: float, width: int, height: int, data: Any) -> str | None:
    resolution, cells = round(float(resolution), 6), width * height
    if not FINEST <= resolution <= COARSEST:
        return f"cells of {resolution} m; valid: {FINEST} to {COARSEST}"
    if not 1 <= cells <= CELLS or cells != len(data):
        return f"{len(data)} cells for {width} x {height}; valid: as many, 1 to {CELLS}"
    return None


def imu_problem(imu: Any) -> str | None:
    """Return why an IMU's orientation cannot be; a covariance of -1 says that there is none."""
    return None if imu.orientation_covariance[0] == -1.0 else rotation_problem(imu.orientation)


def covariance_problem(item: Any) -> str | None:
    """Return why a pose's covariance cannot be."""
    variances = np.asarray(item.covariance)[::7]
    if (variances >= 0.0).all():
        return None
    return f"a variance is {variances.min()}; valid: 0 and more"


def pose_problem(pose: Any) -> str | None:
    """Return why a pose's position is implausible; every rotation has its own check."""
    return _position_problem("position", pose.position)


def _position_problem(name: str, at: Any) -> str | None:
    if abs(at.x) <= FARTHEST and abs(at.y) <= FARTHEST and abs(at.z) <= FARTHEST:
        return None
    return f"{name} ({at.x}, {at.y}, {at.z}) is farther than {FARTHEST:g} m"


def transform_problem(stamped: Any) -> str | None:
    """Return why a stamped transform cannot be; it comes often, so its parts are looked at here."""
    parent, child = stamped.header.frame_id, stamped.child_frame_id
    if not parent.strip("/") or not child.strip("/") or parent == child:
        return f"from '{parent[:50]}' to '{child[:50]}'; valid: two names"
    if len(parent) + len(child) > TEXT or stamped.header.stamp.sec < 0:
        return f"names of {len(parent) + len(child)} characters, {stamped.header.stamp.sec} s"
    at, rotation = stamped.transform.translation, stamped.transform.rotation
    return _position_problem("translation", at) or rotation_problem(rotation)


def parameter_problem(value: Any) -> str | None:
    """Return why a parameter's value is of no type."""
    if value.type <= _PARAMETER_TYPES:
        return None
    return f"type {value.type}; valid: 0 to {_PARAMETER_TYPES}"


RULES: dict[str, Callable[[Any], str | None]] = {
    "LaserScan": scan_problem,
    "Range": range_problem,
    "OccupancyGrid": grid_problem,
    "Costmap": costmap_problem,
    "PointCloud2": cloud_problem,
    "Imu": imu_problem,
    "PoseWithCovariance": covariance_problem,
    "Pose": pose_problem,
    "Quaternion": rotation_problem,
    "Time": time_problem,
    "Duration": duration_problem,
    "ParameterValue": parameter_problem,
}
"""The rule of each type that has one, by its name without its package."""


def is_drive(published: Iterable[str]) -> bool:
    """Return whether what publishes such types may drive by the commands that it hears."""
    return _COSTMAP not in published
