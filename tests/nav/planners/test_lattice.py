"""Smac's planners on lattices and on cells."""

from __future__ import annotations

import itertools
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra

from arjuna_core.errors import InputFileError
from arjuna_core.grid import GridFrame
from arjuna_core.se2 import SE2, wrap
from arjuna_nav.costmap import Costmap
from arjuna_nav.costmap.collision import first_collision
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.planners import Planner, PlanStatus
from arjuna_nav.planners.hybrid.lattice import generated, laid_out
from arjuna_nav.planners.hybrid.moves import STEP
from tests.helpers.nav.lattices import written
from tests.helpers.nav.planners import make
from tests.nav.worlds import block, costmap_of, empty_grid, room

LONG = np.array([[0.45, 0.15], [-0.25, 0.15], [-0.25, -0.15], [0.45, -0.15]])


@pytest.mark.parametrize("radius", [1.0, 4.0, 10.0, 23.0])
def test_every_piece_ends_in_the_middle_of_a_cell_at_its_heading(radius: float) -> None:
    lattice = generated(radius)
    for one in lattice.primitives:
        end = one.poses[-1]
        np.testing.assert_allclose(end[:2], np.round(end[:2]), atol=1e-6)
        assert abs(wrap(end[2] - lattice.angles[one.last])) < 1e-9
        assert one.length == 0.0 or one.length >= math.sqrt(2.0) - 1e-9
        steps = np.hypot(*np.diff(one.poses[:, :2], axis=0).T)
        assert max(steps, default=0.0) <= STEP + 1e-6
        assert one.length <= STEP * (len(one.poses) + 1)
        turns = np.abs(wrap(np.diff(one.poses[:, 2])))
        if one.side:
            assert (2.0 * radius * np.sin(turns / 2.0) <= steps + 1e-6).all()


def test_each_heading_has_its_pieces_backwards_too() -> None:
    moves = laid_out(generated(10.0), 3.0, True, (2.0, 1.0, 0.0, 5.0))
    assert abs(wrap(moves.angles[moves.start] - 3.0)) <= math.pi / 12
    assert (np.diff(moves.first) == 8).all()  # 3 ahead, 3 back, 2 on the spot
    for heading in range(16):
        ahead = []
        for k in range(moves.first[heading], moves.first[heading + 1]):
            end = moves.poses[moves.begins[k + 1] - 1]
            turned = wrap(moves.angles[heading] + end[2] - moves.angles[moves.ends[k]])
            assert abs(turned) < 1e-9
            angle = moves.angles[heading]
            ahead.append(round(float(end[0] * math.cos(angle) + end[1] * math.sin(angle)), 6))
        assert np.count_nonzero(np.sign(ahead) == -1) == np.count_nonzero(np.sign(ahead) == 1) == 3


@pytest.mark.parametrize(
    ("start", "goal"),
    [
        (SE2(0.0, 0.0), SE2(4.0, -4.0, 1.5)),
        (SE2(-4.0, -4.0, 2.1), SE2(4.0, 4.0, 3.1)),
        (SE2(0.0, 0.0, 2.0), SE2(-0.8, 0.4, -1.0)),
    ],
)
def test_a_path_touches_nothing_and_is_driven_ahead_or_on_the_spot(start: SE2, goal: SE2) -> None:
    footprint = Footprint.polygon(LONG)
    costmap = costmap_of(room(), footprint=str(LONG.tolist()))
    result = make("smac lattice", footprint).plan(costmap, start, goal)
    assert result.status is PlanStatus.SUCCEEDED, result.message
    path = result.path
    np.testing.assert_allclose(path[0], start.array(), atol=1e-9)
    np.testing.assert_allclose(path[-1], goal.array(), atol=1e-9)
    assert first_collision(costmap, footprint, path) is None
    heading = path[:-1, 2] + 0.5 * wrap(np.diff(path[:, 2]))
    steps = np.diff(path[:, :2], axis=0)
    ahead = steps[:, 0] * np.cos(heading) + steps[:, 1] * np.sin(heading)
    np.testing.assert_allclose(ahead[1:], np.hypot(*steps[1:].T), atol=1e-6)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_the_first_turn_meets_nothing(side: float) -> None:
    footprint, start = Footprint.polygon(LONG), SE2(1.0, 1.5, 0.19 * side)
    grid = empty_grid(4.0, 3.0)
    nose = start @ SE2(0.45, -0.15 * side)
    block(grid, nose.x - 0.04, nose.y - 0.13 if side > 0.0 else nose.y + 0.03, 0.1, 0.1)
    costmap = costmap_of(grid, footprint=str(LONG.tolist()))
    assert first_collision(costmap, footprint, start.array()[None]) is None
    assert first_collision(costmap, footprint, np.array([[*start.array()[:2], 0.0]])) is not None
    path = make("smac lattice", footprint).plan(costmap, start, SE2(3.0, 1.5)).path
    assert len(path)
    for one, after in itertools.pairwise(path):
        ratios = np.linspace(0.0, 1.0, 9)[:, None]
        turn = one + ratios * np.array([*(after - one)[:2], wrap(after[2] - one[2])])
        assert first_collision(costmap, footprint, turn) is None


