"""Publications of a costmap: whole grids, their changes, and the states of its filters."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from geometry_msgs.msg import PolygonStamped
from map_msgs.msg import OccupancyGridUpdate
from nav2_msgs.msg import Costmap as CostmapMsg
from nav2_msgs.msg import CostmapUpdate, SpeedLimit, VoxelGrid
from nav_msgs.msg import OccupancyGrid
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import Bool
from std_srvs.srv import SetBool

from arjuna_core.grid import GridFrame
from arjuna_core.ros import qos
from arjuna_core.ros.convert import cloud_msg, header
from arjuna_core.ros.node import ManagedNode
from arjuna_nav.costmap import Costmap, LayeredCostmap
from arjuna_nav.costmap.layers.base import SensedLayer, absolute
from arjuna_nav.costmap.layers.filters import BinaryFilter, CostmapFilter, SpeedFilter
from arjuna_nav.costmap.layers.spatio_temporal import SpatioTemporalVoxelLayer
from arjuna_nav.costmap.layers.static import StaticLayer
from arjuna_nav.costmap.layers.voxel import VoxelLayer
from arjuna_nav.nodes.costmap.messages import (
    costmap_grid_msg,
    costmap_grid_update_msg,
    costmap_raw_msg,
    costmap_raw_update_msg,
    polygon_msg,
    voxel_grid_msg,
)


class CostmapOutput:
    """Publishes a costmap's node under Nav2's names, in its `configure`."""

    def __init__(self, node: ManagedNode, layered: LayeredCostmap) -> None:
        self._node, self._layered = node, layered
        self._grid = node.publisher(OccupancyGrid, "costmap", qos.LATCHED)
        self._raw = node.publisher(CostmapMsg, "costmap_raw", qos.LATCHED)
        self._grid_update = node.publisher(OccupancyGridUpdate, "costmap_updates", qos.LATCHED)
        self._raw_update = node.publisher(CostmapUpdate, "costmap_raw_updates", qos.LATCHED)
        self._layers = {
            name: (
                node.publisher(OccupancyGrid, name, qos.LATCHED),
                node.publisher(CostmapMsg, f"{name}_raw", qos.LATCHED),
            )
            for name, layer in layered.layers.items()
            if isinstance(layer, SensedLayer | StaticLayer)
        }
        self._voxels = [one for one in layered.layers.values() if isinstance(one, VoxelLayer)]
        self._ends, self._grids = None, None
        if self._voxels:
            self._ends = node.publisher(PointCloud2, "clearing_endpoints", qos.LATCHED)
        if any(layer.config.publish_voxel_map for layer in self._voxels):
            self._grids = node.publisher(VoxelGrid, "voxel_grid", qos.LATCHED)
        self._fading = {
            name: node.publisher(PointCloud2, "voxel_grid", qos.DEFAULT)
            for name, layer in layered.layers.items()
            if isinstance(layer, SpatioTemporalVoxelLayer) and layer.config.publish_voxel_map
        }
        self._footprint = node.publisher(PolygonStamped, "published_footprint", qos.DEFAULT)
        self._readers = 0
        self._frame: GridFrame | None = None
        self._published_at = -np.inf

    def reset(self) -> None:
        """Publish the whole next."""
        self._published_at, self._frame = -np.inf, None

    def publish(self, updated_at: float) -> None:
        """Publish what was updated since the last time, last at a time [s]."""
        if updated_at <= self._published_at:
            return
        self._published_at = self._node.now
        layered, frame_id, now = self._layered, self._node.config.global_frame, self._node.now
        costmap, changed = layered.costmap, layered.take_changed()
        if self._wants_all(costmap):
            height = self._node.config.map_vis_z
            self._grid.publish(costmap_grid_msg(costmap, frame_id, now, height))
            self._raw.publish(costmap_raw_msg(costmap, frame_id, now))
        if changed is not None:
            self._grid_update.publish(costmap_grid_update_msg(costmap, changed, frame_id, now))
            self._raw_update.publish(costmap_raw_update_msg(costmap, changed, frame_id, now))
        self._publish_layers(frame_id, now)
        pose = self._node.transforms.try_lookup(frame_id, self._node.config.robot_base_frame)
        if pose is not None and self._footprint.get_subscription_count() > 0:
            self._footprint.publish(polygon_msg(layered.footprint.at(pose), frame_id, now))

    def _publish_layers(self, frame_id: str, now: float) -> None:
        """Publish what single layers hold, to those who listen."""
        layered = self._layered
        for name, (grid, raw) in self._layers.items():
            own = layered.layers[name].own_costs()
            if own is None or own.shape != layered.costmap.frame.shape:
                continue
            costmap = Costmap(layered.costmap.frame, own, layered.costmap.stamp)
            if grid.get_subscription_count():
                height = self._node.config.map_vis_z
                grid.publish(costmap_grid_msg(costmap, frame_id, now, height))
            if raw.get_subscription_count():
                raw.publish(costmap_raw_msg(costmap, frame_id, now, name))
        for voxels in (one for one in self._voxels if one.enabled):
            if self._grids is not None and voxels.config.publish_voxel_map:
                self._grids.publish(voxel_grid_msg(voxels, frame_id, now))
            if self._ends is not None and self._ends.get_subscription_count():
                self._ends.publish(cloud_msg(voxels.cleared_to(), frame_id, now))

        for name, publisher in self._fading.items():
            layer: Any = layered.layers[name]
            if publisher.get_subscription_count():
                publisher.publish(cloud_msg(layer.voxels(), frame_id, now))

    def _wants_all(self, costmap: Costmap) -> bool:
        """Return whether the whole is due: always, or for a new frame or a new reader."""
        readers = self._grid.get_subscription_count() + self._raw.get_subscription_count()
        news = costmap.frame != self._frame or readers > self._readers
        self._frame, self._readers = costmap.frame, readers
        return news or bool(self._node.config.always_send_full_costmap)


class FilterOutput:
    """Publishes a costmap's speed limits and states, and serves what switches parts of layers.

    These are `<filter>/toggle_filter`, and `<source>/toggle_enabled` of a spatio-temporal layer.
    """

    def __init__(self, node: ManagedNode, layered: LayeredCostmap) -> None:
        self._node, self._layered = node, layered
        self._publishers: dict[str, Any] = {}
        for name, layer in layered.layers.items():
            if isinstance(layer, SpeedFilter):
                topic = absolute(layer.config.speed_limit_topic)
                self._publishers[name] = node.publisher(SpeedLimit, topic, qos.DEFAULT)
            elif isinstance(layer, BinaryFilter):
                topic = absolute(layer.config.binary_state_topic)
                self._publishers[name] = node.publisher(Bool, topic, qos.DEFAULT)
            if isinstance(layer, CostmapFilter):
                switch = partial(self._on_switch, partial(_enable, layer))
                node.serve(SetBool, f"{name}/toggle_filter", switch)
            elif isinstance(layer, SpatioTemporalVoxelLayer):
                for source in layer.sources:
                    switch = partial(self._on_switch, partial(layer.switch, source))
                    node.serve(SetBool, f"{source}/toggle_enabled", switch)

    def publish(self) -> None:
        """Publish what has changed since the last time."""
        for name, publisher in self._publishers.items():
            layer = self._layered.layers[name]
            if isinstance(layer, SpeedFilter) and (limit := layer.take_change()) is not None:
                stamp = header(self._node.config.global_frame, self._node.now)
                publisher.publish(
                    SpeedLimit(header=stamp, percentage=limit.percentage, speed_limit=limit.limit)
                )
            elif isinstance(layer, BinaryFilter) and (state := layer.take_change()) is not None:
                publisher.publish(Bool(data=state))

    def _on_switch(self, switch: Callable[[bool], None], request: Any, response: Any) -> Any:
        """Switch a filter or a source on or off until its parameters change."""
        switch(request.data)
        self._layered.compose_again()
        response.success, response.message = True, "Enabled" if request.data else "Disabled"
        return response


def _enable(layer: CostmapFilter, enabled: bool) -> None:
    layer.config = replace(layer.config, enabled=enabled)
