"""Claims: the beam model is the textbook's mixture, by hand-drawn grids wherever the map lies."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from arjuna_core.grid import GridFrame, OccupancyGrid
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_slam.amcl.config import AmclConfig
from arjuna_slam.amcl.scan_view import ScanView
from arjuna_slam.amcl.sensor_models import BeamModel
from arjuna_slam.matching.map_field import MapField

RANGE_MAX = 10.0
CONFIG = AmclConfig(
    laser_model_type="beam", z_hit=0.6, z_short=0.2, z_max=0.05, z_rand=0.15, lambda_short=0.5
)
ORIGINS = [SE2(), SE2(5.0, -3.0, 0.0), SE2(0.0, 0.0, math.pi / 2), SE2(-2.0, 4.0, 0.5)]


def grid_5x5(origin: SE2, edge: int = 100) -> OccupancyGrid:
    """Free, the last column occupied or what else is asked for."""
    data = np.zeros((5, 5), np.int8)
    data[:, 4] = edge
    data[0, 0] = 100  # a map has both
    return OccupancyGrid(GridFrame(0.5, 5, 5, origin), data)


def density(grid: OccupancyGrid, column: int, reading: float) -> float:
    """The model's density of one beam along the middle row, from the middle of a column."""
    x, y = grid.frame.to_point(2, column)
    pose: NDArray[np.float64] = np.array([[x, y, grid.frame.origin.theta]])
    scan = Scan(np.array([reading]), 0.0, 0.1, 0.05, RANGE_MAX)
    model = BeamModel(MapField(grid, 2.0), CONFIG)
    factor = model.weigh(pose, ScanView.of(scan, CONFIG)).factors[0]
    return float((factor - 1.0) ** (1.0 / 3.0))


@pytest.mark.parametrize("origin", ORIGINS)
@pytest.mark.parametrize(("column", "expected"), [(0, 1.75), (1, 1.25), (2, 0.75), (3, 0.25)])
@pytest.mark.parametrize("error", [-0.2, 0.0, 0.1])
def test_a_reading_is_weighed_against_the_range_to_the_obstacle(
    origin: SE2, column: int, expected: float, error: float
) -> None:
    reading = expected + error
    if reading <= 0.05:
        return  # shorter than the lidar reads
    theory = 0.6 * math.exp(-(error**2) / (2 * 0.2**2)) + 0.15 / RANGE_MAX
    if error < 0.0:
        theory += 0.2 * 0.5 * math.exp(-0.5 * reading)
    measured = density(grid_5x5(origin), column, reading)
    if error == 0.0:  # by a millimetre's rounding it may count as short
        assert measured in (
            pytest.approx(theory, rel=1e-4),
            pytest.approx(theory + 0.1 * math.exp(-0.5 * reading), rel=1e-4),
        )
    else:
        assert measured == pytest.approx(theory, rel=3e-3)


def test_no_return_has_the_share_of_readings_that_do_not_return() -> None:
    assert density(grid_5x5(SE2()), 1, math.inf) == pytest.approx(0.05, rel=1e-6)
    open_to_the_east = grid_5x5(SE2(), edge=0)
    hit = 0.6  # nothing is expected, nothing is read
    assert density(open_to_the_east, 1, math.inf) == pytest.approx(hit + 0.05, rel=1e-6)


def test_beyond_where_the_map_ends_in_the_unknown_any_reading_is_as_likely() -> None:
    unknown = grid_5x5(SE2(), edge=-1)
    assert density(unknown, 1, 1.6) == pytest.approx(1.0 / RANGE_MAX, rel=1e-6)
    assert density(unknown, 1, 4.0) == pytest.approx(1.0 / RANGE_MAX, rel=1e-6)
    short = 0.15 / RANGE_MAX + 0.2 * 0.5 * math.exp(-0.5 * 0.6)
    assert density(unknown, 1, 0.6) == pytest.approx(short, rel=1e-6)


def test_what_the_cache_says_is_what_the_first_cast_said() -> None:
    grid = grid_5x5(SE2(1.0, 2.0, 0.3))
    model = BeamModel(MapField(grid, 2.0), CONFIG)
    rng = np.random.default_rng(0)
    poses = np.column_stack((*grid.frame.to_points(rng.integers(0, 5, (50, 2))).T, np.zeros(50)))
    poses[:, 2] = rng.uniform(-math.pi, math.pi, 50)
    scan = Scan(rng.uniform(0.1, 3.0, 36), -math.pi, math.pi / 18, 0.05, RANGE_MAX)
    seen = ScanView.of(scan, CONFIG)
    first = model.weigh(poses, seen).factors
    np.testing.assert_array_equal(model.weigh(poses, seen).factors, first)
    assert (first > 1.0).all()
