"""Claims: points and cells correspond on grids that are shifted and turned; masks partition."""

from __future__ import annotations

import math

import numpy as np
import pytest

from arjuna_core.grid import GridFrame, OccupancyGrid
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
