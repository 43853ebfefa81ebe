"""NavFn on maps that mislead it: cracks, dead ends, and exits that lead nowhere."""

from __future__ import annotations

import numpy as np
import pytest

from arjuna_core.grid import GridFrame
from arjuna_core.se2 import SE2
from arjuna_nav.costmap import Costmap
from arjuna_nav.planners import NavFn, NavFnConfig, PlanStatus
from arjuna_nav.planners import path as paths
from tests.nav.worlds import block, costmap_of, empty_grid


def with_a_crack(width: int) -> Costmap:
    """Return a wall across a map with a crack near the direct path and a wide door far off."""
    data = np.zeros((400, 400), np.uint8)
    data[:, 190:210] = 254
    for column in range(190, 210):  # slanted: no coarse cell of it is closed throughout
        row = 200 + (column - 190) // 2
        data[row : row + width, column] = 0
    data[20:40, 190:210] = 0
    return Costmap(GridFrame(0.05, 400, 400), data)


@pytest.mark.parametrize("use_astar", [False, True])
def test_a_door_that_the_estimate_takes_for_open_is_not_the_end(use_astar: bool) -> None:
    planner = NavFn(NavFnConfig(use_astar=use_astar))
    ends = SE2(5.0, 10.2), SE2(15.0, 10.2)
    open_ = planner.plan(with_a_crack(3), *ends)
    assert open_.status is PlanStatus.SUCCEEDED
    assert paths.length(open_.path) < 12.0
    costmap = with_a_crack(3)
    costmap.data[200:215, 200] = 254  # one cell thick
    closed = planner.plan(costmap, *ends)
    assert closed.status is PlanStatus.SUCCEEDED
    assert closed.path[:, 1].min() < 2.0, "it goes by the far door"


def test_a_dead_end_as_wide_as_the_robot_is_left_by_its_mouth() -> None:
    grid = empty_grid(8.0, 4.0)
    block(grid, 1.0, 0.0, 2.5, 1.7)
    block(grid, 1.0, 2.2, 2.5, 1.8)
    block(grid, 0.8, 0.0, 0.3, 4.0)
    costmap = costmap_of(grid, radius=0.28)
    start, goal = SE2(1.5, 1.95, 3.14), SE2(6.0, 1.0)
    assert costmap.cost_at(start.x, start.y) == 253
    result = NavFn(NavFnConfig()).plan(costmap, start, goal)
    assert result.status is PlanStatus.SUCCEEDED
    inside = result.path[result.path[:, 0] < 3.4]
    assert np.abs(inside[:, 1] - 1.95).max() < 0.25, "between the walls all the way"
    assert all(costmap.cost_at(x, y) != 254 for x, y in inside[:, :2])
    shallow = NavFn(NavFnConfig(escape_radius=0.5)).plan(costmap, start, goal)
    assert shallow.status is PlanStatus.START_OCCUPIED


def test_the_nearest_exit_is_not_taken_where_it_leads_nowhere() -> None:
    grid = empty_grid(6.0, 3.0)
    block(grid, 2.0, 0.0, 0.1, 3.0)
    block(grid, 3.0, 0.0, 0.1, 3.0)
    grid.data[28:32, 60:62] = 0  # a hole too narrow for the robot, who stands in it
    costmap = costmap_of(grid)
    start = SE2(2.9, 1.5)
    assert costmap.cost_at(start.x, start.y) == 253
    left = NavFn(NavFnConfig()).plan(costmap, start, SE2(2.55, 1.0))
    right = NavFn(NavFnConfig()).plan(costmap, start, SE2(5.0, 1.0))
    assert left.status is right.status is PlanStatus.SUCCEEDED
    assert left.path[:, 0].max() < 2.95
    assert right.path[:, 0].max() > 4.9
