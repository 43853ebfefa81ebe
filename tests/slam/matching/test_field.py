"""Likelihood fields, surfaces and refinement."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from arjuna_core.arrays import Floats
from arjuna_core.se2 import SE2
from arjuna_slam.matching.field import Field
from arjuna_slam.matching.refinement import sample_distance, solve
from arjuna_slam.matching.scan_matcher import invert
from arjuna_slam.matching.surface import Surface, extract
from tests.slam.slam_room import box, room, scan_at

WALL = np.column_stack((np.arange(0.0, 40.0, 0.05), np.full(800, 0.02)))
UP = np.tile((0.0, 1.0), (800, 1))


@pytest.mark.parametrize(("walls", "planes_in_16_bits"), [(4, True), (16, False)])
def test_every_wall_is_found_again(walls: int, planes_in_16_bits: bool) -> None:
    field = Field(0.05, 0.05)
    for k in range(walls):
        field.add(WALL + np.array([0.0, float(k)]), UP)
    field.trim()
    assert (len(field.planes) < 1 << 16) is planes_in_16_bits
    points, normals = field.surface()
    found, counts = np.unique(np.round(points[:, 1]), return_counts=True)
    assert found.tolist() == list(range(walls))
    assert counts.min() == counts.max() >= 790
    assert np.allclose(normals, (0.0, 1.0), atol=1e-6)


def likelihoods(points: Floats, centres_: Floats) -> Floats:
    """Return the greatest of Gaussians of deviation 0.05 m around points, in 255 steps."""
    gaps = np.linalg.norm(centres_[:, None] - points[None], axis=2)
    levels = np.floor(255.0 * np.exp(-0.5 * (gaps / 0.05) ** 2).max(axis=1) + 0.5)
    return np.where(levels < 2.0, 0.0, levels) / 255.0


def centres(low: float, high: float) -> Floats:
    """Return the centres of all cells of 0.05 m in a square."""
    steps = np.arange(round(low / 0.05), round(high / 0.05)) * 0.05 + 0.025
    return np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)


def scattered(seed: int, reach: float, count: int = 25) -> Floats:
    return np.random.default_rng(seed).uniform(-reach, reach, (count, 2))


NO_NORMALS = np.zeros((25, 2))


@pytest.mark.parametrize("reaches", [(1.0, 2.5), (2.5, 1.0), (0.1, 0.2)])
def test_a_cell_holds_the_likelihood_of_a_point_there(reaches: tuple[float, float]) -> None:
    field, added = Field(0.05, 0.05), np.zeros((0, 2))
    for seed, reach in enumerate(reaches):
        points = scattered(seed, reach)
        field.add(points, NO_NORMALS)
        added = np.concatenate((added, points))
        centres_ = centres(-3.0, 3.0)
        np.testing.assert_allclose(
            field.likelihood(centres_), likelihoods(added, centres_), rtol=0.0, atol=1.01 / 255.0
        )
    field.add(np.zeros((0, 2)), np.zeros((0, 2)))  # nothing changes nothing
    np.testing.assert_allclose(field.origin / 0.05, np.round(field.origin / 0.05), atol=1e-9)
    before = field.likelihood(centres_)
    shape = field.score.shape
    field.trim()
    np.testing.assert_array_equal(field.likelihood(centres_), before)
    assert field.score.shape < shape
    assert field.index.shape == field.score.shape
    edges = field.score[0], field.score[-1], field.score[:, 0], field.score[:, -1]
    assert all(edge.any() for edge in edges)


@pytest.mark.parametrize("off", [(0.0, 1.0), (0.0, -1.0), (1.0, 0.0), (-1.0, 0.0)])
def test_it_grows_where_it_must_by_two_metres_more(off: tuple[float, float]) -> None:
    field = Field(0.05, 0.05)
    field.add(np.array([[0.01, 0.01], [0.99, 0.49]]), np.zeros((2, 2)))
    assert field.score.shape == (10 + 2 * 46, 20 + 2 * 46)  # 2 m, the Gaussian and a rim
    kept = field.score
    far = np.array([[0.5, 0.25]]) + 2.2 * np.array([off])
    field.add(far, np.zeros((1, 2)))
    assert field.score is kept
    field.add(far + np.array([off]), np.zeros((1, 2)))
    grown = np.array(field.score.shape) - kept.shape
    across, along = (0, 1) if off[0] else (1, 0)
    assert grown[across] == 0
    assert 40 < grown[along] < 70


def test_a_level_of_the_pyramid_bounds_the_scores_of_its_blocks() -> None:
    field = Field(0.05, 0.05)
    field.add(scattered(3, 0.4), NO_NORMALS)
    field.trim()
    field.score = field.score[:-1]  # odd numbers of rows and even ones of columns
    field.index = field.index[:-1]
    cells, levels = field.pyramid(3)
    assert field.pyramid(3)[0] is cells
    rows, columns = field.score.shape
    for h in (1, 2, 3):
        start, high, wide = levels[h].tolist()
        level, size = cells[start : start + high * wide].reshape(high, wide), 2**h
        assert (high, wide) == (-(-rows // size) + 1, -(-columns // size) + 1)
        for r in range(high):
            for c in range(wide):
                y, x = size * (r - 1), size * (c - 1)
                block = field.score[max(y, 0) : y + 2 * size, max(x, 0) : x + 2 * size]
                assert level[r, c] == block.max(initial=0)
    assert len(field.pyramid(2)[1]) == 3
    field.add(scattered(4, 0.1), NO_NORMALS)
    assert field.pyramid(2)[1][0, 1:].tolist() == list(field.score.shape)


def test_half_as_fine_a_field_bounds_it() -> None:
    field = Field(0.05, 0.05)
    field.add(scattered(5, 0.7), NO_NORMALS)
    half = field.halved()
    assert half.resolution == 0.1
    assert half.sigma == 0.05
    np.testing.assert_array_equal(half.origin, field.origin)
    expected = [
        [
            field.score[2 * r : 2 * r + 2, 2 * c : 2 * c + 2].max()
            for c in range(half.score.shape[1])
        ]
        for r in range(half.score.shape[0])
    ]
    np.testing.assert_array_equal(half.score, expected)
    assert half.score.shape == tuple(-(-n // 2) for n in field.score.shape)


def facing(*degrees: float) -> np.ndarray:
    angles = np.radians(degrees)
    return np.column_stack((np.cos(angles), np.sin(angles)))


@pytest.mark.parametrize(
    ("gap", "turn", "linked", "filled"),
    [
        (0.04, 0.0, True, 0),
        (0.06, 0.0, True, 1),
        (0.26, 0.0, True, 5),
        (0.26, 36.0, True, 5),
        (0.26, -36.0, True, 5),
        (0.26, 38.0, True, 0),  # around a corner: not the same wall
        (0.26, 0.0, False, 0),
    ],
)
def test_a_wall_gap_is_filled_evenly(gap: float, turn: float, linked: bool, filled: int) -> None:
    ends = np.array([[1.0, 2.0], [1.0 + 0.6 * gap, 2.0 - 0.8 * gap], [9.0, 9.0]])
    normals = facing(20.0, 20.0 + turn, 0.0)
    surface = Surface(ends, normals, np.array([linked, False, False]))
    points, turned = surface.dense(0.05)
    assert len(points) == len(turned) == filled + 3
    share = np.linspace(0.0, 1.0, filled + 2)
    np.testing.assert_allclose(points[:-1], ends[0] + share[:, None] * (ends[1] - ends[0]))
    blend = (1.0 - share)[:, None] * normals[0] + share[:, None] * normals[1]
    np.testing.assert_allclose(turned[:-1], blend / np.linalg.norm(blend, axis=1)[:, None])
    np.testing.assert_array_equal(points[-1], ends[2])
    if filled == 5:  # in the middle half of the turn
        middle = math.degrees(math.atan2(turned[3, 1], turned[3, 0]))
        assert middle == pytest.approx(20.0 + 0.5 * turn)


def test_points_without_a_wall_are_left_as_they_are() -> None:
    ends, none = np.array([[1.0, 2.0], [2.0, 2.0]]), np.zeros((2, 2))
    points, normals = Surface(ends, none, np.ones(2, np.bool_)).dense(0.05)
    np.testing.assert_array_equal(points, ends)
    np.testing.assert_array_equal(normals, none)
    nothing = Surface(ends[:0], none[:0], np.zeros(0, np.bool_)).dense(0.05)
    assert [len(part) for part in nothing] == [0, 0]


def test_normals_are_unit_face_the_sensor_and_lie_across_walls() -> None:
    surface = extract(scan_at(box(-2.0, -2.0, 2.0, 2.0), SE2()), 20.0)
    length = np.hypot(*surface.normals.T)
    assert ((np.abs(length - 1.0) < 1e-9) | (length == 0.0)).all()
    assert (length > 0.0).mean() > 0.85
    assert ((surface.normals * surface.points).sum(axis=1) <= 0.0).all()
    right = (surface.points[:, 0] > 1.99) & (np.abs(surface.points[:, 1]) < 1.5)
    assert np.abs(surface.normals[right] - (-1.0, 0.0)).max() < 1e-6


def test_a_wall_continues_where_beams_are_lost() -> None:
    scan = scan_at(room(), SE2(5.0, 5.0, 0.3), sigma=0.01, rng=np.random.default_rng(2))
    lost = np.where(np.random.default_rng(3).random(360) < 0.3, np.inf, scan.ranges)
    surface = extract(dataclasses.replace(scan, ranges=lost), 20.0)
    assert (np.abs(surface.normals).sum(axis=1) > 0.0).mean() > 0.8
    gap = np.where(np.arange(360) % 8 < 4, np.inf, scan.ranges)
    cut = extract(dataclasses.replace(scan, ranges=gap), 20.0)
    assert not cut.linked[3::4].any()


RESOLUTION = 0.05


@pytest.mark.parametrize("seed", range(5))
def test_the_gradient_of_the_distance_is_that_of_finite_differences(seed: int) -> None:
    rng = np.random.default_rng(seed)
    distances = rng.random((6, 8)).astype(np.float32)
    column, row = rng.integers(1, 5, 2) + rng.uniform(0.6, 1.3, 2)  # inside four cells' centres
    step = 1e-3
    _, nx, ny, trust = sample_distance(distances, column, row, RESOLUTION)
    assert trust == 1.0

    def at(dx: float, dy: float) -> float:
        return float(sample_distance(distances, column + dx, row + dy, RESOLUTION)[0])

    if all(step < part % 1.0 < 1.0 - step for part in (column - 0.5, row - 0.5)):
        slope = 2.0 * step * RESOLUTION
        assert nx == pytest.approx((at(step, 0.0) - at(-step, 0.0)) / slope, rel=1e-4)
        assert ny == pytest.approx((at(0.0, step) - at(0.0, -step)) / slope, rel=1e-4)


def test_a_cell_centre_has_its_own_distance_and_points_off_the_field_none() -> None:
    distances = np.arange(12, dtype=np.float32).reshape(3, 4)
    assert sample_distance(distances, 2.5, 1.5, RESOLUTION)[0] == distances[1, 2]
    assert sample_distance(distances, -0.1, 1.5, RESOLUTION)[3] == 0.0
    assert sample_distance(distances, 3.6, 1.5, RESOLUTION)[3] == 0.0


@pytest.mark.parametrize("seed", range(5))
def test_solving_and_inverting_agree_with_numpy(seed: int) -> None:
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(3, 3))
    matrix, right = root @ root.T + 0.1 * np.eye(3), rng.normal(size=3)
    np.testing.assert_allclose(solve(matrix, right), np.linalg.solve(matrix, right), rtol=1e-9)
    np.testing.assert_allclose(invert(matrix), np.linalg.inv(matrix), rtol=1e-9)
