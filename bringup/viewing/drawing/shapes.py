"""Poses, paths, beliefs and scans as points, lines and arrows."""

from __future__ import annotations

import math
import struct

import numpy as np
from numpy.typing import NDArray

from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2

Floats = NDArray[np.float32]
_CORNERS = 36
_SIGMAS = 2.0
_PARTICLE = np.dtype([("position", "<3f8"), ("quaternion", "<4f8"), ("weight", "<f8")])


def scan_points(scan: Scan) -> Floats:
    """Return where the valid beams of a scan end, `(N, 3) float32` in the sensor's frame [m]."""
    valid = scan.valid
    angles, ranges = scan.angles[valid], scan.ranges[valid]
    x, y = ranges * np.cos(angles), ranges * np.sin(angles)
    return np.stack([x, y, np.zeros_like(x)], axis=1).astype(np.float32)


def polyline(points: NDArray[np.float64], z: float, closed: bool = False) -> Floats:
    """Return points `(N, 2)` [m] as the segments between them, `(N - 1, 2, 3) float32`."""
    flat = np.zeros((len(points), 3), dtype=np.float32)
    flat[:, :2], flat[:, 2] = points[:, :2], z
    ends = np.roll(flat, -1, axis=0)
    return np.stack([flat, ends], axis=1)[: None if closed else -1]


def arrow(pose: SE2, length: float, z: float) -> Floats:
    """Return an arrow at a pose as one segment, `(1, 2, 3) float32` [m]."""
    return arrows(pose.array()[None], length, z)


def arrows(poses: NDArray[np.float64], length: float, z: float) -> Floats:
    """Return poses `(N, 3)` as segments of a length along their heading, `(N, 2, 3) float32`."""
    segments = np.empty((len(poses), 2, 3), dtype=np.float32)
    segments[:, :, :2], segments[:, :, 2] = poses[:, None, :2], z
    segments[:, 1, 0] += length * np.cos(poses[:, 2])
    segments[:, 1, 1] += length * np.sin(poses[:, 2])
    return segments


def ellipse(covariance: NDArray[np.float64], z: float) -> Floats:
    """Return the outline where a position lies with two sigmas, around the origin.

    Args:
        covariance: `(3, 3) float64` of x, y and yaw.
        z: Height to draw it at [m].

    Returns:
        `(36, 2, 3) float32` segments [m].
    """
    values, axes = np.linalg.eigh(covariance[:2, :2])
    angles = np.arange(_CORNERS) * (2.0 * math.pi / _CORNERS)
    circle = np.stack([np.cos(angles), np.sin(angles)])
    outline = axes @ (_SIGMAS * np.sqrt(np.maximum(values, 0.0))[:, None] * circle)
    return polyline(outline.T, z, closed=True)


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
