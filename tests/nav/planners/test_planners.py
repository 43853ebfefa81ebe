"""The contract of every planner."""

from __future__ import annotations

import heapq
import math
import re
from collections.abc import Callable
from functools import cache, partial

import numpy as np
import pytest
from numpy.typing import NDArray

from arjuna_core.grid import GridFrame, OccupancyGrid
from arjuna_core.se2 import SE2, wrap
from arjuna_nav.costmap import Costmap
from arjuna_nav.planners import NavFn, Planner, PlanStatus, plan_through
from arjuna_nav.planners import path as paths
from arjuna_nav.planners.theta_star import line_cost
from tests.helpers.nav import planners
from tests.helpers.nav.planners import CLASSES, ON_CELLS
from tests.nav.worlds import block, costmap_of, empty_grid, grid_of, room

ORIGINS = [SE2(-2.0, 1.5), SE2(3.0, -1.0, 0.7)]
MAZES = (0, 1, 2, 3, 29)  # the last is closed


@pytest.fixture(params=CLASSES)
def make(request: pytest.FixtureRequest) -> Callable[..., Planner]:
    return partial(planners.make, request.param)


@pytest.fixture(params=ON_CELLS)
def make_on_cells(request: pytest.FixtureRequest) -> Callable[..., Planner]:
    return partial(planners.make, request.param)


def maze(seed: int, cells: int = 40) -> tuple[NDArray[np.bool_], Costmap]:
    """Return walls with one gap each, every second row of blocks, and their costmap."""
    rng = np.random.default_rng(seed)
    blocked = np.zeros((cells, cells), dtype=np.bool_)
    for row in range(5, cells, 6):
        blocked[row : row + 2] = True
        gap = int(rng.integers(0, cells - 5))
        blocked[row : row + 2, gap : gap + 5] = False
    speckle = rng.random(blocked.shape) < 0.03
    blocked |= speckle
    blocked[:3, :3] = blocked[-3:, -3:] = False
    data = np.where(blocked, 254, 0).astype(np.uint8)
    return blocked, Costmap(GridFrame(0.1, cells, cells), data)


@cache
def shortest(seed: int) -> float:
    """Return the exact 8-connected length in cells without cut corners, inf if there is none."""
    (blocked, _), start, goal = maze(seed), (1, 1), (38, 38)
    best = {start: 0.0}
    queue = [(0.0, start)]
    height, width = blocked.shape
    while queue:
        length, (row, column) = heapq.heappop(queue)
        if (row, column) == goal:
            return length
        if length > best[row, column]:
            continue
        for dr in (-1, 0, 1):
            for dc in (-1, 0, 1):
                r, c = row + dr, column + dc
                if not (0 <= r < height and 0 <= c < width) or blocked[r, c]:
                    continue
                if blocked[row, c] or blocked[r, column]:
                    continue
                other = length + math.hypot(dr, dc)
                if other < best.get((r, c), math.inf):
                    best[r, c] = other
                    heapq.heappush(queue, (other, (r, c)))
    return math.inf


def costs_along(costmap: Costmap, path: NDArray[np.float64]) -> NDArray[np.int64]:
    """Return the costs of all cells that a path crosses, sampled each tenth of a cell."""
    costs = []
    for a, b in zip(path[:-1, :2], path[1:, :2], strict=True):
        count = max(math.ceil(float(np.hypot(*(b - a))) / costmap.frame.resolution * 10.0), 1)
        for k in range(count + 1):
            x, y = a + (b - a) * k / count
            costs.append(costmap.cost_at(float(x), float(y)))
    return np.array(costs)


@pytest.mark.parametrize("seed", MAZES)
def test_maze_paths_are_near_optimal(make_on_cells: Callable[..., Planner], seed: int) -> None:
    _, costmap = maze(seed)
    exact = shortest(seed) * 0.1
    poses = [SE2(*costmap.frame.to_point(*cell)) for cell in ((1, 1), (38, 38))]
    result = make_on_cells(tolerance=0.0).plan(costmap, *poses)
    if math.isinf(exact):
        assert result.status is PlanStatus.NO_VALID_PATH
        return
    assert result.status is PlanStatus.SUCCEEDED
    assert paths.length(result.path) <= 1.10 * exact
    assert costs_along(costmap, result.path).max() < 253


