"""Grids, scans and the rays between them."""

from __future__ import annotations

import math

import numpy as np
import pytest

from arjuna_core.grid import GridFrame, OccupancyGrid
from arjuna_core.raycast import cast, line_cells
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2

ORIGINS = [SE2(), SE2(-3.2, 7.7, 0.0), SE2(1.0, 2.0, math.pi / 2), SE2(-5.0, 0.3, -2.2)]


@pytest.mark.parametrize("origin", ORIGINS)
@pytest.mark.parametrize("resolution", [0.05, 0.1, 1.0])
def test_the_centre_of_every_cell_lies_in_it(origin: SE2, resolution: float) -> None:
    frame = GridFrame(resolution, 13, 7, origin)
    cells = np.argwhere(np.ones(frame.shape, bool))
    np.testing.assert_array_equal(frame.to_cells(frame.to_points(cells)), cells)
    assert frame.inside(cells).all()


@pytest.mark.parametrize("origin", ORIGINS)
def test_points_of_a_cell_all_fall_into_it(origin: SE2) -> None:
    frame = GridFrame(0.5, 10, 10, origin)
    rng = np.random.default_rng(0)
    cells = rng.integers(0, 10, (200, 2))
    local = (cells[:, ::-1] + rng.uniform(0.001, 0.999, (200, 2))) * 0.5
    np.testing.assert_array_equal(frame.to_cells(origin.apply(local)), cells)


def test_row_0_is_lowest_in_y_and_column_0_in_x() -> None:
    frame = GridFrame(0.5, 4, 3)
    assert frame.shape == (3, 4)
    assert frame.to_cell(0.1, 1.2) == (2, 0)
    assert frame.to_point(0, 3) == (1.75, 0.25)


def test_a_quarter_turn_lays_columns_along_y() -> None:
    frame = GridFrame(1.0, 4, 3, SE2(0.0, 0.0, math.pi / 2))
    x, y = frame.to_point(0, 2)
    assert x == pytest.approx(-0.5)
    assert y == pytest.approx(2.5)


@pytest.mark.parametrize(
    ("cell", "inside"),
    [
        ((0, 0), True),
        ((2, 3), True),
        ((3, 0), False),
        ((0, 4), False),
        ((-1, 0), False),
        ((0, -1), False),
    ],
)
def test_contains_and_inside_agree_at_the_edges(cell: tuple[int, int], inside: bool) -> None:
    frame = GridFrame(1.0, 4, 3)
    assert frame.contains(*cell) is inside
    assert frame.inside(np.array([cell])).tolist() == [inside]


def test_points_just_below_the_origin_lie_in_cell_minus_one() -> None:
    assert GridFrame(1.0, 4, 3).to_cell(-0.01, -0.01) == (-1, -1)


def test_every_cell_of_a_trinary_map_is_exactly_one_of_three() -> None:
    data = np.array([[-1, 0, 100], [100, -1, 0]], np.int8)
    grid = OccupancyGrid(GridFrame(1.0, 3, 2), data)
    count = grid.unknown().astype(int) + grid.free() + grid.occupied()
    assert (count == 1).all()
    np.testing.assert_array_equal(grid.occupied(), data == 100)
    np.testing.assert_array_equal(grid.free(), data == 0)


def test_thresholds_include_their_own_value() -> None:
    grid = OccupancyGrid(GridFrame(1.0, 4, 1), np.array([[25, 26, 64, 65]], np.int8))
    assert grid.free().tolist() == [[True, False, False, False]]
    assert grid.occupied().tolist() == [[False, False, False, True]]


def test_data_of_another_shape_is_refused() -> None:
    with pytest.raises(ValueError, match=r"data has shape \(2, 2\), the frame \(3, 2\)"):
        OccupancyGrid(GridFrame(1.0, 2, 3), np.zeros((2, 2), np.int8))


def test_only_returns_within_the_limits_are_valid() -> None:
    ranges = np.array([0.09, 0.1, 5.0, 9.99, 10.0, np.inf, -np.inf, np.nan, 0.0, -1.0])
    scan = Scan(ranges, 0.0, 0.1, 0.1, 10.0)
    assert scan.valid.tolist() == [False, True, True, True] + 6 * [False]
    assert len(scan.points()) == 3


def test_bearings_step_from_the_first_also_clockwise() -> None:
    np.testing.assert_allclose(Scan(np.ones(4), -1.0, 0.5, 0.1, 9.0).angles, (-1, -0.5, 0, 0.5))
    np.testing.assert_allclose(Scan(np.ones(3), 1.0, -0.5, 0.1, 9.0).angles, (1, 0.5, 0))


def test_points_lie_in_the_base_frame() -> None:
    sensor = SE2(0.2, 0.0, math.pi / 2)
    scan = Scan(np.array([1.0, 2.0]), 0.0, math.pi / 2, 0.1, 10.0, T_base_sensor=sensor)
    np.testing.assert_allclose(scan.points(), [[0.2, 1.0], [-1.8, 0.0]], atol=1e-12)


def test_a_scan_without_beams_has_no_points() -> None:
    scan = Scan(np.empty(0), 0.0, 0.1, 0.1, 10.0)
    assert scan.points().shape == (0, 2)
    assert scan.angles.shape == (0,)


def test_rays_start_and_point_where_the_base_has_moved_to() -> None:
    mount, motion = SE2(0.2, -0.1, 0.3), SE2(0.1, 0.02, 0.4)
    scan = Scan(
        np.array([2.0, 3.0, 4.0]), -0.5, 0.5, 0.1, 10.0, T_base_sensor=mount, motion=motion
    )  # fmt: skip
    half = SE2.exp(0.5 * motion.log())
    for ray, moved, angle in zip(scan.rays(), (SE2(), half, motion), (-0.5, 0.0, 0.5), strict=True):
        sensor = moved @ mount
        assert ray[:2] == pytest.approx([sensor.x, sensor.y])
        assert ray[2] == pytest.approx(sensor.theta + angle)
    last = motion @ mount @ SE2(4.0 * math.cos(0.5), 4.0 * math.sin(0.5), 0.0)
    assert scan.points()[2] == pytest.approx([last.x, last.y])


def test_the_nearest_return_is_looked_for_in_a_sector_of_the_base() -> None:
    ranges = np.array([0.05, 2.0, 1.0, np.inf, np.nan, 3.0])
    scan = Scan(ranges, 0.0, math.pi / 3.0, 0.1, 10.0, T_base_sensor=SE2(0.2, 0.0, math.pi))
    assert scan.nearest() == 1.0
    assert scan.nearest(-math.pi / 3.0, 0.1) == 1.0
    assert scan.nearest(math.pi * 5.0 / 3.0, 0.1) == 1.0
    assert scan.nearest(-2.0 * math.pi / 3.0, 0.1) == 2.0
    assert scan.nearest(math.pi, 0.1) == math.inf
    assert scan.nearest(0.0, 0.1) == math.inf


@pytest.mark.parametrize("seed", range(6))
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
