"""Paths: their ends, NavFn's, near goals, tables of poses."""

from __future__ import annotations

import math

import numpy as np
import pytest

from arjuna_core.grid import GridFrame
from arjuna_core.se2 import SE2
from arjuna_nav.costmap import Costmap
from arjuna_nav.planners import NavFn, NavFnConfig, PlanStatus, nearby
from arjuna_nav.planners import path as paths
from arjuna_nav.planners.pose_table import (
    indexed,
    new_table,
    rows_to,
    slot_of,
    with_block,
    with_room,
)
from tests.helpers.nav.navfn_maps import rooms
from tests.helpers.nav.planners import CLASSES, make
from tests.nav.worlds import costmap_of, grid_of, polyline

CORNER = np.array([[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [3.0, 4.0, 1.57], [3.0, 4.5, 1.57]])
LOOP = np.array(
    [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 2.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.1, 0.0]]
)


def test_a_path_is_as_long_as_its_steps_together() -> None:
    assert paths.length(CORNER) == pytest.approx(7.5)
    assert paths.along(CORNER) == pytest.approx([0.0, 3.0, 7.0, 7.5])
    assert paths.length(CORNER[:1]) == 0.0
    assert paths.along(CORNER[:1]) == pytest.approx([0.0])


def test_the_robot_is_at_the_nearest_pose_of_the_part_it_looks_at() -> None:
    beside = SE2(0.3, 0.2)
    assert paths.distances(LOOP, SE2(2.0, 1.0)) == pytest.approx(
        [5**0.5, 1.0, 1.0, 5**0.5, 4.81**0.5]
    )
    assert paths.nearest(LOOP, SE2(0.0, 0.1)) == 4
    assert paths.nearest(LOOP, beside) == 4
    assert paths.nearest(LOOP, beside, within=4.0) == 0
    assert paths.nearest(LOOP, beside, first=1, within=4.0) in (1, 3)
    assert paths.nearest(LOOP, SE2(0.0, 2.1), first=1) == 3


def test_what_is_left_of_a_path_begins_where_the_robot_is() -> None:
    assert paths.remaining(CORNER, SE2(2.9, 0.3)) == pytest.approx(4.5)
    np.testing.assert_array_equal(paths.ahead(CORNER, SE2(2.9, 0.3)), CORNER[1:])


@pytest.mark.parametrize(
    ("path", "pose", "ends"),
    [
        (CORNER, SE2(0.0, 0.0), False),  # 7.5 m for 5.4
        (CORNER[1:], SE2(3.0, 0.0), True),
        (LOOP, SE2(0.0, 0.0), False),
        (LOOP[3:], SE2(0.0, 2.0), True),
        (np.array([[4.0, 6.0, 0.0], [0.0, 3.0, 0.0]]), SE2(4.0, 6.0), True),
        (np.array([[0.0, 0.0, 0.0], [0.0, 2.45, 0.0], [0.0, 2.0, 0.0]]), SE2(), True),  # 0.9 more
        (np.array([[0.0, 0.0, 0.0], [0.0, 2.55, 0.0], [0.0, 2.0, 0.0]]), SE2(), False),  # 1.1
    ],
)
def test_a_path_within_a_metre_of_straight_ends(path: np.ndarray, pose: SE2, ends: bool) -> None:
    assert paths.ends_here(path, pose) is ends


def test_two_paths_are_as_far_apart_as_the_worst_of_them() -> None:
    straight = np.column_stack((np.linspace(0.0, 4.0, 41), np.zeros((41, 2))))
    bulged = straight + [0.0, 1.0, 0.0] * np.exp(-((straight[:, :1] - 2.0) ** 2) * 8.0)
    assert paths.deviation(straight, straight) == 0.0
    assert paths.deviation(bulged, straight) == pytest.approx(1.0, abs=0.02)
    assert paths.deviation(straight, bulged) < 0.7  # beside the bulge there is a way


