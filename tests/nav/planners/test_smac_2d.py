"""Smac 2D: its paths are the cheapest of the grid, and what bounds and smooths them."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra

from arjuna_core.grid import GridFrame
from arjuna_core.se2 import SE2
from arjuna_nav.costmap import Costmap
from arjuna_nav.planners import Planner, PlanStatus
from tests.helpers.nav.planners import make

SIDE, CELL = 16, 0.1
ORIGIN = SE2(1.0, -2.0, 0.5)
START, GOAL = (2, 3), (13, 12)
Costs = NDArray[np.float64]


def rough(**values: Any) -> Planner:
    """Return a planner that does not smooth."""
    return make("smac 2d", **{"smoother.w_smooth": 0.0, "tolerance": 0.0, **values})


def pose_of(cell: tuple[int, int]) -> SE2:
    return ORIGIN @ SE2((cell[1] + 0.5) * CELL, (cell[0] + 0.5) * CELL)


def made_costmap(seed: int) -> Costmap:
    rng = np.random.default_rng(seed)
    data = rng.choice(np.array([0, 60, 250, 254, 255], np.uint8), (SIDE, SIDE))
    data[rng.random((SIDE, SIDE)) < 0.4] = 0
    data[START] = data[GOAL] = 0
    return Costmap(GridFrame(CELL, SIDE, SIDE, ORIGIN), data)


def costs_of(data: NDArray[np.uint8], weight: float, unknown: bool) -> Costs:
    """Return what a cell's length costs: as its share of the greatest cost, and 1 besides."""
    costs = 1.0 + weight * data / 252.0
    costs[data >= 253] = math.inf
    costs[data == 255] = 1.0 + weight if unknown else math.inf
    return np.asarray(costs)


def cheapest(costs: Costs) -> tuple[Costs, Costs]:
    """Return what it costs from the start to each cell, and from each cell to the goal."""
    ends, lengths = [], []
    for r, c in np.ndindex(SIDE, SIDE):
        for d_r, d_c in ((0, 1), (1, 0), (0, -1), (-1, 0), (1, 1), (1, -1), (-1, 1), (-1, -1)):
            if not (0 <= r + d_r < SIDE and 0 <= c + d_c < SIDE):
                continue
            beside = costs[[r + d_r, r, r + d_r], [c + d_c, c + d_c, c]]
            if np.isfinite(beside).all():  # across a corner only where both sides are free
                ends.append((r * SIDE + c, (r + d_r) * SIDE + c + d_c))
                lengths.append(beside[0] * math.hypot(d_r, d_c))
    graph = coo_matrix((lengths, np.array(ends).T), shape=(SIDE**2, SIDE**2)).tocsr()
    from_start = dijkstra(graph, indices=START[0] * SIDE + START[1])
    to_goal = dijkstra(graph.T.tocsr(), indices=GOAL[0] * SIDE + GOAL[1])
    return from_start.reshape(SIDE, SIDE), to_goal.reshape(SIDE, SIDE)


@pytest.mark.parametrize("unknown", [True, False])
@pytest.mark.parametrize("seed", range(12))
def test_every_cell_of_a_path_lies_on_a_cheapest_one(seed: int, unknown: bool) -> None:
    costmap, weight = made_costmap(seed), 3.0
    planner = rough(cost_travel_multiplier=weight, allow_unknown=unknown)
    result = planner.plan(costmap, pose_of(START), pose_of(GOAL))
    before, after = cheapest(costs_of(costmap.data, weight, unknown))
    if not math.isfinite(before[GOAL]):
        assert result.status is PlanStatus.NO_VALID_PATH
        return
    assert result.status is PlanStatus.SUCCEEDED
    for x, y, _ in result.path:
        cell = costmap.frame.to_cell(x, y)
        assert before[cell] + after[cell] == pytest.approx(before[GOAL], rel=1e-5)
    steps = np.hypot(*np.diff(result.path[:, :2], axis=0).T) / CELL
    assert steps.max() < 2.3, "none is left out but beside the ends"


def test_it_gives_up_after_the_cells_it_may_look_at() -> None:
    free = Costmap(GridFrame(CELL, SIDE, SIDE, ORIGIN), np.zeros((SIDE, SIDE), np.uint8))
    goal = (START[0], START[1] + 4)  # the fifth cell on the way
    for limit, status in (
        (5, PlanStatus.SUCCEEDED),
        (4, PlanStatus.TIMEOUT),
        (0, PlanStatus.SUCCEEDED),
    ):
        result = rough(max_iterations=limit).plan(free, pose_of(START), pose_of(goal))
        assert result.status is status
        timed_out = status is PlanStatus.TIMEOUT
        assert result.message == ("no path within max_iterations = 4 cells" if timed_out else "")


def corner() -> Costmap:
    """Return a costmap round whose block the path has a corner."""
    data = np.zeros((SIDE, SIDE), np.uint8)
    data[4:, :9] = 254
    return Costmap(GridFrame(CELL, SIDE, SIDE, ORIGIN), data)


def smoothing(again: int, wanted: bool = True) -> Planner:
    """Return a planner that smooths once, and again if that is wanted."""
    values: dict[str, Any] = {"refinement_num": again, "do_refinement": wanted}
    return make("smac 2d", smoother=values)


def bends(path: NDArray[np.float64]) -> float:
    """Return the sum of the squared second differences of a path [m^2]."""
    return float(np.square(np.diff(path[:, :2], 2, axis=0)).sum())


def test_each_refinement_smooths_more_and_none_touches_anything() -> None:
    start, goal = pose_of((1, 1)), pose_of((14, 14))
    rougher = bends(rough().plan(corner(), start, goal).path)
    for again in (0, 1, 2):
        path = smoothing(again).plan(corner(), start, goal).path
        assert bends(path) < 0.95 * rougher
        rougher = bends(path)
        dense = np.vstack([path[:-1] + k / 8 * np.diff(path, axis=0) for k in range(8)])
        cells = corner().frame.to_cells(dense[:, :2])
        assert (corner().data[tuple(cells.T)] == 0).all()
        assert path[0, :2] == pytest.approx([start.x, start.y])
        assert path[-1] == pytest.approx(goal.array())
    once, unasked = (smoothing(n, wanted) for n, wanted in ((0, True), (5, False)))
    np.testing.assert_array_equal(
        unasked.plan(corner(), start, goal).path, once.plan(corner(), start, goal).path
    )
