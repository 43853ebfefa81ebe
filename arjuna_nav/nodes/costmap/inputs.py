"""Inputs of a costmap's layers, with the robot's pose at each message's stamp."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from map_msgs.msg import OccupancyGridUpdate
from nav2_msgs.msg import CostmapFilterInfo
from nav_msgs.msg import OccupancyGrid
from sensor_msgs.msg import LaserScan, PointCloud2, Range

from arjuna_core.errors import ConfigError
from arjuna_core.pose3 import Pose3
from arjuna_core.ros import qos
from arjuna_core.ros.convert import cloud_from_msg, grid_from_msg, seconds
from arjuna_core.ros.node import ManagedNode
from arjuna_core.ros.scan_queue import BaseFrames, PosedQueue, scan_seen_from
from arjuna_core.ros.silence import Silence, SilenceWatch
from arjuna_core.ros.tf import TransformError
from arjuna_core.scan import RangeReading
from arjuna_core.se2 import IDENTITY, SE2
from arjuna_nav.costmap import LayeredCostmap, PlacedCloud, PlacedRange, PlacedScan
from arjuna_nav.costmap.layers.base import Input, absolute
from arjuna_nav.costmap.layers.filters import FilterInfo
from arjuna_nav.costmap.layers.static import MapUpdate, PlacedMap

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
        self._correction, self._tolerance = correction, tolerance

    def mount(self, frame: str) -> Pose3:
        """Return the pose of a sensor's frame in the base."""
        return self.node.transforms.mount(self.base, frame)

    def pose(self, stamp: float) -> SE2:
        """Return `T_fixed_base` at a time [s], or the newest where that is hardly older.

        Raises:
            TransformError: It is not known, or older than the tolerance.
        """
        newest = self.node.transforms.latest_common(self.fixed, self.base)
        if newest and stamp - newest > self._tolerance:
            late = f"{stamp - newest:.2f} s, over transform_tolerance of {self._tolerance:g} s"
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
    cloud = cloud_from_msg(message, frames.mount(own), **options)
    if start not in ("", own):
        cloud = replace(cloud, sensor=np.array(frames.mount(start).position))
    return PlacedCloud(cloud, T)


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


def _map_of(message: Any) -> PlacedMap:
    return PlacedMap(grid_from_msg(message), message.header.frame_id.lstrip("/"))


def _part_of(message: Any) -> MapUpdate:
    data = np.asarray(message.data, dtype=np.int8)
    if len(data) != message.width * message.height:
        raise ValueError(f"{len(data)} cells are not {message.width} x {message.height}")
    return MapUpdate(message.y, message.x, data.reshape(message.height, message.width))


def _info_of(message: Any) -> FilterInfo:
    return FilterInfo(message.type, message.filter_mask_topic, message.base, message.multiplier)


_OTHERS: dict[str, tuple[Any, Callable[[Any], Any]]] = {
    "OccupancyGrid": (OccupancyGrid, _map_of),
    "OccupancyGridUpdate": (OccupancyGridUpdate, _part_of),
    "CostmapFilterInfo": (CostmapFilterInfo, _info_of),
}


class CostmapInputs:
    """Subscribes, in a node's `configure`, to what its layers listen to and hands it to them.

    Raises:
        ConfigError: A layer listens to a type of messages that costmaps do not read.
    """

    def __init__(self, node: ManagedNode, layered: LayeredCostmap) -> None:
        self._node, self._layered = node, layered
        pose = node.config.global_frame, node.config.robot_base_frame
        self._frames = SensorFrames(node, *pose, parameter="robot_base_frame")
        self._queues: dict[tuple[str, str], PosedQueue[Any]] = {}
        self._last: dict[tuple[str, str], PlacedMap | FilterInfo] = {}
        self._subscribed: set[tuple[str, Input]] = set()
        for name in layered.layers:
            self._listen(name)

    def hand_over(self) -> None:
        """Hand over what sensors have seen from poses that are known by now."""
        for key, queue in self._queues.items():
            for seen in queue.ready():
                self._layered.receive(*key, seen)

    def hand_over_again(self) -> None:
        """Hand over the last maps again: their layers read them by other parameters."""
        for key, value in self._last.items():
            self._layered.receive(*key, value)

    def clear(self) -> None:
        """Forget what waits for its pose."""
        for queue in self._queues.values():
            queue.clear()

    def _listen(self, layer: str) -> None:
        """Subscribe to what a layer listens to, and to what it has come to listen to since."""
        for one in self._layered.layers[layer].inputs():
            if (layer, one) not in self._subscribed:
                self._subscribed.add((layer, one))
                self._subscribe(layer, one)

    def _subscribe(self, layer: str, one: Input) -> None:
        topic, key = absolute(one.topic), (layer, one.source)
        if one.data_type in SENSORS:
            kind, what, read = SENSORS[one.data_type]
            observe = partial(read, self._frames, start=one.sensor_frame)
            # 50, as the message filter of nav2_costmap_2d's obstacle layer.
            queue = self._queues[key] = PosedQueue(self._frames, what, observe, 50)
            profile = qos.SENSOR_SUBSCRIPTION
            take = self._watched(layer, one, topic, queue) if kind is LaserScan else queue.add
            self._node.subscribe(kind, topic, take, profile)
        elif one.data_type in _OTHERS:
            kind, convert = _OTHERS[one.data_type]
            profile = qos.LATCHED if one.latched else qos.DEFAULT
            take = partial(self._on_other, key, convert)
            self._node.subscribe(kind, topic, take, profile, while_inactive=True)
        else:
            valid = ", ".join([*SENSORS, *_OTHERS])
            raise ConfigError(f"layer '{layer}': no data_type '{one.data_type}'; valid: {valid}")

    def _watched(
        self, layer: str, one: Input, topic: str, queue: PosedQueue[Any]
    ) -> Callable[[Any], None]:
        """Return what takes scans, and warns where none comes.

        Without them little is seen, and the collision monitor stops; what has a depth camera in
        its parameters may lack it.
        """
        name = f"{layer}.{one.source}.topic"
        advice = f"set {name}, or start with --scan-topic"
        of = Silence(LaserScan, "scan", qos.SENSOR_SUBSCRIPTION, advice)
        watch = SilenceWatch(self._node, topic, of)

        def take(message: Any) -> None:
            watch.received()
            queue.add(message)

        return take

    def _on_other(self, key: tuple[str, str], read: Callable[[Any], Any], message: Any) -> None:
        """Hand over what needs no pose, and keep it for layers that read it again."""
        try:
            value = read(message)
        except ValueError as error:
            self._node.get_logger().error(f"map ignored: {error}")
            return
        if not isinstance(value, MapUpdate):
            self._last[key] = value
        self._layered.receive(*key, value)
        self._listen(key[0])
