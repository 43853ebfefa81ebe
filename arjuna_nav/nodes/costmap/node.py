"""A costmap as the lifecycle node that Nav2's clients know."""

from __future__ import annotations

from typing import Any

import numpy as np
from geometry_msgs.msg import Polygon
from nav_msgs.msg import OccupancyGrid as OccupancyGridMsg
from sensor_msgs.msg import LaserScan, PointCloud2, Range

from arjuna_core.errors import ConfigError
from arjuna_core.grid import OccupancyGrid
from arjuna_core.ros import qos
from arjuna_core.ros.convert import grid_from_msg
from arjuna_core.ros.node import ManagedNode
from arjuna_core.ros.scan_queue import BaseFrames, CloudQueue, RangeQueue, ScanQueue
from arjuna_core.ros.tf import TransformError
from arjuna_core.se2 import SE2
from arjuna_nav.costmap import (
    Costmap,
    CostmapConfig,
    LayeredCostmap,
    PlacedCloud,
    PlacedRange,
    PlacedScan,
)
from arjuna_nav.costmap.config import ObstacleConfig
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.nodes.costmap.messages import points_from_polygon
from arjuna_nav.nodes.costmap.output import CostmapOutput
from arjuna_nav.nodes.costmap.services import CostmapServices
from arjuna_nav.nodes.frames import robot_pose

_QUEUE = 50  # as the message filter of nav2_costmap_2d's obstacle layer
_OVERDUE = 3.0  # periods without an update that are too many


