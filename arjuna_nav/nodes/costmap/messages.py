"""Costmaps as messages and back."""

from __future__ import annotations

import array
from typing import Any

import numpy as np
from geometry_msgs.msg import Point32, Polygon, PolygonStamped
from map_msgs.msg import OccupancyGridUpdate
from nav2_msgs.msg import Costmap as CostmapMsg
from nav2_msgs.msg import CostmapMetaData, CostmapUpdate
from nav_msgs.msg import OccupancyGrid as OccupancyGridMsg
from numpy.typing import NDArray

from arjuna_core.grid import OccupancyGrid
from arjuna_core.ros.convert import grid_msg, header, pose_msg, time_msg
from arjuna_nav.costmap import Costmap
from arjuna_nav.costmap.costmap import occupancy_of
from arjuna_nav.costmap.window import Window


def costmap_raw_msg(costmap: Costmap, frame_id: str, now: float) -> CostmapMsg:
    """Return the costs themselves as nav2_msgs/Costmap."""
    metadata = CostmapMetaData(
        update_time=time_msg(costmap.stamp),
        layer="master",
        resolution=costmap.frame.resolution,
        size_x=costmap.frame.width,
        size_y=costmap.frame.height,
        origin=pose_msg(costmap.frame.origin),
    )
    data = array.array("B", costmap.data.tobytes())
    return CostmapMsg(header=header(frame_id, now), metadata=metadata, data=data)


def costmap_grid_msg(costmap: Costmap, frame_id: str, now: float) -> OccupancyGridMsg:
    """Return a costmap as the OccupancyGrid that RViz shows."""
    grid = OccupancyGrid(costmap.frame, occupancy_of(costmap.data), costmap.stamp)
    return grid_msg(grid, frame_id, now)


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


def polygon_msg(points: NDArray[np.float64], frame_id: str, now: float) -> PolygonStamped:
    """Return corners `(N, 2) float64` [m] as a polygon."""
    corners = [Point32(x=float(x), y=float(y)) for x, y in points]
    return PolygonStamped(header=header(frame_id, now), polygon=Polygon(points=corners))


def points_from_polygon(message: Any) -> NDArray[np.float64]:
    """Return a Polygon message's corners, `(N, 2) float64` [m]."""
    return np.array([[p.x, p.y] for p in message.points], dtype=np.float64).reshape(-1, 2)
