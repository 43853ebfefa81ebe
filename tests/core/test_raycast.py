"""Claims: traced lines are Bresenham's, and cast ranges are those of plane geometry."""

from __future__ import annotations

import math

import numpy as np
import pytest

from arjuna_core.raycast import cast, line_cells


@pytest.mark.parametrize("seed", range(20))
def test_a_line_is_connected_ends_at_its_target_and_stays_within_half_a_cell(seed: int) -> None:
    rng = np.random.default_rng(seed)
    (r0, c0), (r1, c1) = rng.integers(0, 40, (2, 2)).tolist()
    cells = np.array(list(line_cells(r0, c0, r1, c1)))
    assert cells[0].tolist() == [r0, c0]
    assert cells[-1].tolist() == [r1, c1]
    assert len(cells) == max(abs(r1 - r0), abs(c1 - c0)) + 1
    assert np.abs(np.diff(cells, axis=0)).max(initial=0) <= 1
    length = math.hypot(r1 - r0, c1 - c0)
    if length > 0.0:
        cross = (cells[:, 0] - r0) * (c1 - c0) - (cells[:, 1] - c0) * (r1 - r0)
        assert np.abs(cross).max() / length <= 0.5 + 1e-9


def test_a_line_of_no_length_is_one_cell() -> None:
    assert list(line_cells(3, 4, 3, 4)) == [(3, 4)]


@pytest.mark.parametrize("resolution", [0.05, 0.1, 1.0])
def test_ranges_in_a_square_room_are_those_of_geometry(resolution: float) -> None:
    cells = 100
    blocked = np.zeros((cells, cells), bool)
    blocked[[0, -1], :] = blocked[:, [0, -1]] = True
    x, y = 31.3 * resolution, 57.9 * resolution
    bearings = np.linspace(-math.pi, math.pi, 361)
    low, high = resolution, (cells - 1) * resolution
    with np.errstate(divide="ignore"):
        to_x = np.where(np.cos(bearings) > 0, high - x, low - x) / np.cos(bearings)
        to_y = np.where(np.sin(bearings) > 0, high - y, low - y) / np.sin(bearings)
    expected = np.minimum(np.abs(to_x), np.abs(to_y))
    ranges = cast(blocked, resolution, x, y, bearings, 1000.0)
    np.testing.assert_allclose(ranges, expected, rtol=1e-9)


def test_axis_parallel_rays_are_exact() -> None:
    blocked = np.zeros((9, 9), bool)
    blocked[4, 8] = blocked[8, 4] = blocked[4, 0] = blocked[0, 4] = True
    bearings = np.array([0.0, math.pi / 2, math.pi, -math.pi / 2])
    np.testing.assert_allclose(cast(blocked, 1.0, 4.5, 4.5, bearings, 50.0), 3.5)


def test_a_ray_that_meets_nothing_in_range_is_infinite() -> None:
    blocked = np.zeros((10, 10), bool)
    blocked[5, 9] = True
    bearing = np.array([0.0])
    assert cast(blocked, 1.0, 0.5, 5.5, bearing, 8.4).tolist() == [math.inf]
    assert cast(blocked, 1.0, 0.5, 5.5, bearing, 8.6).tolist() == [8.5]
    assert cast(blocked, 1.0, 0.5, 5.5, np.array([math.pi]), 1e4).tolist() == [math.inf]


def test_a_ray_from_outside_enters_the_grid() -> None:
    blocked = np.ones((4, 4), bool)
    assert cast(blocked, 1.0, -2.5, 1.5, np.array([0.0]), 10.0).tolist() == [2.5]


def test_a_ray_from_a_blocked_cell_has_no_length() -> None:
    assert cast(np.ones((3, 3), bool), 1.0, 1.5, 1.5, np.array([0.3]), 10.0).tolist() == [0.0]


def test_no_ray_slips_through_a_diagonal_wall_of_full_cells() -> None:
    blocked = np.eye(50, dtype=bool) | np.eye(50, k=1, dtype=bool)
    bearings = np.linspace(-0.25 * math.pi + 0.05, 0.2 * math.pi, 200)
    ranges = cast(blocked, 0.1, 0.55, 3.05, bearings, 20.0)  # from above the diagonal
    crosses = bearings < 0.1
    assert np.isfinite(ranges[crosses]).all()
