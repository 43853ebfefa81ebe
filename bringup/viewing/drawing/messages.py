"""Messages as drawings, by their types: of rclpy or of a recording, with no ROS installed."""

from __future__ import annotations

import math
import struct
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arjuna_core.pose3 import Pose3
from arjuna_core.readings import grid_from_msg, scan_from_msg, se2_from_pose
from arjuna_core.se2 import SE2
from bringup.viewing.drawing.values import Arrows, Colour, Drawing, Floats, Grid, Line, Points

_SCAN, _GOAL, _BELIEF = (230, 30, 30), (220, 40, 180), (150, 60, 200)
_PLAN, _LOCAL_PLAN, _OUTLINE = (20, 160, 60), (30, 110, 240), (90, 90, 90)
_PARTICLES = (70, 170, 60)
_PARTICLE = np.dtype([("position", "<3f8"), ("quaternion", "<4f8"), ("weight", "<f8")])


def pose3(message: Any) -> Pose3:
    """Return a Pose or Transform message as a pose of space."""
    at = message.position if hasattr(message, "position") else message.translation
    turn = message.orientation if hasattr(message, "orientation") else message.rotation
    return Pose3((at.x, at.y, at.z), (turn.w, turn.x, turn.y, turn.z))


def frame_of(message: Any) -> str:
    """Return the frame of a stamped message."""
    return str(message.header.frame_id).lstrip("/")


def _line(xy: Iterable[tuple[float, float]], z: float) -> Floats:
    rows = np.array([(x, y, z) for x, y in xy], np.float32).reshape(-1, 3)
    if not np.isfinite(rows).all():
        raise ValueError("a position is not finite")
    return rows


def arrow_segments(poses: NDArray[np.float64], length: float, z: float) -> Floats:
    """Return poses `(N, 3)` as segments of a length along their heading, `(N, 2, 3) float32`."""
    segments = np.empty((len(poses), 2, 3), dtype=np.float32)
    segments[:, :, :2], segments[:, :, 2] = poses[:, None, :2], z
    segments[:, 1, 0] += length * np.cos(poses[:, 2])
    segments[:, 1, 1] += length * np.sin(poses[:, 2])
    return segments


def goal_arrow(pose: SE2, frame: str) -> Arrows:
    """Return the arrow of a goal in a frame."""
    return Arrows(frame=frame, segments=arrow_segments(pose.array()[None], 0.5, 0.06), colour=_GOAL)


def _scan(topic: str, message: Any) -> Drawing:
    scan = scan_from_msg(message)
    angles, ranges = scan.angles[scan.valid], scan.ranges[scan.valid]
    points = np.stack([ranges * np.cos(angles), ranges * np.sin(angles), 0.0 * ranges], axis=1)
    return Points(
        frame=frame_of(message), stamp=scan.stamp, points=points.astype(np.float32), colour=_SCAN
    )


def _grid(topic: str, message: Any) -> Drawing:
    grid = grid_from_msg(message)
    opacity, z = None, 0.0
    if "costmap" in topic:
        opacity, z = (0.65, 0.02) if "local" in topic else (0.45, 0.01)
    pose = Pose3.from_se2(grid.frame.origin, z)
    return Grid(frame=frame_of(message), pose=pose, grid=grid, opacity=opacity)


def _path(topic: str, message: Any) -> Drawing:
    at = [each.pose.position for each in message.poses]
    colour, z = (_LOCAL_PLAN, 0.05) if "local" in topic else (_PLAN, 0.03)
    points = _line(((each.x, each.y) for each in at), z)
    return Line(frame=frame_of(message), points=points, colour=colour, width=4.0)


def _markers(topic: str, message: Any) -> Drawing:
    """Return the points of all markers: of trajectories, of SLAM's graph."""
    if not message.markers:
        raise ValueError("it has no marker")
    points = _line(((p.x, p.y) for each in message.markers for p in each.points), 0.04)
    return Points(frame=frame_of(message.markers[0]), points=points, colour=_LOCAL_PLAN, size=0.03)


def _polygon(topic: str, message: Any) -> Drawing:
    points = _line(((each.x, each.y) for each in message.polygon.points), 0.05)
    closed = np.concatenate([points, points[:1]])
    return Line(frame=frame_of(message), points=closed, colour=_OUTLINE, width=2.0)


