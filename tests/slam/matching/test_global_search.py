"""Poses all over a map where a scan fits: which are kept apart, and that none better is missed."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.spatial import cKDTree

from arjuna_core.arrays import Floats
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
