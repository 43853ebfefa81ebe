"""Places all over a map where a scan fits: which are kept apart, and that none better is missed."""

from __future__ import annotations

import math

import numpy as np
import pytest

from arjuna_core.grid import FREE, OCCUPIED, UNKNOWN, GridFrame, OccupancyGrid
from arjuna_core.se2 import SE2
from arjuna_slam.matching.global_search import GlobalSearch, distinct
from arjuna_slam.matching.map_field import MapField

DEGREE = math.radians(1.0)


@pytest.mark.parametrize(
    ("gap", "turn", "count"),
    [
        (0.39, 19.0, 1),
        (0.41, 0.0, 2),
        (0.0, 19.9, 1),
        (0.0, 20.1, 2),
        (0.0, -20.1, 2),
        (0.0, 341.0, 1),  # 19 degrees the other way round
        (0.41, 21.0, 2),
    ],
)
def test_poses_apart_in_place_or_heading_are_two(gap: float, turn: float, count: int) -> None:
    way = gap * math.cos(0.7), gap * math.sin(0.7), turn * DEGREE
    poses = np.array([[1.0, 2.0, 3.0], np.array([1.0, 2.0, 3.0]) + way])
    scores = np.array([0.5, 0.9])
    assert distinct(poses, scores, 5).tolist() == [1, 0][:count]
    assert distinct(poses, scores, 1).tolist() == [1]
    assert scores.tolist() == [0.5, 0.9]  # its caller's
    assert len(distinct(poses[:0], scores[:0], 5)) == 0


def test_the_best_are_taken_first_and_what_is_like_them_left_out() -> None:
    rng = np.random.default_rng(2)
    poses = rng.uniform((0, 0, -3), (2, 2, 3), (200, 3))
    scores = rng.random(200)
    expected: list[int] = []
    for k in np.argsort(-scores).tolist():
        off = [(poses[k] - poses[other]) for other in expected]
        alike = (
            math.hypot(x, y) < 0.4 and abs(math.remainder(turn, 2 * math.pi)) < 20.0 * DEGREE
            for x, y, turn in off
        )
        if not any(alike):
            expected.append(k)
    assert distinct(poses, scores, 300).tolist() == expected
    assert distinct(poses, scores, 7).tolist() == expected[:7]


def rooms(origin: SE2) -> OccupancyGrid:
    """Return a map of 12 by 8 m with a wall through it, a post, and a corner nobody has seen."""
    data = np.full((160, 240), FREE, np.int8)
    data[[0, -1], :] = data[:, [0, -1]] = OCCUPIED
    data[:100, 140] = data[120:128, 40:48] = OCCUPIED
    data[:40, :40] = UNKNOWN
    return OccupancyGrid(GridFrame(0.05, 240, 160, origin), data, 0.0)


@pytest.mark.parametrize("origin", [SE2(), SE2(-3.0, 7.0, 0.8)])
@pytest.mark.parametrize("at", [SE2(3.03, 4.4, 0.3), SE2(9.2, 1.86, -2.0), SE2(10.4, 6.6, 3.1)])
def test_a_place_is_found_all_over_the_map(origin: SE2, at: SE2) -> None:
    grid = rooms(origin)
    truth = origin @ at
    walls = grid.frame.to_points(np.argwhere(grid.data == OCCUPIED))
    seen = truth.inverse().apply(walls)[::4]  # all walls, as if they were glass
    found = GlobalSearch(MapField(grid, 2.0)).find(seen, 8)
    assert 1 <= len(found) <= 8
    x, y, theta = found[0].tolist()
    assert math.hypot(x - truth.x, y - truth.y) < 0.15
    assert abs(math.remainder(theta - truth.theta, 2 * math.pi)) < 3.1 * DEGREE
    cells = grid.frame.to_cells(found[:, :2])
    assert (np.abs(found[:, 2]) <= math.pi).all()
    near = [
        (grid.data[max(r - 2, 0) : r + 3, max(c - 2, 0) : c + 3] == FREE).any()
        for r, c in cells.tolist()
    ]
    assert all(near)  # where a robot can stand