def test_a_path_is_driven_ahead_and_back_by_its_headings() -> None:
    ahead = polyline([(0.0, 0.0), (1.0, 0.0)], 0.0)
    back = polyline([(1.0, 0.0), (0.5, 0.0)], 0.0)
    back[:, 2] = 0.0
    turned = ahead + np.array([0.0, 0.0, math.pi])
    assert paths.directions(ahead) == [1]
    assert paths.directions(turned) == [-1]
    assert paths.directions(np.vstack((ahead, back[1:]))) == [1, -1]
    assert paths.directions(np.vstack((ahead, turned[::-1]))) == [1], "it turns on the spot"
    assert paths.directions(ahead[:1]) == []


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
    grid = grid_of(8.0, 4.0, (1.0, 0.0, 2.5, 1.7), (1.0, 2.2, 2.5, 1.8), (0.8, 0.0, 0.3, 4.0))
    costmap = costmap_of(grid, radius=0.28)
    start, goal = SE2(1.5, 1.95, 3.14), SE2(6.0, 1.0)
    assert costmap.cost_at(start.x, start.y) == 253
    result = NavFn(NavFnConfig()).plan(costmap, start, goal)
    assert result.status is PlanStatus.SUCCEEDED
    inside = result.path[result.path[:, 0] < 3.4]
    assert np.abs(inside[:, 1] - 1.95).max() < 0.25, "between the walls all the way"
    assert all(costmap.cost_at(x, y) != 254 for x, y in inside[:, :2])
    shallow = NavFn(NavFnConfig(escape_radius=0.5)).plan(costmap, start, goal)
    assert shallow.status is PlanStatus.NO_VALID_PATH, "as Nav2's NavFn, which recoveries may help"


def test_the_nearest_exit_is_not_taken_where_it_leads_nowhere() -> None:
    grid = grid_of(6.0, 3.0, (2.0, 0.0, 0.1, 3.0), (3.0, 0.0, 0.1, 3.0))
    grid.data[28:32, 60:62] = 0  # a hole too narrow for the robot, who stands in it
    costmap = costmap_of(grid)
    start = SE2(2.9, 1.5)
    assert costmap.cost_at(start.x, start.y) == 253
    left = NavFn(NavFnConfig()).plan(costmap, start, SE2(2.55, 1.0))
    right = NavFn(NavFnConfig()).plan(costmap, start, SE2(5.0, 1.0))
    assert left.status is right.status is PlanStatus.SUCCEEDED
    assert left.path[:, 0].max() < 2.95
    assert right.path[:, 0].max() > 4.9


@pytest.mark.parametrize("name", CLASSES)
def test_a_near_goal_has_the_whole_maps_path(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    costmap, planner = rooms(800, 0), make(name)
    rng = np.random.default_rng(1)
    free = np.argwhere(costmap.data[250:550, 250:550] < 100) + 250
    for _ in range(4):
        a, b = free[rng.integers(len(free), size=2)]
        start, goal = (SE2(*costmap.frame.to_point(*cell), 0.3) for cell in (a, b))
        near = planner.plan(costmap, start, goal)
        with monkeypatch.context() as patched:
            patched.setattr(nearby, "_SHARE", 0.0)
            whole = planner.plan(costmap, start, goal)
        assert near.status is whole.status
        if near.status is PlanStatus.SUCCEEDED:
            assert paths.length(near.path) == pytest.approx(paths.length(whole.path), rel=0.02)


@pytest.mark.parametrize("name", CLASSES)
def test_a_near_goal_behind_a_long_wall_is_reached_round_its_end(name: str) -> None:
    data = np.zeros((600, 600), np.uint8)
    data[300:304, :560] = 254
    costmap = Costmap(GridFrame(0.05, 600, 600), data)
    result = make(name).plan(costmap, SE2(10.0, 14.0), SE2(10.0, 16.0))
    assert result.status is PlanStatus.SUCCEEDED
    assert result.path[:, 0].max() > 27.9
    data[300:304] = 254
    assert make(name).plan(costmap, SE2(10.0, 14.0), SE2(10.0, 16.0)).status is not (
        PlanStatus.SUCCEEDED
    )


_HEADINGS = 5


def test_an_index_finds_every_row_again() -> None:
    rng = np.random.default_rng(2)
    index = indexed(61, 40, _HEADINGS)
    known: dict[tuple[int, int, int], int] = {}
    for row in range(3000):
        key = int(rng.integers(61)), int(rng.integers(40)), int(rng.integers(_HEADINGS))
        index = with_block(index, *key[:2])
        slot = slot_of(index, *key)
        assert index.slots[slot] == known.get(key, -1)
        index.slots[slot] = known[key] = row
    for key, row in known.items():
        assert index.slots[slot_of(index, *key)] == row


def test_a_table_keeps_its_rows_when_it_grows() -> None:
    table = new_table(np.array([1.0, 2.0, 3.0]), 2)
    for row in range(1, 50):
        table = with_room(table, row, 1)
        table.poses[row] = row
        table.before[row] = row - 1
    np.testing.assert_array_equal(rows_to(table, 49), np.arange(50))
    np.testing.assert_array_equal(table.poses[0], (1.0, 2.0, 3.0))
    np.testing.assert_array_equal(table.poses[1:50, 0], np.arange(1, 50))
