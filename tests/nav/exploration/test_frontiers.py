"""Frontier exploration of a synthetic room."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from arjuna_core.grid import OccupancyGrid
from arjuna_core.se2 import SE2
from arjuna_nav.costmap import (
    Costmap,
    LayeredCostmap,
    PlacedScan,
)
from arjuna_nav.costmap.collision import collides
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.exploration.frontiers import ExplorationConfig, frontiers, next_goal
from arjuna_nav.planners import NavFn, NavFnConfig, PlanStatus
from tests.helpers.nav.layers import costmap_config, scans, see
from tests.nav.worlds import block, costmap_of, empty_grid, room, scan_from

LONG_SIGHTED = scans(
    {"obstacle_max_range": 12.0, "raytrace_max_range": 12.0}, footprint_clearing_enabled=False
)


class Explorer:
    """Maps a known room from scans and drives to its goals, without error."""

    def __init__(self, truth: OccupancyGrid, start: SE2) -> None:
        self.truth = truth
        self.pose = start
        config = costmap_config(
            track_unknown_space=True,
            plugins=("static_layer", "obstacle_layer"),
            obstacle_layer=LONG_SIGHTED,
        )
        self._seen = LayeredCostmap(config)
        nothing = np.full(truth.frame.shape, -1, np.int8)
        self._seen.set_map(OccupancyGrid(truth.frame, nothing))
        self.look()

    def look(self) -> None:
        scan = scan_from(self.truth, self.pose)
        see(self._seen, self.pose, 0.0, [PlacedScan(scan, self.pose)])

    @property
    def grid(self) -> OccupancyGrid:
        seen = self._seen.costmap.data
        data = np.select([seen == 255, seen == 254], [-1, 100], 0).astype(np.int8)
        return OccupancyGrid(self.truth.frame, data)

    @property
    def costmap(self) -> Costmap:
        return costmap_of(self.grid, radius=0.28, track_unknown=True)

    def drive(self, goal: SE2) -> PlanStatus:
        result = NavFn(NavFnConfig()).plan(self.costmap, self.pose, goal)
        for pose in result.path[::20]:
            self.pose = SE2.from_array(pose)
            self.look()
        if result.status is PlanStatus.SUCCEEDED:
            self.pose = goal
            self.look()
        return result.status


def explored(explorer: Explorer) -> float:
    free = explorer.truth.data == 0
    inside: NDArray[np.bool_] = np.zeros_like(free)
    inside[10:210, 10:210] = free[10:210, 10:210]
    return float((explorer.grid.data[inside] == 0).mean())


@pytest.mark.parametrize("start", [SE2(), SE2(-4.0, 4.0, 1.0), SE2(4.0, 0.5, -2.0)])
def test_explores_the_whole_room_and_ends(start: SE2) -> None:
    explorer, tried = Explorer(room(), start), list[SE2]()
    before = explored(explorer)
    while (goal := next_goal(explorer.grid, explorer.costmap, explorer.pose, tried)) is not None:
        assert len(tried) < 40, "it does not end"
        assert (explorer.costmap.cost_at(goal.x, goal.y) or 0) <= 120
        tried.append(goal)
        assert explorer.drive(goal) is PlanStatus.SUCCEEDED
    assert before < 0.9
    assert explored(explorer) >= 0.98


def test_a_frontier_that_cannot_be_reached_does_not_make_it_loop() -> None:
    grid = empty_grid(4.0, 4.0)
    grid.data[60:, :] = -1
    block(grid, 0.0, 2.0, 4.0, 0.1)  # a wall before the frontier
    tried: list[SE2] = []
    for _ in range(30):
        goal = next_goal(grid, costmap_of(grid, track_unknown=True), SE2(2.0, 1.0), tried)
        if goal is None:
            return
        tried.append(goal)
    pytest.fail("goals without end")


def test_cells_near_a_goal_tried_are_left_out_and_no_others() -> None:
    grid = empty_grid(8.0, 4.0)
    grid.data[:, :2] = -1
    grid.data[:, 150:] = -1
    costmap, tried = costmap_of(grid, track_unknown=True), list[SE2]()
    while (goal := next_goal(grid, costmap, SE2(5.5, 2.0), tried)) is not None and goal.x > 2.0:
        assert all(goal.distance(other) > 0.45 for other in tried)
        tried.append(goal)
    assert goal is not None, "the other frontier was left out too"


def test_nothing_is_left_in_a_known_world() -> None:
    grid = empty_grid(4.0, 4.0)
    assert next_goal(grid, costmap_of(grid), SE2(2.0, 2.0), []) is None


def test_refuses_a_costmap_of_another_frame() -> None:
    layered = LayeredCostmap(costmap_config())
    with pytest.raises(ValueError, match="must be one frame"):
        next_goal(empty_grid(4.0, 4.0), layered.costmap, SE2(), [])


@pytest.mark.parametrize(("hole", "reached"), [(0.3, True), (0.9, False)])
def test_unknown_space_starts_from_the_nearest_known_cell(hole: float, reached: bool) -> None:
    grid = empty_grid(8.0, 4.0)
    grid.data[:, 150:] = -1
    rows, columns = np.ogrid[: grid.frame.height, : grid.frame.width]
    row, column = grid.frame.to_cell(5.5, 2.0)
    grid.data[np.hypot(rows - row, columns - column) * grid.frame.resolution < hole] = -1
    goal = next_goal(grid, costmap_of(grid, track_unknown=True), SE2(5.5, 2.0), [])
    assert (goal is not None) == reached


@pytest.mark.parametrize(("x", "reached"), [(-0.2, True), (-2.0, False), (8.2, False)])
def test_a_robot_off_the_grid_starts_from_the_nearest_free_cell(x: float, reached: bool) -> None:
    grid = half_known()
    goal = next_goal(grid, costmap_of(grid, track_unknown=True), SE2(x, 2.0), [])
    assert (goal is not None) is reached


def half_known(known: float = 4.0) -> OccupancyGrid:
    """Return a hall of 8 x 4 m of which all from a line on is unknown."""
    grid = empty_grid(8.0, 4.0)
    grid.data[:, round(known / 0.05) :] = -1
    return grid


@pytest.mark.parametrize(
    ("walls", "most", "x"),
    [
        ((), 15.0, 16.0),  # nothing is seen: the nearest
        ((2.0,), 15.0, 4.0),  # by a wall first
        ((10.0,), 15.0, 16.0),  # all in the open: by the path
        ((10.0,), 5.0, None),  # open ground may have no end
        ((5.0,), 0.9, None),  # a lidar may see less far than what counts as open
    ],
)
def test_frontiers_in_the_open_come_last(
    walls: tuple[float, ...], most: float, x: float | None
) -> None:
    grid = empty_grid(20.0, 2.0)
    grid.data[:, :80] = grid.data[:, 320:] = -1
    for at in walls:
        block(grid, at, 0.0, 2.0 if at < 4.0 else 0.1, 0.1)
    config = ExplorationConfig(max_open_distance=most)
    costmap = costmap_of(grid, track_unknown=True)
    goal = next_goal(grid, costmap, SE2(14.0, 1.0), [], config)
    assert goal is None if x is None else goal is not None and abs(goal.x - x) <= 1.0


def test_it_looks_at_a_frontiers_middle_from_as_near_as_the_path_allows() -> None:
    grid = half_known()
    costmap = costmap_of(grid, track_unknown=True)
    goal = next_goal(grid, costmap, SE2(1.0, 0.5), [])
    assert goal is not None
    middle = (3.975, 1.975)
    assert np.hypot(goal.x - middle[0], goal.y - middle[1]) <= 1.0
    assert goal.theta == pytest.approx(np.arctan2(middle[1] - goal.y, middle[0] - goal.x), abs=0.05)
    near = next_goal(grid, costmap, SE2(1.0, 2.0), [], ExplorationConfig(view_distance=0.4))
    assert near is not None
    assert np.hypot(near.x - middle[0], near.y - middle[1]) <= 0.41


@pytest.mark.parametrize(("gain", "left"), [(0.0, True), (1.0, True), (4.0, False)])
def test_a_longer_frontier_justifies_a_longer_path(gain: float, left: bool) -> None:
    grid = empty_grid(8.0, 4.0)
    grid.data[20:40, 0] = -1  # a metre, near
    grid.data[10:70, -1] = -1  # three, farther by 3 m
    config = ExplorationConfig(size_gain=gain)
    goal = next_goal(grid, costmap_of(grid, track_unknown=True), SE2(2.5, 1.5), [], config)
    assert goal is not None
    assert (goal.x < 2.5) is left


def test_a_frontier_is_beside_the_unknown_and_long_enough() -> None:
    for count, found in ((5, 0), (6, 1)):
        grid = empty_grid(4.0, 4.0)
        grid.data[:, :40] = 100
        grid.data[10 : 10 + count, 39] = -1
        assert len(frontiers(grid)) == found
    corner = empty_grid(4.0, 4.0)
    corner.data[:42, :42] = 100
    corner.data[40, 40], corner.data[41, 41] = -1, 0  # they touch with a corner alone
    assert frontiers(corner, ExplorationConfig(min_frontier_size=0.0)) == []


@pytest.mark.parametrize(("radius", "here"), [(0.3, True), (1.2, False)])
def test_a_goal_tried_rules_out_what_is_near_it(radius: float, here: bool) -> None:
    grid = half_known()
    costmap = costmap_of(grid, track_unknown=True)
    config = ExplorationConfig(blacklist_radius=radius)
    first = next_goal(grid, costmap, SE2(1.0, 2.0), [], config)
    assert first is not None
    again = next_goal(grid, costmap, SE2(1.0, 2.0), [first], config)
    if here:
        assert again is not None
        assert 0.95 * radius <= again.distance(first)
    else:
        tried = [first, SE2(first.x, 1.0), SE2(first.x, 3.0)]
        assert next_goal(grid, costmap, SE2(1.0, 2.0), tried, config) is None


def test_it_stands_nowhere_above_the_greatest_cost() -> None:
    grid = half_known()
    block(grid, 0.0, 0.0, 4.0, 1.7)
    block(grid, 0.0, 2.3, 4.0, 1.7)  # a corridor in which any cell is costly
    costmap = costmap_of(grid, track_unknown=True)
    dearest = int(costmap.data[40, 70])
    assert dearest > 0
    goals = [
        next_goal(grid, costmap, SE2(1.0, 2.0), [], ExplorationConfig(max_cost=cost))
        for cost in (252, dearest, max(dearest - 40, 0))
    ]
    assert [goal is not None for goal in goals] == [True, True, False]


@pytest.mark.parametrize(("x", "looks"), [(-0.3, True), (-1.0, False)])
def test_a_robot_far_off_the_map_looks_nowhere(x: float, looks: bool) -> None:
    grid = half_known()
    goal = next_goal(grid, costmap_of(grid, track_unknown=True), SE2(x, 2.0), [])
    assert (goal is not None) == looks


@pytest.mark.parametrize(("length", "faces"), [(0.3, True), (1.2, False)])
def test_a_long_robot_looks_from_where_it_has_room(length: float, faces: bool) -> None:
    grid = empty_grid(8.0, 4.0)
    block(grid, 0.0, 0.0, 8.0, 1.6)
    block(grid, 0.0, 2.4, 8.0, 1.6)  # a corridor
    grid.data[: grid.frame.to_cell(0.0, 1.6)[0], 60:68] = -1  # beside it, the unknown
    half = 0.5 * length
    outline = Footprint.polygon(half * np.array([[1, 0.5], [-1, 0.5], [-1, -0.5], [1, -0.5]]))
    costmap = costmap_of(grid, radius=outline.inscribed_radius, track_unknown=True)
    config = ExplorationConfig(view_distance=0.5, max_cost=252)
    goal = next_goal(grid, costmap, SE2(1.0, 2.0), [], config, outline)
    assert goal is not None
    assert not collides(costmap, outline, goal)
    frontier = np.arctan2(1.6 - goal.y, 3.2 - goal.x)
    assert bool(abs(goal.theta - frontier) < 0.3) is faces
