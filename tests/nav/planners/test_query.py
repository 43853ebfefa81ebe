"""Shared by planners on a grid: the path out, the end that is reached, and the answer."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra

from arjuna_core.grid import GridFrame
from arjuna_core.se2 import SE2
from arjuna_nav.costmap import Costmap
from arjuna_nav.planners.base import GridPlannerConfig, PlanResult, PlanStatus
from arjuna_nav.planners.escape import Escape
from arjuna_nav.planners.outline import Drive, path_cost
from arjuna_nav.planners.query import Query, ask, oriented
from arjuna_nav.planners.waves.potential import traversal_costs

ORIGIN = SE2(1.0, -2.0, 0.5)
SIDE, CELL = 12, 0.1
STEPS = [(r, c) for r in (-1, 0, 1) for c in (-1, 0, 1) if (r, c) != (0, 0)]


REACH = GridPlannerConfig(tolerance=0.35, escape_radius=0.5)


def pose_of(row: float, column: float, theta: float = 0.0) -> SE2:
    """Return the pose of a cell's middle."""
    return ORIGIN @ SE2((column + 0.5) * CELL, (row + 0.5) * CELL, theta)


def asked(
    data: np.ndarray, start: SE2, goal: SE2, reach: GridPlannerConfig | None = None
) -> Query | PlanResult:
    return ask(reach or REACH, Costmap(GridFrame(CELL, SIDE, SIDE, ORIGIN), data), start, goal)


def distances_within(data: np.ndarray, start: tuple[int, int], radius: float) -> np.ndarray:
    """Return how far cells are from a start through those where the robot may not be [cells]."""
    shape = data.shape
    ends, lengths = [], []
    for cell in np.ndindex(*shape):
        if 253 <= data[cell] < 255 or cell == start:  # free cells are not gone on from
            for d in STEPS:
                other = cell[0] + d[0], cell[1] + d[1]
                if min(other) >= 0 and max(other) < SIDE and data[other] != 254:
                    ends.append([np.ravel_multi_index(n, shape) for n in (cell, other)])
                    lengths.append(math.hypot(*d))
    graph = coo_matrix((lengths, np.array(ends).T), shape=(data.size, data.size))
    far = dijkstra(graph.tocsr(), indices=np.ravel_multi_index(start, shape))
    return np.where(far > radius, math.inf, far).reshape(shape)


@pytest.mark.parametrize("seed", range(4))
def test_the_exits_are_the_free_cells_that_are_reached_first(seed: int) -> None:
    rng = np.random.default_rng(seed)
    data = rng.choice(np.array([253, 254, 0, 100], np.uint8), (SIDE, SIDE), p=[0.6, 0.2, 0.1, 0.1])
    start, radius = [(4, 5), (1, 1), (10, 9), (11, 0)][seed % 4], 4.0
    data[start] = 253 + seed // 4
    out = Escape(data, traversal_costs(True), start, radius)
    far = np.where(data < 253, distances_within(data, start, radius), math.inf)
    assert {tuple(cell) for cell in out.exits.tolist()} == set(
        zip(*np.nonzero(far < 99), strict=True)
    )
    assert out.distances.tolist() == sorted(out.distances.tolist())
    assert out.nearest == tuple(out.exits[0])
    seeds = out.seeds(2.0)
    for (r, c), distance, row in zip(out.exits.tolist(), out.distances, seeds, strict=True):
        assert distance == pytest.approx(far[r, c])
        assert row == pytest.approx([r, c, 40.0 * distance])
        path = np.vstack((np.array(start, float), out.to((r, c))))
        assert path[-1].tolist() == [r, c]
        steps = np.diff(path, axis=0)
        assert np.abs(steps).max() == 1
        assert np.hypot(*steps.T).sum() == pytest.approx(distance)


def test_from_a_free_cell_there_is_no_path_out() -> None:
    out = Escape(np.zeros((3, 3), np.uint8), traversal_costs(True), (1, 1), 5.0)
    assert out.exits.tolist() == [[1, 1]]
    assert out.to((1, 1)).shape == (0, 2)


def made_query(data: np.ndarray | None = None, reach: GridPlannerConfig | None = None) -> Query:
    free = np.zeros((SIDE, SIDE), np.uint8) if data is None else data
    query = asked(free, pose_of(1, 2, 0.3), pose_of(6, 6, 2.0), reach)
    assert isinstance(query, Query)
    return query


@pytest.mark.parametrize(
    ("reached", "end"),
    [
        ({(6, 6): 9.0, (6, 5): 1.0}, (6, 6)),
        ({(6, 5): 9.0, (5, 5): 1.0}, (6, 5)),  # the nearest
        ({(6, 5): 9.0, (7, 6): 1.0, (6, 7): 2.0}, (7, 6)),  # of equal ones the cheapest
        ({(6, 9): 1.0}, (6, 9)),  # the tolerance's last cell, on each side
        ({(6, 3): 1.0}, (6, 3)),
        ({(3, 6): 1.0}, (3, 6)),
        ({(9, 6): 1.0}, (9, 6)),
        ({(6, 10): 1.0}, None),
        ({(2, 6): 1.0}, None),
        ({(8, 9): 1.0}, None),  # in the window's corner
        ({}, None),
    ],
)
def test_ends_at_the_goal_or_the_nearest_reached_cell_within_the_tolerance(
    reached: dict[tuple[int, int], float], end: tuple[int, int] | None
) -> None:
    values = np.full((SIDE, SIDE), np.inf, np.float32)
    for cell, value in reached.items():
        values[cell] = value
    assert made_query().reachable_end(values) == end


