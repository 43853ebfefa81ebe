"""Messages of sensors as observations from the robot's base, for costmaps and the monitor."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from sensor_msgs.msg import LaserScan, PointCloud2, Range

from arjuna_core.pose3 import Pose3
from arjuna_core.ros.convert import cloud_from_msg, seconds
from arjuna_core.ros.node import ManagedNode
from arjuna_core.ros.scan_queue import BaseFrames, scan_seen_from
from arjuna_core.ros.tf import TransformError
from arjuna_core.scan import RangeReading
from arjuna_core.se2 import IDENTITY, SE2
from arjuna_nav.costmap import PlacedCloud, PlacedRange, PlacedScan

_FLIPPED = Pose3.from_rpy((0.0, 0.0, 0.0), (math.pi, 0.0, 0.0))


class SensorFrames(BaseFrames):
    """The frames in which sensors' messages are read; heights are above the fixed one's ground."""

    def mount(self, frame: str) -> Pose3:
        """Return the pose of a sensor's frame from the ground below the robot's base.

        Raises:
            TransformError: The frames are not connected.
        """
        mount = self.node.transforms.mount
        level = Pose3.from_se2(mount(self.fixed, self.base).planar())
        return level.inverse() @ mount(self.fixed, frame)


class WatchFrames(SensorFrames):
    """Frames of what has to be current at any time; heights are above the robot's base.

    Args:
        fixed: Frame in which what is seen stays put.
        correction: Whether what was seen is moved to where the robot is now.
        tolerance: By how much a transform may be older than what was seen [s].
    """

    def __init__(
        self, node: ManagedNode, fixed: str, base: str, correction: bool, tolerance: float
    ) -> None:
        super().__init__(node, fixed, base, parameter="base_frame_id")
        self._correction, self.tolerance = correction, tolerance

    def mount(self, frame: str) -> Pose3:
        return self.node.transforms.mount(self.base, frame)

    def pose(self, stamp: float) -> SE2:
        """Return `T_fixed_base` at a time [s], or the newest where that is hardly older.

        Raises:
            TransformError: It is not known, or older than the tolerance.
        """
        newest = self.node.transforms.latest_common(self.fixed, self.base)
        if newest and stamp - newest > self.tolerance:
            late = f"{stamp - newest:.2f} s, over transform_tolerance of {self.tolerance:g} s"
            raise TransformError(f"{self.fixed} -> {self.base} is behind what was seen by {late}")
        return super().pose(min(stamp, newest))

    def now(self) -> SE2:
        """Return the newest `T_base_fixed`."""
        return self.node.transforms.lookup(self.base, self.fixed)

    def since(self, stamp: float) -> SE2:
        """Return `T_base_then`, which maps what the base saw at a time [s] to what it sees now."""
        return self.now() @ self.pose(stamp) if self._correction else IDENTITY


def read_scan(frames: SensorFrames, message: Any, T: SE2 = IDENTITY, start: str = "") -> PlacedScan:
    """Return a LaserScan; that of a sensor that is not level keeps its pose.

    Args:
        frames: The frames that it is read in.
        T: `T_fixed_base` at its stamp.
        start: Frame in which its rays start; empty for the message's.

    Raises:
        TransformError: The sensor's frame is not connected to the base's.
    """
    own = message.header.frame_id.lstrip("/")
    scan = scan_seen_from(frames.node.transforms, frames.base, message)
    mount = frames.mount(own)
    if scan.angle_increment != message.angle_increment:  # it was mirrored
        mount = mount @ _FLIPPED
    origin = frames.mount(start).position if start not in ("", own) else None
    _, x, y, _ = mount.quaternion
    # The cosine of one degree: a lidar that is tilted less is level.
    level = origin is None and 1.0 - 2.0 * (x * x + y * y) >= 0.9998
    return PlacedScan(scan, T, mount.position[2], None if level else mount, origin)


def read_cloud(
    frames: SensorFrames, message: Any, T: SE2 = IDENTITY, start: str = "", **options: Any
) -> PlacedCloud:
    """Return a PointCloud2, as `read_scan` does; the options are those of `cloud_from_msg`."""
    own = message.header.frame_id.lstrip("/")
    mount = frames.mount(own)
    cloud = cloud_from_msg(message, mount, **options)
    if start not in ("", own):
        mount = frames.mount(start)
        cloud = replace(cloud, sensor=np.array(mount.position))
    return PlacedCloud(cloud, T, mount)


def read_range(
    frames: SensorFrames, message: Any, T: SE2 = IDENTITY, start: str = ""
) -> PlacedRange:
    """Return a Range, as `read_scan` does."""
    limits = message.field_of_view, message.min_range, message.max_range
    mount = frames.node.transforms.lookup(frames.base, message.header.frame_id.lstrip("/"))
    reading = RangeReading(message.range, *limits, seconds(message.header.stamp), mount)
    return PlacedRange(reading, T)


SENSORS: dict[str, tuple[Any, str, Callable[..., Any]]] = {
    "LaserScan": (LaserScan, "scans", read_scan),
    "PointCloud2": (PointCloud2, "clouds", read_cloud),
    "Range": (Range, "ranges", read_range),
}
"""By the name of a message type: the type, what several are, and what reads one."""