def test_the_mazes_are_mazes() -> None:
    lengths = [shortest(seed) for seed in MAZES]
    assert np.isfinite(lengths).tolist() == [True] * 4 + [False]
    assert np.nanmean([v for v in lengths if math.isfinite(v)]) > 1.3 * math.hypot(37, 37)


@pytest.mark.parametrize("seed", range(40))
def test_a_straight_line_costs_the_mean_of_the_cells_it_touches(seed: int) -> None:
    rng = np.random.default_rng(seed)
    data = rng.integers(0, 9, (7, 8)).astype(np.uint8)
    costs = np.append(rng.random(8), np.inf if seed % 2 else 1.0).astype(np.float32)
    (r0, r1), (c0, c1) = rng.integers(0, 7, 2).tolist(), rng.integers(0, 8, 2).tolist()
    rows, columns = np.indices(data.shape)
    box = (np.minimum(r0, r1) <= rows) & (rows <= np.maximum(r0, r1))
    box &= (np.minimum(c0, c1) <= columns) & (columns <= np.maximum(c0, c1))
    off = 2 * np.abs((r1 - r0) * (columns - c0) - (c1 - c0) * (rows - r0))
    edge = abs(r1 - r0) + abs(c1 - c0)  # there the line touches a corner of the cell alone
    crossed = box & ((off < edge) | (off == 0))
    expected = costs[data[crossed]].mean() * math.hypot(r1 - r0, c1 - c0)
    if np.isinf(costs[data[box & (off == edge)]]).any() or np.isinf(expected):
        expected = math.inf
    assert line_cost(data, costs, r0, c0, r1, c1) == pytest.approx(expected, rel=1e-5)


@pytest.mark.parametrize("origin", ORIGINS)
def test_plans_wherever_the_grid_lies(make: Callable[..., Planner], origin: SE2) -> None:
    start, goal = SE2(1.023, 1.023, 0.2), SE2(3.021, 1.021, -0.5)  # no edge of a cell
    here, there = (costmap_of(walled(at)) for at in (SE2(), origin))
    reference = make().plan(here, start, goal)
    result = make().plan(there, origin @ start, origin @ goal)
    assert result.status is PlanStatus.SUCCEEDED
    assert costs_along(there, result.path).max() < 253
    moved = origin.apply(reference.path[:, :2])
    np.testing.assert_allclose(result.path[:, :2], moved, atol=1e-9)
    np.testing.assert_allclose(result.path[-1], (origin @ goal).array())


def walled(origin: SE2) -> OccupancyGrid:
    """Return a grid whose two halves are joined at the top."""
    return grid_of(4.0, 4.0, (1.9, 0.0, 0.2, 3.0), origin=origin)


def test_poses_look_along_the_path(make_on_cells: Callable[..., Planner]) -> None:
    goal = SE2(3.0, 3.2, 2.0)
    path = make_on_cells().plan(costmap_of(empty_grid(4.0, 4.0)), SE2(1.0, 1.0, 0.0), goal).path
    heading = math.atan2(2.2, 2.0)
    assert np.abs(wrap(path[:-1, 2] - heading)).max() < 0.35
    assert path[-1, 2] == pytest.approx(2.0)
    assert np.hypot(*np.diff(path[:, :2], axis=0).T).max() < 0.11


def test_a_path_ends_in_its_direction_where_asked(make_on_cells: Callable[..., Planner]) -> None:
    plan = make_on_cells(use_final_approach_orientation=True).plan
    goal = SE2(3.0, 3.2, 2.0)
    path = plan(costmap_of(empty_grid(4.0, 4.0)), SE2(1.0, 1.0, 0.0), goal).path
    last = path[-1] - path[-2]
    assert path[-1, 2] == pytest.approx(math.atan2(last[1], last[0]), abs=1e-3)
    assert path[-1, :2].tolist() == [3.0, 3.2]


def test_a_blocked_goal_is_replaced_by_the_nearest_pose(make: Callable[..., Planner]) -> None:
    costmap = costmap_of(room())
    result = make(tolerance=0.8).plan(costmap, SE2(), SE2(2.5, 0.0, 0.3))
    end = SE2.from_array(result.path[-1])
    assert result.status is PlanStatus.SUCCEEDED
    assert 0.5 <= end.distance(SE2(2.5, 0.0)) <= 0.8
    assert (costmap.cost_at(end.x, end.y) or 0) < 253
    assert end.theta == pytest.approx(0.3)


def closed_room() -> Costmap:
    return costmap_of(grid_of(6.0, 4.0, (3.0, 0.0, 0.2, 4.0)))


