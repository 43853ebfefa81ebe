"""nav2_simple_commander's costmap, line and footprint, as scripts use them."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from geometry_msgs.msg import Point32, Polygon
from nav2_msgs.msg import Costmap
from nav2_simple_commander.costmap_2d import PyCostmap2D
from nav2_simple_commander.footprint_collision_checker import (
    LETHAL_OBSTACLE,
    FootprintCollisionChecker,
)
from nav2_simple_commander.line_iterator import LineIterator
from nav_msgs.msg import OccupancyGrid

pytestmark = pytest.mark.ros
SQUARE = Polygon(points=[Point32(x=x, y=y) for x, y in ((2, 2), (-2, 2), (-2, -2), (2, -2))])


def costmap() -> PyCostmap2D:
    message = Costmap()
    about = message.metadata
    about.size_x, about.size_y, about.resolution = 20, 10, 0.5
    about.origin.position.x, about.origin.position.y = -1.0, 2.0
    message.header.frame_id, message.data = "map", np.zeros(200, np.uint8).tolist()
    return PyCostmap2D(message)


def test_cells_and_points_of_a_costmap() -> None:
    grid = costmap()
    assert (grid.getSizeInMetersX(), grid.getSizeInCellsY(), grid.getGlobalFrameID()) == (
        *(10.0, 10, "map"),
    )
    assert grid.worldToMapValidated(0.1, 3.9) == (2, 3)
    assert grid.mapToWorld(2, 3) == (0.25, 3.75)
    assert grid.worldToMapValidated(-1.1, 3.0) == grid.worldToMapValidated(0.0, 7.0) == (None, None)
    grid.setCost(2, 3, 90)
    assert [int(grid.getCostXY(*cell)) for cell in ((2, 3), (3, 2))] == [90, 0]
    assert int(grid.getCostIdx(62)) == 90
    message = OccupancyGrid(data=[-1, 100])
    message.info.width, message.info.height = 2, 1
    assert PyCostmap2D(message).costmap.tolist() == [255, 100]


@pytest.mark.parametrize(
    ("ends", "step", "points"),
    [
        ((0, 0, 3, 6), 1.0, [(0, 0), (1, 2), (2, 4), (3, 6)]),
        ((2, 5, 2, 3), 1.5, [(2, 5), (2, 3.5), (2, 3)]),
        ((1, 1, 0, 1), 0.4, [(1, 1), (0.6, 1), (0.2, 1), (0, 1)]),
    ],
)
def test_a_line_has_both_ends(
    ends: tuple[float, float, float, float], step: float, points: list[tuple[float, float]]
) -> None:
    line, seen = LineIterator(*ends, step), list[tuple[float, float]]()
    while line.isValid():
        seen.append((line.getX(), line.getY()))
        line.advance()
    assert seen == points


@pytest.mark.parametrize(
    ("given", "error"),
    [((0, 0, "1", 1), TypeError), ((0, 0, 1, 1, 0), ValueError), ((1, 1, 1, 1), ValueError)],
)
def test_what_is_no_line_is_refused(given: tuple[Any, ...], error: type[Exception]) -> None:
    with pytest.raises(error, match=r"number|zero length"):
        LineIterator(*given)


def test_an_outline_costs_what_its_edges_cross() -> None:
    grid, checker = costmap(), FootprintCollisionChecker()
    with pytest.raises(ValueError, match="setCostmap"):
        checker.footprintCost(SQUARE)
    checker.setCostmap(grid)
    grid.setCost(12, 4, 70)
    assert checker.footprintCostAtPose(3.2, 4.4, 0.0, SQUARE) == 70.0
    assert checker.footprintCostAtPose(3.2, 4.4, math.pi / 4, SQUARE) == LETHAL_OBSTACLE  # outside
    grid.setCost(4, 3, LETHAL_OBSTACLE)
    assert checker.footprintCostAtPose(3.2, 4.4, 0.0, SQUARE) == LETHAL_OBSTACLE
    assert checker.lineCost(2, 2, 3, 3) == 0.0
