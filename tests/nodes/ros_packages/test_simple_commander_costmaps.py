"""Costmaps, lines and outlines of nav2_simple_commander, as its documentation has them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from geometry_msgs.msg import Point32, Polygon, Pose
from nav2_msgs.msg import Costmap, CostmapMetaData
from nav2_simple_commander.costmap_2d import PyCostmap2D
from nav2_simple_commander.footprint_collision_checker import (
    LETHAL_OBSTACLE,
    FootprintCollisionChecker,
)
from nav2_simple_commander.line_iterator import LineIterator
from nav_msgs.msg import OccupancyGrid
from std_msgs.msg import Header

SQUARE = Polygon(points=[Point32(x=x, y=y) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))])


def costmap(**costs: int) -> PyCostmap2D:
    """Return 20 x 10 cells of half a metre from (-2, -1); costs by `x_y`."""
    about = CostmapMetaData(size_x=20, size_y=10, resolution=0.5, origin=Pose())
    about.origin.position.x, about.origin.position.y = -2.0, -1.0
    message = Costmap(header=Header(frame_id="map"), metadata=about, data=bytes(200))
    made = PyCostmap2D(message)
    for name, cost in costs.items():
        x, y = name.removeprefix("at_").split("_")
        made.setCost(int(x), int(y), cost)
    return made


def test_a_costmap_is_read_by_cells_and_by_metres() -> None:
    one = costmap(at_3_2=77)
    assert (one.getSizeInCellsX(), one.getSizeInCellsY()) == (20, 10)
    assert (one.getSizeInMetersX(), one.getSizeInMetersY()) == (10.0, 5.0)
    assert (one.getOriginX(), one.getOriginY(), one.getResolution()) == (-2.0, -1.0, 0.5)
    assert one.getGlobalFrameID() == "map"
    assert one.getCostmapTimestamp().sec == 0
    assert one.getCostXY(3, 2) == one.getCostIdx(one.getIndex(3, 2)) == np.uint8(77)
    assert one.mapToWorld(3, 2) == (-0.25, 0.25)
    grid = OccupancyGrid(data=[-1, 100])
    grid.info.width, grid.info.height = 2, 1
    assert PyCostmap2D(grid).costmap.tolist() == [255, 100]


@pytest.mark.parametrize(
    ("point", "cell"),
    [
        ((-0.3, 0.4), (3, 2)),
        ((7.99, 3.99), (19, 9)),
        ((8.0, 0.0), (None, None)),
        ((-2.1, 0.0), (None, None)),
        ((8.0, -1.2), (None, None)),
    ],
)
def test_points_outside_have_no_cell(point: tuple[float, float], cell: tuple[Any, Any]) -> None:
    assert costmap().worldToMapValidated(*point) == cell
    unchecked = costmap().worldToMap(*point)
    assert unchecked == cell if cell[0] is not None else unchecked[0] not in range(20)


LINES: list[tuple[tuple[float, ...], list[tuple[float, float]]]] = [
    ((0, 0, 2, 1), [(0, 0), (1, 0.5), (2, 1)]),
    ((2, 1, 0, 0), [(2, 1), (1, 0.5), (0, 0)]),
    ((1, 0, 1, -2), [(1, 0), (1, -1), (1, -2)]),
    ((0, 3, 1, 3, 0.4), [(0, 3), (0.4, 3), (0.8, 3), (1, 3)]),
    ((0, 0, 1, 4), [(0, 0), (1, 4)]),
]


@pytest.mark.parametrize(("line", "points"), LINES)
def test_a_line_is_gone_along_step_by_step(
    line: tuple[float, ...], points: list[tuple[float, float]]
) -> None:
    one, seen = LineIterator(*line), []
    while one.isValid():
        seen.append((one.getX(), one.getY()))
        one.advance()
    assert seen == points
    ends = one.getX0(), one.getY0(), one.getX1(), one.getY1()
    assert ends == line[:4]
    assert one.get_line_length() == pytest.approx(np.hypot(*np.subtract(line[2:4], line[:2])))


@pytest.mark.parametrize(
    ("line", "error", "message"),
    [
        ((0, "a", 1, 1), TypeError, "y0 must be a number"),
        ((0, 0, 1, 1, 0), ValueError, "step_size must be a positive number"),
        ((1, 2, 1, 2), ValueError, "Line has zero length"),
    ],
)
def test_what_is_no_line_is_refused(line: Any, error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        LineIterator(*line)


COSTS: list[tuple[dict[str, int], tuple[float, float, float], float]] = [
    ({}, (1.0, 1.0, 0.0), 0.0),
    ({"at_6_2": 100}, (1.0, 1.0, 0.0), 100.0),  # below its edge
    ({"at_6_4": 254}, (1.0, 1.0, 0.0), 0.0),  # its middle is not looked at
    ({"at_6_2": 254, "at_4_3": 255}, (1.0, 1.0, 0.0), 254.0),
    ({"at_4_3": 255}, (1.0, 1.0, 0.0), 255.0),
    ({"at_8_4": 200}, (1.0, 1.0, np.pi / 4), 200.0),  # its corner, turned
    ({}, (-1.5, 1.0, 0.0), LETHAL_OBSTACLE),  # beyond the costmap
]


@pytest.mark.parametrize(("costs", "pose", "cost"), COSTS)
def test_a_footprint_costs_what_its_edges_meet(
    costs: dict[str, int], pose: tuple[float, float, float], cost: float
) -> None:
    checker = FootprintCollisionChecker()
    with pytest.raises(ValueError, match="use setCostmap"):
        checker.footprintCost(SQUARE)
    checker.setCostmap(costmap(**costs))
    assert checker.footprintCostAtPose(*pose, SQUARE) == cost


def test_a_steep_edge_leaves_no_cell_out_and_a_small_one_is_its_cell() -> None:
    checker = FootprintCollisionChecker()
    checker.setCostmap(costmap(at_5_4=254, at_9_9=50))
    assert checker.lineCost(5, 6, 0, 8) == checker.lineCost(6, 5, 8, 0) == LETHAL_OBSTACLE
    assert checker.lineCost(8, 2, 7, 1) == LETHAL_OBSTACLE
    assert checker.lineCost(9, 9, 9, 9) == 50.0