@pytest.mark.parametrize(
    ("start", "goal", "status", "text"),
    [
        (SE2(1.0, 1.0), SE2(9.0, 1.0), PlanStatus.GOAL_OUTSIDE_MAP, r"which spans x 0.00 to"),
        (SE2(-1.0, 1.0), SE2(1.0, 1.0), PlanStatus.START_OUTSIDE_MAP, r"start \(-1.00, 1.00\)"),
        (SE2(1.0, 1.0), SE2(3.1, 1.0), PlanStatus.GOAL_OCCUPIED, "has cost 254"),
        (SE2(1.0, 1.0), SE2(5.0, 1.0), PlanStatus.NO_VALID_PATH, "cells can be reached"),
        (SE2(3.1, 1.0), SE2(5.0, 1.0), PlanStatus.START_OCCUPIED, "no way out"),
    ],
    ids=["goal outside", "start outside", "goal occupied", "no path", "start occupied"],
)
def test_says_why_there_is_no_path(
    make: Callable[..., Planner], start: SE2, goal: SE2, status: PlanStatus, text: str
) -> None:
    planner = make(tolerance=0.1)
    if isinstance(planner, NavFn) and status is PlanStatus.START_OCCUPIED:
        status = PlanStatus.NO_VALID_PATH  # Nav2's NavFn has no such failure: recoveries are tried
    result = planner.plan(closed_room(), start, goal)
    assert result.status is status
    assert len(result.path) == 0
    assert re.search(text, result.message)


def test_leads_a_robot_out_that_stands_slightly_too_near(make: Callable[..., Planner]) -> None:
    costmap = closed_room()
    start = SE2(2.85, 1.0)
    assert costmap.cost_at(start.x, start.y) == 253
    result = make().plan(costmap, start, SE2(1.0, 1.0))
    assert result.status is PlanStatus.SUCCEEDED
    costs = costs_along(costmap, result.path)
    assert costs.max() == 253
    assert np.count_nonzero(np.diff((costs >= 253).astype(int))) == 1, "it leaves once, for good"


def test_unknown_space_is_crossed_only_where_allowed(make: Callable[..., Planner]) -> None:
    data = np.zeros((40, 60), dtype=np.uint8)
    data[:, 25:35] = 255
    costmap = Costmap(GridFrame(0.1, 60, 40), data)
    ends = SE2(1.0, 2.0), SE2(5.0, 2.0)
    assert make(allow_unknown=True).plan(costmap, *ends).status is PlanStatus.SUCCEEDED
    refused = make(allow_unknown=False).plan(costmap, *ends)
    assert refused.status is PlanStatus.NO_VALID_PATH


def test_prefers_the_middle_of_a_passage(make: Callable[..., Planner]) -> None:
    grid = empty_grid(6.0, 3.0)
    block(grid, 2.0, 0.0, 2.0, 0.8)
    block(grid, 2.0, 2.2, 2.0, 0.8)  # a passage 1.4 m wide about y = 1.5
    path = make().plan(costmap_of(grid), SE2(0.5, 0.7), SE2(5.5, 0.7)).path
    inside = path[(path[:, 0] > 2.6) & (path[:, 0] < 3.4)]
    assert np.abs(inside[:, 1] - 1.5).max() < 0.2


def test_start_and_goal_may_be_one_pose(make: Callable[..., Planner]) -> None:
    costmap = costmap_of(empty_grid(2.0, 2.0))
    result = make().plan(costmap, SE2(1.0, 1.0, 0.0), SE2(1.01, 1.0, 1.0))
    assert result.status is PlanStatus.SUCCEEDED
    assert len(result.path) >= 2
    assert result.path[-1].tolist() == [1.01, 1.0, 1.0]


def test_plans_through_poses_in_order(make: Callable[..., Planner]) -> None:
    costmap = costmap_of(empty_grid(6.0, 6.0))
    goals = [SE2(1.0, 5.0), SE2(5.0, 5.0), SE2(5.0, 1.0, -1.0)]
    result = plan_through(make(), costmap, SE2(1.0, 1.0), goals)
    assert result.status is PlanStatus.SUCCEEDED
    at = [paths.nearest(result.path, goal) for goal in goals]
    assert at == sorted(at)
    assert all(paths.distances(result.path, goal).min() < 1e-9 for goal in goals)
    assert plan_through(make(), costmap, SE2(1.0, 1.0), []).status is PlanStatus.NO_VALID_PATH
