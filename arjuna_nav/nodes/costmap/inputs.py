"""Inputs of a costmap's layers, with the robot's pose at each message's stamp."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from map_msgs.msg import OccupancyGridUpdate
from nav2_msgs.msg import CostmapFilterInfo
from nav_msgs.msg import OccupancyGrid
from sensor_msgs.msg import LaserScan

from arjuna_core.errors import ConfigError
from arjuna_core.ros import qos
from arjuna_core.ros.convert import grid_from_msg
from arjuna_core.ros.node import ManagedNode
from arjuna_core.ros.scan_queue import PosedQueue
from arjuna_core.ros.silence import Silence, subscribe_watched
from arjuna_core.ros.velocity import subscribe_velocity
from arjuna_nav.costmap import LayeredCostmap
from arjuna_nav.costmap.layers.base import Input, absolute
from arjuna_nav.costmap.layers.filters import FilterInfo
from arjuna_nav.costmap.layers.static import MapUpdate, PlacedMap
from arjuna_nav.nodes.costmap.sensors import SENSORS, SensorFrames


def _map_of(message: Any) -> PlacedMap:
    return PlacedMap(grid_from_msg(message), message.header.frame_id.lstrip("/"))


def _part_of(message: Any) -> MapUpdate:
    data = np.asarray(message.data, dtype=np.int8)
    if len(data) != message.width * message.height:
        raise ValueError(f"{len(data)} cells are not {message.width} x {message.height}")
    return MapUpdate(message.y, message.x, data.reshape(message.height, message.width))


def _info_of(message: Any) -> FilterInfo:
    return FilterInfo(message.type, message.filter_mask_topic, message.base, message.multiplier)


_COMMANDS = ("Twist", "TwistStamped")
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
            if kind is LaserScan:
                # Without scans little is seen, and the collision monitor stops; what has a depth
                # camera in its parameters may lack it.
                advice = f"set {layer}.{one.source}.topic, or start with --scan-topic"
                of = Silence(LaserScan, "scan", qos.SENSOR_SUBSCRIPTION, advice)
                subscribe_watched(self._node, topic, of, queue.add)
            else:
                self._node.subscribe(kind, topic, queue.add, qos.SENSOR_SUBSCRIPTION)
        elif one.data_type in _COMMANDS:
            take_command = partial(self._layered.receive, *key)
            subscribe_velocity(self._node, topic, one.data_type == _COMMANDS[1], take_command)
        elif one.data_type in _OTHERS:
            kind, convert = _OTHERS[one.data_type]
            profile = qos.LATCHED if one.latched else qos.DEFAULT
            take = partial(self._on_other, key, convert)
            shared = one.topic.startswith("/")
            self._node.subscribe(kind, topic, take, profile, while_inactive=True, shared=shared)
        else:
            valid = ", ".join([*SENSORS, *_COMMANDS, *_OTHERS])
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