def test_a_goal_at_the_edge_has_a_window_too() -> None:
    query = asked(np.zeros((SIDE, SIDE), np.uint8), pose_of(5, 5), pose_of(1, 0))
    assert isinstance(query, Query)
    values = np.full((SIDE, SIDE), np.inf, np.float32)
    values[0, 2] = values[11, 11] = 1.0
    assert query.reachable_end(values) == (0, 2)


@pytest.mark.parametrize(
    ("cost", "unknown", "status"),
    [
        (252, True, PlanStatus.NO_VALID_PATH),
        (253, True, PlanStatus.GOAL_OCCUPIED),
        (254, True, PlanStatus.GOAL_OCCUPIED),
        (255, True, PlanStatus.NO_VALID_PATH),
        (255, False, PlanStatus.GOAL_OCCUPIED),
    ],
)
def test_names_the_blocked_goal_or_path(cost: int, unknown: bool, status: PlanStatus) -> None:
    data = np.zeros((SIDE, SIDE), np.uint8)
    data[6, 6] = cost
    values = np.full((SIDE, SIDE), np.inf, np.float32)
    values[:2] = 1.0
    failure = made_query(data, replace(REACH, allow_unknown=unknown)).failure(values)
    assert failure.status is status
    goal = f"goal ({pose_of(6, 6).x:.2f}, {pose_of(6, 6).y:.2f})"
    start = f"start ({pose_of(1, 2).x:.2f}, {pose_of(1, 2).y:.2f})"
    assert failure.message == (
        f"{goal} has cost {cost}, nothing reachable within 0.35 m"
        if status is PlanStatus.GOAL_OCCUPIED
        else f"no path from {start} to {goal} or within 0.35 m; 24 cells can be reached"
    )


@pytest.mark.parametrize("end", [(6, 6), (6, 5)])
def test_an_answer_leads_from_the_exact_start_looking_along_the_path(end: tuple[int, int]) -> None:
    cells = [(1, 2), (2, 3), (3, 4), (4, 5), (5, 5), end]
    answer = made_query().answer(np.array(cells, dtype=float))
    assert answer.status is PlanStatus.SUCCEEDED
    middles = [pose_of(*cell) for cell in (cells[0], *cells[1:5], end)]
    expected = np.array([[one.x, one.y] for one in middles])
    assert answer.path[:, :2] == pytest.approx(expected)
    turns = np.diff(expected, axis=0)
    assert answer.path[:-1, 2] == pytest.approx(np.arctan2(turns[:, 1], turns[:, 0]))
    assert answer.path[-1, 2] == pytest.approx(ORIGIN.theta + 2.0)


def test_cells_beside_the_exact_ends_are_left_out() -> None:
    query = asked(np.zeros((SIDE, SIDE), np.uint8), pose_of(1.3, 1.0), pose_of(6.3, 6.0))
    assert isinstance(query, Query)
    answer = query.answer(np.array([(1, 1), (2, 1), (3, 2), (4, 4), (5, 5), (6, 6)], float))
    kept = [
        pose_of(1.3, 1.0),
        *(pose_of(*cell) for cell in ((3, 2), (4, 4), (5, 5))),
        pose_of(6.3, 6.0),
    ]
    assert answer.path[:, :2] == pytest.approx(np.array([[one.x, one.y] for one in kept]))


def test_points_look_at_the_next_and_the_last_as_given() -> None:
    poses = oriented(np.array([[0.0, 0.0], [1.0, 1.0], [1.0, 3.0]]), 0.7)
    assert poses[:, 2] == pytest.approx([math.pi / 4, math.pi / 2, 0.7])


@pytest.mark.parametrize(
    ("path", "cost"),
    [
        ([(0, 0, 0), (1, 0, 0), (3, 0, 0)], 3.0),
        ([(0, 0, 0), (-2, 0, 0)], 8.0),  # backwards it is four times as dear
        ([(0, 0, 0), (0, 0, 1.5), (0, 2, 1.5708)], 0.5 * 1.5 + 0.25 + 2.0 * math.cos(0.0354)),
        ([(0, 0, 0), (1, 0, 0), (0, 0, 0)], 1.0 + 0.25 + 4.0),
    ],
)
def test_a_path_costs_length_and_turns(path: list[tuple[float, float, float]], cost: float) -> None:
    drive = Drive(turn=0.5, reversal=0.25, back=4.0)
    assert path_cost(np.array(path, dtype=float), drive) == pytest.approx(cost, abs=1e-3)
