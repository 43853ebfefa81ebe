"""pointcloud_to_laserscan, depthimage_to_laserscan and laserscan_to_pointcloud."""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass
from typing import Any

import numpy as np
from sensor_msgs.msg import CameraInfo, Image, LaserScan, PointCloud2

from arjuna_core.config import angle_param, duration_param, fixed, length_param, param
from arjuna_core.ros import qos
from arjuna_core.ros.convert import cloud_from_msg, cloud_msg, scan_from_msg, seconds
from arjuna_core.ros.node import ManagedNode
from arjuna_sim.nodes.mounted_frames import MountedFrames
from arjuna_sim.processing.to_scan import scan_of_depth, scan_of_points


@dataclass(frozen=True)
class CloudToScanConfig:
    """Parameters of `pointcloud_to_laserscan`."""

    target_frame: str = fixed("", "Frame of the scan; empty for the cloud's.")
    transform_tolerance: float = duration_param(
        0.01, "How long a transform may come later; the newest is taken."
    )
    queue_size: int = fixed(4, "Clouds that may wait.", minimum=1, maximum=1000)
    min_height: float = param(
        sys.float_info.min,
        "Least height of a point.",
        unit="m",
        minimum=-math.inf,
        maximum=math.inf,
    )
    max_height: float = param(
        sys.float_info.max,
        "Greatest height of a point.",
        unit="m",
        minimum=-math.inf,
        maximum=math.inf,
    )
    angle_min: float = param(-math.pi, "Bearing of the first beam.", unit="rad")
    angle_max: float = param(math.pi, "Bearing at which the scan ends.", unit="rad")
    angle_increment: float = angle_param(
        math.pi / 180.0, "From one beam to the next.", minimum=1e-5
    )
    scan_time: float = duration_param(1.0 / 30.0, "Time of a scan, in the message.")
    range_min: float = length_param(0.0, "Least distance of a point.")
    range_max: float = length_param(
        sys.float_info.max, "Greatest distance of a point.", maximum=math.inf
    )
    use_inf: bool = param(True, "Whether beams without a point are infinite.")
    inf_epsilon: float = length_param(1.0, "Else, how far beyond the greatest distance they are.")


class PointcloudToLaserscanNode(ManagedNode):
    """Publishes the nearest points of `cloud_in`, between two heights, on `scan`."""

    Config = CloudToScanConfig
    DEFAULT_NAME = "pointcloud_to_laserscan"

    def configure(self) -> None:
        """Create the topics."""
        self._frames = MountedFrames(self)
        self._out = self.publisher(LaserScan, "scan", qos.SENSOR_PUBLISHER)
        self.subscribe(PointCloud2, "cloud_in", self._on_cloud, qos.SENSOR_SUBSCRIPTION)

    def _on_cloud(self, message: Any) -> None:
        config: CloudToScanConfig = self.config
        frame = config.target_frame or message.header.frame_id
        pose = self._frames.mount(frame, message.header.frame_id)
        if pose is None:
            return
        points = cloud_from_msg(message, pose, sys.maxsize).points
        distance = np.hypot(points[:, 0], points[:, 1])
        heights = points[:, 2]
        kept = (heights >= config.min_height) & (heights <= config.max_height)
        kept &= (distance >= config.range_min) & (distance <= config.range_max)
        farthest = min(config.range_max, float(np.finfo(np.float32).max))
        empty = math.inf if config.use_inf else farthest + config.inf_epsilon
        count = math.ceil((config.angle_max - config.angle_min) / config.angle_increment)
        ranges = scan_of_points(
            points[kept], config.angle_min, config.angle_increment, count, empty
        )
        found = LaserScan(
            header=message.header,
            angle_min=config.angle_min,
            angle_max=config.angle_max,
            angle_increment=config.angle_increment,
            scan_time=config.scan_time,
            range_min=config.range_min,
            range_max=farthest,
            ranges=ranges.astype(np.float32),
        )
        found.header.frame_id = frame
        self._out.publish(found)


