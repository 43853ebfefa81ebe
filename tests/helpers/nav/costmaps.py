"""Costmap nodes beside a box that is seen and not on the map, and what they answer."""

from __future__ import annotations

from typing import Any

import numpy as np
from nav2_msgs.srv import (
    GetCost,
    GetCostmap,
)

from arjuna_core.grid import GridFrame, OccupancyGrid
from arjuna_core.ros.convert import se2_from_pose, seconds
from arjuna_nav.costmap import Costmap
from bringup.stack import GLOBAL_COSTMAP, LOCAL_COSTMAP
from tests.helpers.nav.navigation import PlayedRobot
from tests.nav.worlds import block

GLOBAL, LOCAL = "global_costmap", "local_costmap"
BOX = (1.5, 0.0)  # seen, but not on the map
LETHAL, FREE, UNKNOWN = 254.0, 0.0, 255.0


def costmap_from_msg(message: Any) -> Costmap:
    """Return a nav2_msgs/Costmap as a costmap."""
    metadata = message.metadata
    resolution = round(float(metadata.resolution), 6)  # float32 on the wire
    origin = se2_from_pose(metadata.origin)
    frame = GridFrame(resolution, metadata.size_x, metadata.size_y, origin)
    data = np.asarray(message.data, dtype=np.uint8).reshape(frame.shape)
    return Costmap(frame, data, seconds(message.header.stamp))


def beside_a_box() -> PlayedRobot:
    """Return a robot with both costmaps that sees the box."""
    robot = PlayedRobot()
    before = robot.world.data.copy()
    block(robot.world, 5.5 + BOX[0] - 0.1, 5.4, 0.2, 0.2)
    robot.bring_up(GLOBAL_COSTMAP, LOCAL_COSTMAP)
    robot.send_map(OccupancyGrid(robot.world.frame, before))
    robot.run(1.2)
    return robot


def cost(robot: PlayedRobot, name: str, x: float, y: float, **fields: Any) -> float:
    request = GetCost.Request(x=x, y=y, **fields)
    return float(robot.bench.call(GetCost, f"/{name}/get_cost_{name}", request).cost)


def box_cost(robot: PlayedRobot, name: str) -> float:
    """Return the greatest cost on the box."""
    response = robot.bench.call(GetCostmap, f"/{name}/get_costmap", GetCostmap.Request())
    costmap = costmap_from_msg(response.map)
    row, column = costmap.frame.to_cell(*BOX)
    return float(costmap.data[row - 2 : row + 3, column - 3 : column + 3].max())
