"""A costmap as the lifecycle node that Nav2's clients know."""

from __future__ import annotations

from typing import Any

import numpy as np
from geometry_msgs.msg import Polygon, PolygonStamped
from nav2_msgs.msg import Costmap as CostmapMsg
from nav2_msgs.srv import (
    ClearCostmapAroundPose,
    ClearCostmapAroundRobot,
    ClearCostmapExceptRegion,
    ClearEntireCostmap,
    GetCost,
    GetCostmap,
)
from nav_msgs.msg import OccupancyGrid as OccupancyGridMsg
from sensor_msgs.msg import LaserScan

from arjuna_core.errors import ConfigError
from arjuna_core.ros import qos
from arjuna_core.ros.convert import grid_from_msg
from arjuna_core.ros.node import ManagedNode
from arjuna_core.ros.scan_queue import ScanQueue
from arjuna_core.ros.tf import TransformError
from arjuna_core.se2 import SE2
from arjuna_nav.collision import collides
from arjuna_nav.costmap import LETHAL, Costmap, CostmapConfig, LayeredCostmap, PlacedScan
from arjuna_nav.footprint import Footprint
from arjuna_nav.nodes.costmap_messages import (
    costmap_grid_msg,
    costmap_raw_msg,
    points_from_polygon,
    polygon_msg,
)
from arjuna_nav.nodes.frames import pose_in

_QUEUE = 50


class CostmapNode(ManagedNode):
    """Keeps a layered costmap current; the servers of its process read `current`."""

    Config = CostmapConfig
    DEFAULT_NAME = "global_costmap"

    def configure(self) -> None:
        """Create the costmap and its interfaces."""
        config: CostmapConfig = self.config
        self.layered = LayeredCostmap(config)
        self._updated_at = -np.inf
        self._scans = ScanQueue(self, config.global_frame, config.robot_base_frame, _QUEUE)
        if "static_layer" in config.plugins:
            topic = config.static_layer.map_topic or config.map_topic
            self.subscribe(
                OccupancyGridMsg, _absolute(topic), self._on_map, qos.LATCHED, while_inactive=True
            )
        if "obstacle_layer" in config.plugins:
            topic = config.obstacle_layer.scan.topic
            self.subscribe(LaserScan, _absolute(topic), self._scans.add, qos.SENSOR_SUBSCRIPTION)
        self._grid_out = self.publisher(OccupancyGridMsg, "costmap", qos.LATCHED)
        self._raw_out = self.publisher(CostmapMsg, "costmap_raw", qos.LATCHED)
        self._footprint_out = self.publisher(PolygonStamped, "published_footprint", qos.DEFAULT)
        self.subscribe(Polygon, "footprint", self._on_footprint, qos.DEFAULT)
        self._serve()
        self.every(1.0 / config.update_frequency, self._update)
        if config.publish_frequency > 0.0:
            self.every(1.0 / config.publish_frequency, self._publish)

    def _serve(self) -> None:
        """Offer Nav2's services, and those that nav2_simple_commander calls by other names."""
        name = self.get_name()
        self.serve(ClearEntireCostmap, f"clear_entirely_{name}", self._on_clear_entirely)
        for alias in (f"clear_except_{name}", "clear_costmap_except_region"):
            self.serve(ClearCostmapExceptRegion, alias, self._on_clear_except)
        for alias in (f"clear_around_{name}", "clear_costmap_around_robot"):
            self.serve(ClearCostmapAroundRobot, alias, self._on_clear_around)
        for alias in (f"clear_around_pose_{name}", "clear_costmap_around_pose"):
            self.serve(ClearCostmapAroundPose, alias, self._on_clear_around_pose)
        self.serve(GetCostmap, "get_costmap", self._on_get_costmap)
        self.serve(GetCost, f"get_cost_{name}", self._on_get_cost)

    def current(self, timeout: float) -> Costmap | None:
        """Return the costs, or None if they were not updated within a timeout [s]."""
        if not self.active or self.now - self._updated_at > timeout:
            return None
        return self.layered.costmap

    def robot_pose(self) -> SE2 | None:
        """Return the robot's pose in the costmap's frame, None where it is not known."""
        return self.transforms.try_lookup(self.config.global_frame, self.config.robot_base_frame)

    def on_time_jump(self) -> None:
        """Forget what was seen in another run of time."""
        if self.active:
            self._scans.clear()
            self.layered.clear_entirely()
            self._updated_at = -np.inf

    def _on_map(self, message: Any) -> None:
        try:
            self.layered.set_map(grid_from_msg(message))
        except ValueError as error:
            self.get_logger().error(f"map ignored: {error}")

    def _on_footprint(self, message: Any) -> None:
        try:
            padding = self.config.footprint_padding
            footprint = Footprint.polygon(points_from_polygon(message), padding)
        except ConfigError as error:
            self.get_logger().error(f"footprint ignored: {error}")
        else:
            self.layered.set_footprint(footprint)

    def _update(self) -> None:
        pose = self.robot_pose()
        scans = [PlacedScan(scan, T) for scan, T in self._scans.ready()]
        if pose is None or not self.layered.has_map:
            return
        self.layered.update(pose, self.now, scans)
        self._updated_at = self.now

    def _publish(self) -> None:
        costmap, frame_id = self.layered.costmap, self.config.global_frame
        if self._grid_out.get_subscription_count() > 0:
            self._grid_out.publish(costmap_grid_msg(costmap, frame_id, self.now))
        if self._raw_out.get_subscription_count() > 0:
            self._raw_out.publish(costmap_raw_msg(costmap, frame_id, self.now))
        pose = self.robot_pose()
        if pose is not None and self._footprint_out.get_subscription_count() > 0:
            corners = self.layered.footprint.at(pose)
            self._footprint_out.publish(polygon_msg(corners, frame_id, self.now))

    def _on_clear_entirely(self, request: Any, response: Any) -> Any:
        self.layered.clear_entirely()
        return response

    def _on_clear_except(self, request: Any, response: Any) -> Any:
        pose = self.robot_pose()
        if pose is not None:
            self.layered.clear_except(pose, request.reset_distance)
        return response

    def _on_clear_around(self, request: Any, response: Any) -> Any:
        pose = self.robot_pose()
        if pose is not None:
            self.layered.clear_around(pose, request.reset_distance)
        return response

    def _on_clear_around_pose(self, request: Any, response: Any) -> Any:
        try:
            pose = pose_in(self, self.config.global_frame, request.pose)
            self.layered.clear_around(pose, request.reset_distance)
        except TransformError as error:
            self.get_logger().error(f"nothing cleared: {error}")
        return response

    def _on_get_costmap(self, request: Any, response: Any) -> Any:
        costmap, frame_id = self.layered.costmap, self.config.global_frame
        response.map = costmap_raw_msg(costmap, frame_id, self.now)
        return response

    def _on_get_cost(self, request: Any, response: Any) -> Any:
        """Answer with the cost at a point, -1 outside the grid as Nav2 has it."""
        costmap, pose = self.layered.costmap, SE2(request.x, request.y, request.theta)
        cost = costmap.cost_at(pose.x, pose.y)
        if cost is not None and request.use_footprint:
            cost = LETHAL if collides(costmap, self.layered.footprint, pose) else cost
        response.cost = -1.0 if cost is None else float(cost)
        return response


def _absolute(topic: str) -> str:
    """Return a topic outside the costmap's own namespace, as Nav2 resolves it."""
    return topic if topic.startswith("/") else f"/{topic}"