@dataclass(frozen=True)
class ScanToCloudConfig:
    """Parameters of `laserscan_to_pointcloud`."""

    target_frame: str = fixed("", "Frame of the cloud; empty for the scan's.")
    transform_tolerance: float = duration_param(
        0.01, "How long a transform may come later; the newest is taken."
    )
    queue_size: int = fixed(4, "Scans that may wait.", minimum=1, maximum=1000)


class LaserscanToPointcloudNode(ManagedNode):
    """Publishes the end points of `scan_in` on `cloud`."""

    Config = ScanToCloudConfig
    DEFAULT_NAME = "laserscan_to_pointcloud"

    def configure(self) -> None:
        """Create the topics."""
        self._frames = MountedFrames(self)
        self._out = self.publisher(PointCloud2, "cloud", qos.SENSOR_PUBLISHER)
        self.subscribe(LaserScan, "scan_in", self._on_scan, qos.SENSOR_SUBSCRIPTION)

    def _on_scan(self, message: Any) -> None:
        frame = self.config.target_frame or message.header.frame_id
        pose = self._frames.mount(frame, message.header.frame_id)
        if pose is None:
            return
        points = np.pad(scan_from_msg(message).points(), ((0, 0), (0, 1)))
        placed = pose.apply(points).astype(np.float32)
        self._out.publish(cloud_msg(placed, frame, seconds(message.header.stamp)))


@dataclass(frozen=True)
class DepthToScanConfig:
    """Parameters of `depthimage_to_laserscan`."""

    scan_time: float = duration_param(0.033, "Time of a scan, in the message.")
    range_min: float = length_param(0.45, "Least distance.")
    range_max: float = length_param(10.0, "Greatest distance.")
    scan_height: int = param(1, "Rows of the image that count.", minimum=1, maximum=100000)
    output_frame: str = fixed("camera_depth_frame", "Frame of the scan.")


class DepthimageToLaserscanNode(ManagedNode):
    """Publishes the nearest depths of the middle rows of `depth` on `scan`."""

    Config = DepthToScanConfig
    DEFAULT_NAME = "depthimage_to_laserscan"

    def configure(self) -> None:
        """Create the topics."""
        self._camera: Any = None
        self._out = self.publisher(LaserScan, "scan", qos.SENSOR_PUBLISHER)
        self.subscribe(CameraInfo, "depth_camera_info", self._on_camera, qos.SENSOR_SUBSCRIPTION)
        self.subscribe(Image, "depth", self._on_image, qos.SENSOR_SUBSCRIPTION)

    def _on_camera(self, message: Any) -> None:
        self._camera = message

    def _on_image(self, message: Any) -> None:
        config: DepthToScanConfig = self.config
        if self._camera is None:
            return
        kinds = {"32FC1": ("f4", 1.0), "16UC1": ("u2", 0.001), "mono16": ("u2", 0.001)}
        if message.encoding not in kinds:
            problem = f"depth is {message.encoding!r}; valid: {', '.join(kinds)}"
            self.guard.refused(self, "depth", problem)
            return
        kind, unit = kinds[message.encoding]
        order = ">" if message.is_bigendian else "<"
        shape, strides = (message.height, message.width), (message.step, int(kind[1]))
        raw: Any = np.ndarray(shape, order + kind, message.data, 0, strides)
        depth = raw * unit
        scan_height = min(config.scan_height, message.height)
        ranges, first, increment = scan_of_depth(
            depth, self._camera.k[0], self._camera.k[2], scan_height,
            config.range_min, config.range_max,
        )  # fmt: skip
        found = LaserScan(
            header=message.header,
            angle_min=first,
            angle_max=first + increment * (message.width - 1),
            angle_increment=increment,
            scan_time=config.scan_time,
            range_min=config.range_min,
            range_max=config.range_max,
            ranges=ranges.astype(np.float32),
        )
        found.header.frame_id = config.output_frame
        self._out.publish(found)