def _belief(topic: str, message: Any) -> Drawing:
    """Return a line from the mean along the heading to the ellipse of two sigmas, and round it."""
    pose = se2_from_pose(message.pose.pose)
    covariance = np.asarray(message.pose.covariance, dtype=np.float64).reshape(6, 6)[:2, :2]
    if not np.isfinite(covariance).all():
        raise ValueError("its covariance is not finite")
    variances, axes = np.linalg.eigh((covariance + covariance.T) / 2.0)
    half = 2.0 * np.sqrt(np.maximum(variances, 1e-6))
    ahead = axes.T @ (math.cos(pose.theta), math.sin(pose.theta)) / half
    angles = math.atan2(ahead[1], ahead[0]) + np.linspace(0.0, 2.0 * math.pi, 49)
    ring = axes @ (half[:, None] * np.stack([np.cos(angles), np.sin(angles)]))
    outline = np.vstack([(0.0, 0.0), ring.T]) + np.array((pose.x, pose.y))
    return Line(frame=frame_of(message), points=_line(outline, 0.04), colour=_BELIEF)


def _pose(topic: str, message: Any) -> Drawing:
    return goal_arrow(se2_from_pose(message.pose), frame_of(message))


def _poses(topic: str, message: Any) -> Drawing:
    rows = np.array([se2_from_pose(each).array() for each in message.poses]).reshape(-1, 3)
    return _arrows(frame_of(message), rows, 0.2, _BELIEF)


def _particles(topic: str, data: bytes) -> Drawing:
    frame, rows = particles_from_cdr(data)
    return _arrows(frame.lstrip("/"), rows, 0.12, _PARTICLES)


def _arrows(frame: str, rows: NDArray[np.float64], length: float, colour: Colour) -> Drawing:
    segments = arrow_segments(rows, length, 0.03)
    return Arrows(frame=frame, segments=segments, colour=colour, width=length / 8.0)


def particles_from_cdr(data: bytes) -> tuple[str, NDArray[np.float64]]:
    """Read a serialized nav2_msgs/ParticleCloud: rclpy takes 10 us for each of its particles.

    Args:
        data: The message in little-endian CDR: 4 bytes that say so, stamp, frame, particles.

    Returns:
        Its frame, and its poses as `(N, 3) float64` of x, y and yaw.

    Raises:
        ValueError: It is in another encoding, or too short.
    """
    if data[:2] != b"\x00\x01":
        raise ValueError(f"encoding {data[:2].hex()} of a particle cloud is not CDR little-endian")
    try:
        (length,) = struct.unpack_from("<I", data, 12)
        frame = data[16 : 16 + length - 1].decode()
        at = 16 + -(-length // 4) * 4
        (count,) = struct.unpack_from("<I", data, at)
    except struct.error as error:
        raise ValueError(f"a particle cloud of {len(data)} bytes is too short") from error
    start = 4 + -(-at // 8) * 8  # doubles are aligned from behind the first 4 bytes
    cloud = np.frombuffer(data, _PARTICLE, count, start)
    x, y, z, w = cloud["quaternion"].T
    yaw = np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    return frame, np.column_stack([cloud["position"][:, :2], yaw])


SERIALIZED = frozenset({"nav2_msgs/msg/ParticleCloud"})
"""The types whose drawings are made of the message's bytes."""
DRAWN: dict[str, Callable[[str, Any], Drawing]] = {
    "sensor_msgs/msg/LaserScan": _scan,
    "nav_msgs/msg/OccupancyGrid": _grid,
    "nav_msgs/msg/Path": _path,
    "visualization_msgs/msg/MarkerArray": _markers,
    "nav2_msgs/msg/ParticleCloud": _particles,
    "geometry_msgs/msg/PoseArray": _poses,
    "geometry_msgs/msg/PoseStamped": _pose,
    "geometry_msgs/msg/PoseWithCovarianceStamped": _belief,
    "geometry_msgs/msg/PolygonStamped": _polygon,
}
"""For each type what makes a drawing of a topic's name, which chooses colours, and a message.

Each raises ValueError where the message makes no sense.
"""
