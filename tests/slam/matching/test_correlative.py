"""The correlative search finds what trying every pose of its window finds."""

from __future__ import annotations

import itertools
import math
from collections.abc import Generator

import numpy as np
import pytest
from scipy.spatial import cKDTree

from arjuna_core.arrays import Floats
from arjuna_core.grid import FREE, OCCUPIED, UNKNOWN, GridFrame, OccupancyGrid
from arjuna_core.se2 import SE2
from arjuna_slam.matching.correlative import GlobalSearch, Window, distinct, search, searching
from arjuna_slam.matching.field import Field
from arjuna_slam.matching.map_field import MapField
from arjuna_slam.matching.scan_matcher import score

PRIOR = SE2(0.3, -0.2, 0.4)
Found = tuple[SE2, float] | None


def scene(seed: int) -> tuple[Field, Floats]:
    """Return a field and points that lie in it at a pose near the prior, and clutter."""
    rng = np.random.default_rng(seed)
    points = rng.uniform(-1.5, 1.5, (24, 2))
    truth = PRIOR @ SE2(*rng.uniform(-0.1, 0.1, 3).tolist())
    field = Field(0.05, 0.05)
    field.add(truth.apply(points[:16]), np.zeros((16, 2)))
    return field, points


def responses(
    field: Field, points: Floats, window: Window
) -> dict[tuple[int, int, int], tuple[SE2, float]]:
    """Return each pose of a window and its response, as the definition has it."""
    reach = np.sort(np.hypot(*points.T))[int(0.9 * (len(points) - 1))]
    step = max(0.05 / reach, math.radians(0.25))
    turns, cells = math.ceil(window.theta / step), math.ceil(window.xy / 0.05)
    found = {}
    for k, i, j in itertools.product(
        range(-turns, turns + 1), range(-cells, cells + 1), range(-cells, cells + 1)
    ):
        pose = SE2(PRIOR.x + 0.05 * j, PRIOR.y + 0.05 * i, PRIOR.theta + k * step)
        gap, turn = 0.05 * math.hypot(i, j), k * step
        distance = max(1.0 - 0.2 * gap**2 / window.distance_penalty, window.floor_xy)
        angle = max(1.0 - 0.2 * turn**2 / window.angle_penalty, window.floor_theta)
        mean = float(field.likelihood(pose.apply(points)).mean())
        found[k, i, j] = pose, mean * distance * angle
    return found


WINDOWS = [
    Window(0.07, 0.12, 2),  # no whole number of cells
    Window(0.15, 0.12, 3, distance_penalty=0.05, angle_penalty=0.02),
    Window(0.2, 0.05, 1, distance_penalty=0.01, angle_penalty=0.001, floor_xy=0.9),
]


@pytest.mark.parametrize("window", WINDOWS)
@pytest.mark.parametrize("seed", range(2))
def test_it_finds_the_pose_of_the_greatest_response(window: Window, seed: int) -> None:
    field, points = scene(seed)
    pose, best = max(responses(field, points, window).values(), key=lambda each: each[1])
    found = search(field, points, PRIOR, window, 0.0)
    assert found is not None
    assert found[1] == pytest.approx(best, abs=1e-6)
    assert best <= 1.0
    assert found[0].array() == pytest.approx(pose.array(), abs=1e-9)
    assert score(field, points, PRIOR, found[0], window) == pytest.approx(best, abs=1e-6)
    assert search(field, points, PRIOR, window, best + 1e-6) is None
    assert search(field, points, PRIOR, window, best - 1e-6) is not None


def test_a_turn_counts_by_its_shorter_side() -> None:
    field, points = scene(0)
    window = Window(0.2, 0.1, 2, angle_penalty=0.05)
    pose = SE2(PRIOR.x, PRIOR.y, PRIOR.theta + 0.1)
    around = SE2(PRIOR.x, PRIOR.y, PRIOR.theta + 0.1 - 2.0 * math.pi)
    assert score(field, points, PRIOR, around, window) == pytest.approx(
        score(field, points, PRIOR, pose, window)
    )


