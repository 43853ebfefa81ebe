"""Inputs of a costmap's layers, with the robot's pose at each message's stamp."""

from __future__ import annotations

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
from arjuna_core.ros.convert import cloud_from_msg, grid_from_msg
from arjuna_core.ros.node import ManagedNode
from arjuna_core.ros.scan_queue import BaseFrames, PosedQueue, RangeQueue, ScanQueue
from arjuna_core.se2 import SE2
from arjuna_nav.costmap import LayeredCostmap, PlacedCloud, PlacedRange, PlacedScan
from arjuna_nav.costmap.layers.base import Input, absolute
from arjuna_nav.costmap.layers.filters import FilterInfo
from arjuna_nav.costmap.layers.static import MapUpdate, PlacedMap


class _Queue(PosedQueue[Any]):
    """Scans, clouds or distances of one source, with where the robot was."""

    def __init__(self, frames: BaseFrames, source: Input) -> None:
        # 50, as the message filter of nav2_costmap_2d's obstacle layer.
        super().__init__(frames, 50)
        self._source = source

    def placed(self) -> list[Any]:
        """Return those whose transforms are known."""
        return [replace(seen, T_global_base=T_fixed_base) for seen, T_fixed_base in self.ready()]

    def _mount(self, frame: str) -> Pose3:
        """Return the pose of a frame from the ground below the robot's base."""
        mount, frames = self._node.transforms.mount, self._frames
        level = Pose3.from_se2(mount(frames.fixed, frames.base).planar())
        return level.inverse() @ mount(frames.fixed, frame)


class _Scans(_Queue, ScanQueue):
    """Scans; those of a sensor that is not level keep its pose."""

    _WHAT = "scans"

    def _read(self, message: Any, frame: str) -> Any:
        scan, mount = ScanQueue._read(self, message, frame), self._mount(frame)
        other = self._source.sensor_frame
        start = self._mount(other).position if other and other != frame else None
        # The cosine of one degree: a lidar that is tilted less is level.
        level = abs(float(mount.rotation()[2, 2])) >= 0.9998
        tilted = None if level and start is None else mount
        return PlacedScan(scan, SE2(), mount.position[2], tilted, start)


class _Clouds(_Queue):
    """Clouds; their heights are those above the ground."""

    _WHAT = "clouds"

    def _read(self, message: Any, frame: str) -> Any:
        cloud = cloud_from_msg(message, self._mount(frame))
        other = self._source.sensor_frame
        if other and other != frame:
            cloud = replace(cloud, sensor=np.array(self._mount(other).position))
        return PlacedCloud(cloud, SE2())


class _Ranges(_Queue, RangeQueue):
    """Distances of sonars and infrared sensors."""

    _WHAT = "ranges"

    def _read(self, message: Any, frame: str) -> Any:
        return PlacedRange(RangeQueue._read(self, message, frame), SE2())


_SENSORS: dict[str, tuple[Any, type[_Queue]]] = {
    "LaserScan": (LaserScan, _Scans),
    "PointCloud2": (PointCloud2, _Clouds),
    "Range": (Range, _Ranges),
}


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
    """Subscribes to what the layers listen to and hands it to them.

    Args:
        node: The node of the costmap; in its `configure`.
        layered: The costmap.

    Raises:
        ConfigError: A layer listens to a type of messages that costmaps do not read.
    """

    def __init__(self, node: ManagedNode, layered: LayeredCostmap) -> None:
        self._node, self._layered = node, layered
        pose = node.config.global_frame, node.config.robot_base_frame
        self._frames = BaseFrames(node, *pose, parameter="robot_base_frame")
        self._queues: dict[tuple[str, str], _Queue] = {}
        self._last: dict[tuple[str, str], PlacedMap | FilterInfo] = {}
        self._subscribed: set[tuple[str, Input]] = set()
        for name in layered.layers:
            self._listen(name)

    def hand_over(self) -> None:
        """Hand over what sensors have seen from poses that are known by now."""
        for key, queue in self._queues.items():
            for seen in queue.placed():
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
        if one.data_type in _SENSORS:
            kind, make = _SENSORS[one.data_type]
            self._queues[key] = make(self._frames, one)
            self._node.subscribe(kind, topic, self._queues[key].add, qos.SENSOR_SUBSCRIPTION)
        elif one.data_type in _OTHERS:
            kind, read = _OTHERS[one.data_type]
            profile = qos.LATCHED if one.latched else qos.DEFAULT
            take = partial(self._on_other, key, read)
            self._node.subscribe(kind, topic, take, profile, while_inactive=True)
        else:
            valid = ", ".join([*_SENSORS, *_OTHERS])
            raise ConfigError(f"layer '{layer}': no data_type '{one.data_type}'; valid: {valid}")

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
