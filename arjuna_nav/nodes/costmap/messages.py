"""Costmaps as messages and back."""

from __future__ import annotations

import array
from typing import Any

import numpy as np
from geometry_msgs.msg import Point, Point32, Polygon, PolygonStamped, Vector3
from map_msgs.msg import OccupancyGridUpdate
from nav2_msgs.msg import Costmap as CostmapMsg
from nav2_msgs.msg import CostmapMetaData, CostmapUpdate, VoxelGrid
from nav_msgs.msg import OccupancyGrid as OccupancyGridMsg
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker

from arjuna_core.arrays import Floats
from arjuna_core.grid import OccupancyGrid
from arjuna_core.ros.convert import grid_msg, header, pose_msg, time_msg
from arjuna_nav.costmap import Costmap
from arjuna_nav.costmap.costmap import occupancy_of
from arjuna_nav.costmap.layers.voxel import VOXELS_SHOWN, VoxelLayer
from arjuna_nav.costmap.window import Window


def costmap_raw_msg(
    costmap: Costmap, frame_id: str, now: float, layer: str = "master"
) -> CostmapMsg:
    """Return the costs themselves as nav2_msgs/Costmap, of all layers or of one."""
    metadata = CostmapMetaData(
        update_time=time_msg(costmap.stamp),
        layer=layer,
        resolution=costmap.frame.resolution,
        size_x=costmap.frame.width,
        size_y=costmap.frame.height,
        origin=pose_msg(costmap.frame.origin),
    )
    data = array.array("B", costmap.data.tobytes())
    return CostmapMsg(header=header(frame_id, now), metadata=metadata, data=data)


def costmap_grid_msg(
    costmap: Costmap, frame_id: str, now: float, height: float = 0.0
) -> OccupancyGridMsg:
    """Return a costmap as the OccupancyGrid that RViz shows, at a height [m]."""
    grid = OccupancyGrid(costmap.frame, occupancy_of(costmap.data), costmap.stamp)
    message = grid_msg(grid, frame_id, now)
    message.info.origin.position.z = height
    return message


def costmap_raw_update_msg(
    costmap: Costmap, window: Window, frame_id: str, now: float
) -> CostmapUpdate:
    """Return the costs in a window of cells as nav2_msgs/CostmapUpdate."""
    data = costmap.data[window]
    return CostmapUpdate(
        header=header(frame_id, now),
        x=window[1].start,
        y=window[0].start,
        size_x=data.shape[1],
        size_y=data.shape[0],
        data=array.array("B", data.tobytes()),
    )


def costmap_grid_update_msg(
    costmap: Costmap, window: Window, frame_id: str, now: float
) -> OccupancyGridUpdate:
    """Return the costs in a window of cells as map_msgs/OccupancyGridUpdate."""
    data = occupancy_of(costmap.data[window])
    return OccupancyGridUpdate(
        header=header(frame_id, now),
        x=window[1].start,
        y=window[0].start,
        width=data.shape[1],
        height=data.shape[0],
        data=array.array("b", data.tobytes()),
    )


def voxel_grid_msg(layer: VoxelLayer, frame_id: str, now: float) -> VoxelGrid:
    """Return the voxels of a layer."""
    frame, config = layer.master.frame, layer.config
    corner = frame.origin.apply(np.zeros((1, 2)))[0]
    return VoxelGrid(
        header=header(frame_id, now),
        data=array.array("I", layer.columns().tobytes()),
        origin=Point32(x=float(corner[0]), y=float(corner[1]), z=config.origin_z),
        resolutions=Vector3(x=frame.resolution, y=frame.resolution, z=config.z_resolution),
        size_x=frame.width,
        size_y=frame.height,
        size_z=min(config.z_voxels, VOXELS_SHOWN),
    )


def polygon_msg(points: Floats, frame_id: str, now: float) -> PolygonStamped:
    """Return corners `(N, 2) float64` [m] as a polygon."""
    corners = [Point32(x=float(x), y=float(y)) for x, y in points]
    return PolygonStamped(header=header(frame_id, now), polygon=Polygon(points=corners))


def points_marker(points: Floats, frame_id: str, name: str) -> Marker:
    """Return points `(N, 2)` [m] as the Marker that Nav2 shows what a source sees by."""
    return Marker(
        header=header(frame_id, 0.0),
        ns=f"collision_points_{name}",
        type=Marker.POINTS,
        scale=Vector3(x=0.02, y=0.02),
        color=ColorRGBA(r=1.0, a=1.0),
        frame_locked=True,
        points=[Point(x=float(x), y=float(y)) for x, y in points],
    )


def points_from_polygon(message: Any) -> Floats:
    """Return a Polygon message's corners, `(N, 2) float64` [m]."""
    return np.array([[p.x, p.y] for p in message.points], dtype=np.float64).reshape(-1, 2)