def stepwise(steps: Generator[None, None, Found]) -> tuple[Found, int]:
    """Return what a generator returns, and how many steps it took."""
    count = 0
    while True:
        try:
            next(steps)
        except StopIteration as end:
            return end.value, count
        count += 1


@pytest.mark.parametrize("cells", [1, 2, 3])
@pytest.mark.parametrize("seed", range(3))
def test_poses_near_those_left_out_are_not_found(seed: int, cells: int) -> None:
    field, points = scene(seed)
    window, far = Window(0.2, 0.12, 2), 0.05 * cells
    every = responses(field, points, window)
    best = max(every, key=lambda key: every[key][1])
    left_out = every[best][0]
    allowed = {
        key: each
        for key, each in every.items()
        if max(abs(key[1] - best[1]), abs(key[2] - best[2])) > cells
    }
    least = max(each[1] for each in allowed.values()) - 1e-6  # so the best of them must do
    found, _ = stepwise(searching(field, points, PRIOR, window, least, ([left_out], far)))
    assert found is not None
    off = max(abs(found[0].x - left_out.x), abs(found[0].y - left_out.y))
    assert off > far + 1e-9
    assert found[1] >= least
    assert found[1] == pytest.approx(score(field, points, PRIOR, found[0], window), abs=1e-6)


def test_nothing_is_found_of_nothing_or_in_nothing() -> None:
    field, points = scene(0)
    assert search(field, points[:0], PRIOR, WINDOWS[0], 0.0) is None
    assert search(Field(0.05, 0.05), points, PRIOR, WINDOWS[0], 0.0) is None
    assert stepwise(searching(Field(0.05, 0.05), points, PRIOR, WINDOWS[0], 0.0)) == (None, 0)
    assert stepwise(searching(field, points, PRIOR, WINDOWS[0], 0.0))[1] == 0  # all in one step
    found, steps = stepwise(searching(field, points, PRIOR, WINDOWS[0], 0.0, work=1))
    assert found == search(field, points, PRIOR, WINDOWS[0], 0.0)
    assert steps > 5


def test_points_near_the_middle_are_turned_by_no_less_than_a_quarter_degree() -> None:
    field = Field(0.05, 0.05)
    far = np.array([[0.0, 30.0], [0.0, -30.0]])
    field.add(SE2(0.0, 0.0, 3.0 * math.radians(0.25)).apply(far), np.zeros((2, 2)))
    found = search(field, far, SE2(), Window(0.0, 0.02, 1), 0.0)
    assert found is not None
    assert found[0].theta == pytest.approx(3.0 * math.radians(0.25))
    near = Field(0.05, 0.05)
    near.add(np.array([[0.01, 0.0]]), np.zeros((1, 2)))
    kept = search(near, np.array([[0.01, 0.0]]), SE2(), Window(0.0, 2.5, 1), 0.0)
    assert kept is not None
    assert abs(math.remainder(kept[0].theta, 1.0)) < 1e-9  # steps of a cell at a cell's reach


DEGREE = math.radians(1.0)


@pytest.mark.parametrize(
    ("gap", "turn", "count"),
    [
        (0.39, 19.0, 1),
        (0.41, 0.0, 2),
        (0.0, 19.9, 1),
        (0.0, 20.1, 2),
        (0.0, -20.1, 2),
        (0.0, 341.0, 1),  # 19 degrees the other off round
        (0.41, 21.0, 2),
    ],
)
def test_poses_apart_in_position_or_heading_are_two(gap: float, turn: float, count: int) -> None:
    off = gap * math.cos(0.7), gap * math.sin(0.7), turn * DEGREE
    poses = np.array([[1.0, 2.0, 3.0], np.array([1.0, 2.0, 3.0]) + off])
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


