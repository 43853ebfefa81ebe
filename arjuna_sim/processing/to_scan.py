"""Clouds and depth images as planar scans.

Source: pointcloud_to_laserscan, `PointCloudToLaserScanNode`; depthimage_to_laserscan,
`DepthImageToLaserScan::convert`.
"""

from __future__ import annotations

import math

import numpy as np

from arjuna_core.arrays import Floats


def scan_of_points(
    points: Floats, angle_min: float, increment: float, count: int, empty: float
) -> Floats:
    """Return the least distance of points in each sector about the z axis, `(count,)` [m].

    Args:
        points: `(N, 3)` [m].
        angle_min: Where the first sector begins [rad].
        increment: The width of a sector [rad].
        empty: The distance where there is no point.
    """
    ranges = np.full(count, empty)
    bearing = np.arctan2(points[:, 1], points[:, 0])
    sector = np.floor((bearing - angle_min) / increment).astype(np.int64)
    within = (sector >= 0) & (sector < count)
    distance = np.hypot(points[:, 0], points[:, 1])
    np.minimum.at(ranges, sector[within], distance[within])
    return ranges


def scan_of_depth(
    depth: Floats, fx: float, cx: float, scan_height: int, range_min: float, range_max: float
) -> tuple[Floats, float, float]:
    """Return the least distance in each column of a depth image, and where its scan begins.

    Args:
        depth: Depths along the optical axis, `(H, W)` [m]; NaN or 0 where none is known.
        fx: Focal length [pixel].
        cx: Column of the optical axis [pixel].
        scan_height: How many rows in the middle count.

    Returns:
        The distances from right to left, `(W,)` [m], NaN where there is none in range; the first
        beam's bearing and the increment [rad].
    """
    height, width = depth.shape
    top = height // 2 - scan_height // 2
    rows = depth[max(0, top) : top + scan_height]
    columns = np.arange(width)
    angles = -np.arctan2((columns - cx) / fx, 1.0)  # forward is x, left is y
    left, right = math.atan2(cx, fx), -math.atan2(width - 1 - cx, fx)
    increment = (left - right) / max(1, width - 1)
    distances = rows * np.hypot(1.0, (columns - cx) / fx)
    known = np.isfinite(distances) & (distances >= range_min) & (distances <= range_max)
    nearest = np.where(known, distances, np.inf).min(axis=0, initial=np.inf)
    beam = np.clip(((angles - right) / increment).round().astype(np.int64), 0, width - 1)
    ranges = np.full(width, np.inf)
    np.minimum.at(ranges, beam, nearest)
    return np.where(np.isinf(ranges), np.nan, ranges), right, increment