def test_a_robot_that_can_turn_leaves_a_pocket_ahead() -> None:
    grid = empty_grid(5.0, 3.0)
    for y in (0.8, 2.1):
        block(grid, 2.0, y, 2.5, 0.1)
    block(grid, 4.5, 0.8, 0.1, 1.4)
    result = make("smac lattice").plan(costmap_of(grid), SE2(3.8, 1.5), SE2(1.0, 1.5, math.pi))
    assert result.status is PlanStatus.SUCCEEDED, result.message


def test_the_pieces_of_a_file_are_driven(tmp_path: Path) -> None:
    costmap = costmap_of(empty_grid(4.0, 4.0))
    file = str(written(tmp_path))
    planner = make("smac lattice", lattice_filepath=file, analytic_expansion_max_length=0.5)
    path = planner.plan(costmap, SE2(1.0, 1.0), SE2(3.0, 2.9)).path
    headings = np.unique(np.round(wrap(path[1:20, 2]), 3))
    assert set(headings) <= {-1.571, 0.0, 1.571, 3.142}


@pytest.mark.parametrize(
    ("about", "text"),
    [
        ({"motion_model": "boat"}, "motion_model 'boat'.*valid: diff, omni, ackermann"),
        ({"heading_angles": [0.0]}, "no file of lattice primitives.*angle index"),
        ({"turning_radius": "wide"}, "no file of lattice primitives"),
        ({"turning_radius": 0.0}, "turning_radius 0 m; valid: .*; over 0, below 100 m"),
        ({"turning_radius": 100.0}, "turning_radius 100 m; valid: .*; over 0, below 100 m"),
    ],
)
def test_file_mistakes_are_named(tmp_path: Path, about: dict[str, object], text: str) -> None:
    with pytest.raises(InputFileError, match=text):
        make("smac lattice", lattice_filepath=str(written(tmp_path, **about)))


def test_pieces_cost_their_length_more_where_they_bend_or_go_back_and_spins_their_own() -> None:
    lattice, (back, bent, change, spin) = generated(4.0), (3.0, 1.5, 0.5, 7.0)
    moves = laid_out(lattice, 0.0, True, (back, bent, change, spin))
    moves_seen = []
    for heading in range(16):
        for k in range(moves.first[heading], moves.first[heading + 1]):
            poses = moves.poses[moves.begins[k] : moves.begins[k + 1]]
            end, side = poses[-1], int(moves.sides[k])
            angle = moves.angles[heading]
            ahead = float(end[0] * math.cos(angle) + end[1] * math.sin(angle))
            moves_seen.append((ahead, side, float(moves.costs[k]), float(moves.changes[k])))
    lengths = sorted(one.length for one in lattice.primitives)
    driven = [one for one in moves_seen if one[0] != 0.0]
    paths = [cost / (bent if side else 1.0) for _, side, cost, _ in driven]
    paths = [
        path / (back if ahead < 0.0 else 1.0)
        for path, (ahead, *_) in zip(paths, driven, strict=True)
    ]
    there_and_back = sorted(length for length in lengths if length > 0.0 for _ in range(2))
    assert sorted(paths) == pytest.approx(there_and_back)
    for path, (ahead, _, _, changed) in zip(paths, driven, strict=True):
        assert changed == pytest.approx(change * path * (back if ahead < 0.0 else 1.0))
    assert [one[2:] for one in moves_seen if one[0] == 0.0] == [(spin, 0.0)] * 32


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
@pytest.mark.parametrize("seed", range(5))
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