def partly_seen(rows: int, columns: int, resolution: float, seed: int) -> OccupancyGrid:
    """Return a map with boxes strewn in it, free in a strip or two and unknown elsewhere."""
    rng = np.random.default_rng(seed)
    data = np.full((rows, columns), UNKNOWN, np.int8)
    data[: rows // 3, columns // 4 :] = FREE
    data[rows - 3 :, : columns // 2] = FREE
    for r, c in rng.integers((0, 0), (rows, columns), (rows // 2, 2)).tolist():
        data[r : r + 2, c : c + 3] = OCCUPIED
    return OccupancyGrid(GridFrame(resolution, columns, rows, SE2(2.0, -3.0, 0.7)), data, 0.0)


def every_pose(grid: OccupancyGrid, endpoints: Floats) -> tuple[Floats, Floats]:
    """Return all poses that hold a free cell and the score of each, by their definitions.

    Every 0.1 m and 3 degrees; a beam scores a Gaussian of 0.2 m of how far it ends from the
    nearest obstacle's middle, at most 2 m, and nothing off the map.
    """
    size, frame = max(1, round(0.1 / grid.frame.resolution)), grid.frame
    gaps = cKDTree(np.argwhere(grid.data == OCCUPIED)).query(np.argwhere(grid.data > -2))[0]
    far = np.minimum(frame.resolution * gaps, 2.0).reshape(grid.data.shape)
    score = np.exp(-0.5 * (far / 0.2) ** 2)
    blocks = [
        (c, r)
        for r in range(0, frame.height, size)
        for c in range(0, frame.width, size)
        if (grid.data[r : r + size, c : c + size] == FREE).any()
    ]
    middles = np.array(blocks) + 0.5 * size
    poses, scores = [], []
    for turn in 3.0 * DEGREE * np.arange(120):
        ends = middles[:, None] + SE2(0.0, 0.0, turn).apply(endpoints) / frame.resolution
        c, r = np.floor(ends).astype(np.int64).transpose(2, 0, 1)
        inside = (c >= 0) & (c < frame.width) & (r >= 0) & (r < frame.height)
        values = np.where(inside, score[np.where(inside, r, 0), np.where(inside, c, 0)], 0.0)
        points = frame.origin.apply(middles * frame.resolution)
        poses.append(np.column_stack((points, np.full(len(middles), turn + frame.origin.theta))))
        scores.append(values.sum(axis=1))
    return np.concatenate(poses), np.concatenate(scores)


@pytest.mark.parametrize(
    ("rows", "columns", "resolution", "beams"),
    [
        (20, 31, 0.05, 30),  # blocks of two cells
        (40, 90, 0.1, 40),  # of a cell, found by ones twice as large
        (61, 115, 0.25, 20),  # by ones four times as large
    ],
)
def test_it_finds_the_poses_that_trying_all_of_them_finds(
    rows: int, columns: int, resolution: float, beams: int
) -> None:
    grid = partly_seen(rows, columns, resolution, rows)
    poses, _ = every_pose(grid, np.zeros((1, 2)))
    truth = SE2.from_array(poses[len(poses) // 3])
    walls = truth.inverse().apply(grid.frame.to_points(np.argwhere(grid.data == OCCUPIED)))
    seen = walls[np.argsort(np.hypot(*walls.T))][:beams]
    poses, scores = every_pose(grid, seen)
    found = GlobalSearch(MapField(grid, 2.0)).find(seen, 3)
    expected = poses[distinct(poses, scores, 3)]
    np.testing.assert_allclose(found[:, :2], expected[:, :2], atol=1e-9)
    turns = np.remainder(found[:, 2] - expected[:, 2] + 1.0, 2.0 * math.pi) - 1.0
    np.testing.assert_allclose(turns, 0.0, atol=1e-9)


def test_a_scan_of_many_beams_is_searched_with_some_all_around_it() -> None:
    grid = partly_seen(20, 31, 0.05, 7)
    search = GlobalSearch(MapField(grid, 2.0))
    truth = grid.frame.origin @ SE2(1.0, 0.2, 0.4)
    walls = truth.inverse().apply(grid.frame.to_points(np.argwhere(grid.data == OCCUPIED)))
    many = np.repeat(walls[:40], 7, axis=0)  # 280: every third of them
    np.testing.assert_array_equal(search.find(many, 4), search.find(many[::3], 4))
    assert len(search.find(walls[:40], 0)) == 0