class CostmapNode(ManagedNode):
    """Keeps a layered costmap current; the servers of its process read `current`.

    Attributes:
        layered: The costs.
    """

    Config = CostmapConfig
    DEFAULT_NAME = "global_costmap"

    def configure(self) -> None:
        """Create the costmap and its interfaces."""
        config: CostmapConfig = self.config
        self.layered = LayeredCostmap(config)
        self._map: OccupancyGrid | None = None
        self._updated_at = self._scanned_at = self._ranged_at = -np.inf
        self._problem = "it is not active"
        pose = config.global_frame, config.robot_base_frame
        frames = BaseFrames(self, *pose, parameter="robot_base_frame")
        self._scans, self._clouds = ScanQueue(frames, _QUEUE), CloudQueue(frames, _QUEUE)
        self._ranges = RangeQueue(frames, _QUEUE)
        if "static_layer" in config.plugins:
            topic = config.static_layer.map_topic or config.map_topic
            self.subscribe(
                OccupancyGridMsg, _absolute(topic), self._on_map, qos.LATCHED, while_inactive=True
            )
        if "obstacle_layer" in config.plugins:
            self._listen(config.obstacle_layer)
        if "range_layer" in config.plugins:
            for topic in config.range_layer.topics:
                self.subscribe(Range, _absolute(topic), self._ranges.add, qos.SENSOR_SUBSCRIPTION)
        self._output = CostmapOutput(self)
        self.subscribe(Polygon, "footprint", self._on_footprint, qos.DEFAULT)
        CostmapServices(self, self)
        self.every(1.0 / config.update_frequency, self._update)
        if config.publish_frequency > 0.0:
            self.every(
                1.0 / config.publish_frequency,
                lambda: self._output.publish(self.layered, self._updated_at),
            )

    def _listen(self, layer: ObstacleConfig) -> None:
        kinds = {"scan": (LaserScan, self._scans.add), "cloud": (PointCloud2, self._clouds.add)}
        for source in layer.observation_sources.split():
            kind, add = kinds[source]
            topic = _absolute(getattr(layer, source).topic)
            self.subscribe(kind, topic, add, qos.SENSOR_SUBSCRIPTION)

    @property
    def scan_topic(self) -> str:
        """Where its scans come from, absolute; empty where it takes none."""
        layer = self.config.obstacle_layer
        used = "obstacle_layer" in self.config.plugins and "scan" in layer.observation_sources
        return _absolute(layer.scan.topic) if used else ""

    def current(self, timeout: float) -> Costmap | None:
        """Return the costs, or None if they were not updated within a timeout [s]."""
        if not self.active or self.now - self._updated_at > timeout:
            return None
        return self.layered.costmap

    def why_not_current(self) -> str:
        """Say since when the costs were not updated, and why."""
        problem = self._problem if self.active else "it is not active"
        age = self.now - self._updated_at if self.active else np.inf
        since = f"was last updated {age:.2f} s ago" if np.isfinite(age) else "was never updated"
        return f"{self.get_name()} {since}, it is {self.now:.2f} s: {problem}"

    def trouble(self) -> str:
        """Say why the costs are old, where they are."""
        overdue = (
            self.active and self.now - self._updated_at > _OVERDUE / self.config.update_frequency
        )
        return self.why_not_current() if overdue else ""

    def robot_pose(self) -> SE2:
        """Return the robot's pose in the costmap's frame.

        Raises:
            TransformError: It is not known, or older than `transform_tolerance`.
        """
        config = self.config
        return robot_pose(
            self, config.global_frame, config.robot_base_frame, config.transform_tolerance
        )

    def activate(self) -> None:
        """Start from what is seen from now on."""
        self._scans.clear()
        self._clouds.clear()
        self._ranges.clear()
        self._updated_at = -np.inf
        self._output.reset()
        self._scanned_at = self._ranged_at = self.now
        self._problem = "no update was due yet"

    def on_time_jump(self) -> None:
        """Forget what was seen in another run of time."""
        if self.active:
            self.activate()
            self.layered.clear_entirely()

    def on_config(self, config: CostmapConfig) -> None:
        """Build the layers anew by the new parameters; the obstacles seen are forgotten."""
        if hasattr(self, "layered"):
            self.layered = LayeredCostmap(config)
            if self._map is not None:
                self.layered.set_map(self._map)

    def _on_map(self, message: Any) -> None:
        try:
            self._map = grid_from_msg(message)
        except ValueError as error:
            self.get_logger().error(f"map ignored: {error}")
        else:
            self.layered.set_map(self._map)

    def _on_footprint(self, message: Any) -> None:
        try:
            padding = self.config.footprint_padding
            footprint = Footprint.polygon(points_from_polygon(message), padding)
        except ConfigError as error:
            self.get_logger().error(f"footprint ignored: {error}")
        else:
            self.layered.set_footprint(footprint)

    def _update(self) -> None:
        scans = [PlacedScan(scan, T) for scan, T in self._scans.ready()]
        clouds = [PlacedCloud(cloud, T) for cloud, T in self._clouds.ready()]
        ranges = [PlacedRange(reading, T) for reading, T in self._ranges.ready()]
        self._scanned_at = self.now if scans else self._scanned_at
        self._ranged_at = self.now if ranges else self._ranged_at
        if not self.layered.has_map:
            self._problem = "no map has come"
            return
        try:
            self.layered.update(self.robot_pose(), self.now, scans, clouds, ranges)
        except TransformError as error:
            self._problem = str(error)
            return
        silence = self._silence()
        if silence:
            self._problem = silence
            return
        self._updated_at, self._problem = self.now, "no update was due yet"

    def _silence(self) -> str:
        """Say which sensors have been silent for longer than is borne; empty where none has."""
        config, far = self.config, self.config.range_layer
        scan, silent = config.obstacle_layer.scan.expected_update_rate, self.now - self._scanned_at
        if self.scan_topic and config.obstacle_layer.enabled and 0.0 < scan < silent:
            return f"no scan on {self.scan_topic} for {silent:.2f} s"
        silent, used = self.now - self._ranged_at, "range_layer" in config.plugins
        if used and far.enabled and far.topics and 0.0 < far.no_readings_timeout < silent:
            return f"no range on {', '.join(map(_absolute, far.topics))} for {silent:.2f} s"
        return ""


def _absolute(topic: str) -> str:
    """Return a topic outside the costmap's own namespace, as Nav2 resolves it."""
    return topic if topic.startswith("/") else f"/{topic}"
