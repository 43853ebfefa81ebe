"""Claims: a field knows its surface however much of it there is."""

from __future__ import annotations

import numpy as np
import pytest

from arjuna_core.arrays import Floats
from arjuna_slam.matching.field import Field

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
