"""Parts of messages as drawings: of rclpy or of a recording, with no ROS installed."""

from __future__ import annotations

import math
import struct
from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arjuna_core.pose3 import Pose3
from arjuna_core.readings import se2_from_pose
from bringup.viewing.drawing.values import Arrows, Colour, Floats, Line

_PARTICLE = np.dtype([("position", "<3f8"), ("quaternion", "<4f8"), ("weight", "<f8")])


def pose3(message: Any) -> Pose3:
    """Return a Pose or Transform message as a pose of space."""
    at = message.position if hasattr(message, "position") else message.translation
    turn = message.orientation if hasattr(message, "orientation") else message.rotation
    return Pose3((at.x, at.y, at.z), (turn.w, turn.x, turn.y, turn.z))


def frame_of(message: Any) -> str:
    """Return the frame of a stamped message."""
    return str(message.header.frame_id).lstrip("/")


def flat_points(xy: Iterable[tuple[float, float]], z: float) -> Floats:
    """Return points at a height, `(N, 3) float32` [m].

    Raises:
        ValueError: One is not finite.
    """
    rows = np.array([(x, y, z) for x, y in xy], np.float32).reshape(-1, 3)
    if not np.isfinite(rows).all():
        raise ValueError("a position is not finite")
    return rows


def arrows(
    frame: str, poses: NDArray[np.float64], colour: Colour, length: float, z: float, width: float
) -> Arrows:
    """Return poses `(N, 3)` as arrows of a length and width along their headings [m]."""
    segments = np.empty((len(poses), 2, 3), dtype=np.float32)
    segments[:, :, :2], segments[:, :, 2] = poses[:, None, :2], z
    segments[:, 1, 0] += length * np.cos(poses[:, 2])
    segments[:, 1, 1] += length * np.sin(poses[:, 2])
    return Arrows(frame=frame, segments=segments, colour=colour, width=width)


def belief(frame: str, message: Any, colour: Colour) -> Line:
    """Return a PoseWithCovariance's ellipse of two sigmas, and a line to it along the heading.

    Raises:
        ValueError: The pose or its covariance makes no sense.
    """
    pose = se2_from_pose(message.pose)
    covariance = np.asarray(message.covariance, dtype=np.float64).reshape(6, 6)[:2, :2]
    if not np.isfinite(covariance).all():
        raise ValueError("its covariance is not finite")
    variances, axes = np.linalg.eigh((covariance + covariance.T) / 2.0)
    half = 2.0 * np.sqrt(np.maximum(variances, 1e-6))
    ahead = axes.T @ (math.cos(pose.theta), math.sin(pose.theta)) / half
    angles = math.atan2(ahead[1], ahead[0]) + np.linspace(0.0, 2.0 * math.pi, 49)
    ring = axes @ (half[:, None] * np.stack([np.cos(angles), np.sin(angles)]))
    outline = np.vstack([(0.0, 0.0), ring.T]) + np.array((pose.x, pose.y))
    return Line(frame=frame, points=flat_points(outline, 0.04), colour=colour)


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
