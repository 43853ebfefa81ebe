"""Claims: likelihoods are those of the textbook on hand-drawn grids, wherever the map lies."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from arjuna_core.arrays import Floats
from arjuna_core.grid import GridFrame, OccupancyGrid
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_slam.amcl.config import SENSOR_MODELS, AmclConfig
from arjuna_slam.amcl.scan_view import Beams, ScanView
from arjuna_slam.amcl.sensor_models import (
    BeamModel,
    LikelihoodField,
    LikelihoodFieldProb,
    make_sensor,
)
from arjuna_slam.matching.map_field import MapField

CONFIG = AmclConfig(laser_likelihood_max_dist=2.0)
RANGE_MAX = 10.0
HERE = np.zeros((1, 2))
ORIGINS = [
    SE2(),
    SE2(5.0, -3.0, 0.0),
    SE2(0.0, 0.0, math.pi / 2),
    SE2(-2.0, 4.0, math.radians(30.0)),
]
# 0.5 exp(-d^2 / (2 0.2^2)) + 0.5 / 10, d = 0.5 m times the distance in cells to the centre
FAR, MIDDLE, NEAR, HIT = 0.05, 0.05096523, 0.07196847, 0.55
GOLDEN = np.array(
    [
        [FAR, FAR, 0.05000186, FAR, FAR],
        [FAR, MIDDLE, NEAR, MIDDLE, FAR],
        [0.05000186, NEAR, HIT, NEAR, 0.05000186],
        [FAR, MIDDLE, NEAR, MIDDLE, FAR],
        [FAR, FAR, 0.05000186, FAR, FAR],
    ]
)


def grid_5x5(origin: SE2) -> OccupancyGrid:
    data = np.zeros((5, 5), np.int8)
    data[2, 2] = 100
    return OccupancyGrid(GridFrame(0.5, 5, 5, origin), data)


def seen(endpoints: Floats) -> ScanView:
    """Return a scan with these end points [m]."""
    ranges = np.hypot(*endpoints.T)
    bearings = np.arctan2(endpoints[:, 1], endpoints[:, 0])
    directions = np.column_stack((np.cos(bearings), np.sin(bearings)))
    beams = Beams(directions, ranges, np.ones(len(ranges), bool), endpoints, -directions)
    return ScanView(0.0, RANGE_MAX, SE2(), beams, beams)


def poses_at_cells(grid: OccupancyGrid) -> Floats:
    cells = np.argwhere(np.ones(grid.frame.shape, bool))
    return np.column_stack((grid.frame.to_points(cells), np.zeros(len(cells))))


@pytest.mark.parametrize("origin", ORIGINS)
def test_likelihood_field_is_golden_under_offset_and_rotation(origin: SE2) -> None:
    grid = grid_5x5(origin)
    model = LikelihoodField(MapField(grid, 2.0), CONFIG)
    factors = model.weigh(poses_at_cells(grid), seen(HERE)).factors.reshape(5, 5)
    np.testing.assert_allclose(factors, 1.0 + GOLDEN**3, rtol=1e-6)


@pytest.mark.parametrize("origin", ORIGINS)
def test_likelihood_field_prob_is_golden_under_offset_and_rotation(origin: SE2) -> None:
    grid = grid_5x5(origin)
    model = LikelihoodFieldProb(MapField(grid, 2.0), CONFIG)
    factors = model.weigh(poses_at_cells(grid), seen(HERE)).factors.reshape(5, 5)
    np.testing.assert_allclose(factors, GOLDEN / HIT, rtol=2e-5)


@pytest.mark.parametrize("origin", ORIGINS)
@pytest.mark.parametrize("heading", [0.0, 0.7, -2.0])
def test_beams_end_where_pose_and_bearing_say(origin: SE2, heading: float) -> None:
    grid = grid_5x5(origin)
    model = LikelihoodField(MapField(grid, 2.0), CONFIG)
    target = np.array(grid.frame.to_point(2, 2))
    start = target - 0.8 * np.array([math.cos(heading), math.sin(heading)])
    pose = np.array([[start[0], start[1], heading]])
    factors = model.weigh(pose, seen(np.array([[0.8, 0.0]]))).factors
    assert factors[0] == pytest.approx(1.0 + HIT**3, rel=1e-6)


def test_an_endpoint_off_the_map_is_as_far_as_can_be() -> None:
    model = LikelihoodField(MapField(grid_5x5(SE2()), 2.0), CONFIG)
    factors = model.weigh(np.array([[100.0, 0.0, 0.0]]), seen(HERE)).factors
    assert factors[0] == pytest.approx(1.0 + 0.05**3, rel=1e-6)


def test_likelihood_field_adds_beams_and_prob_multiplies_them() -> None:
    field = MapField(grid_5x5(SE2()), 2.0)
    poses, beams = (
        np.array([[1.25, 1.25, 0.0], [0.75, 1.25, 0.0]]),
        np.array([[0.0, 0.0], [0.5, 0]]),
    )
    added = LikelihoodField(field, CONFIG).weigh(poses, seen(beams)).factors
    np.testing.assert_allclose(added, 1.0 + HIT**3 + NEAR**3, rtol=1e-6)
    product = LikelihoodFieldProb(field, CONFIG).weigh(poses, seen(beams))
    np.testing.assert_allclose(product.levels, math.sqrt(HIT * NEAR), rtol=1e-5)


def test_without_random_readings_the_product_still_prefers_what_fits_better() -> None:
    config = replace(CONFIG, z_rand=0.0, sigma_hit=0.02)
    model = LikelihoodFieldProb(MapField(grid_5x5(SE2()), 2.0), config)
    poses = np.array([[1.25, 1.25, 0.0], [0.75, 1.25, 0.0]])
    with np.errstate(all="raise", under="ignore"):
        here, aside = model.weigh(poses, seen(np.array([[0.0, 0.0], [0.0, 50.0]]))).factors
    assert here > aside >= 0.0  # one beam ends where none can


def test_beam_skipping_ignores_a_beam_that_fits_no_particle() -> None:
    field = MapField(grid_5x5(SE2()), 2.0)
    poses = np.array([[1.25, 1.25, 0.0], [1.2, 1.2, 0.0]])
    beams = np.array([[0.0, 0.0], [0.0, 50.0]])
    skipping = LikelihoodFieldProb(field, AmclConfig(do_beamskip=True))
    assert skipping.weigh(poses, seen(beams)).levels[0] == pytest.approx(HIT, rel=1e-5)
    keeping = LikelihoodFieldProb(field, AmclConfig(do_beamskip=False))
    assert keeping.weigh(poses, seen(beams)).levels[0] < 0.5 * HIT
    spread = np.array([*poses, [1.25, 2.6, 0.0]])  # its mean is 0.9 m away: they have not converged
    assert skipping.weigh(spread, seen(beams)).levels[0] < 0.5 * HIT
    all_off = skipping.weigh(poses, seen(beams[1:]))
    assert np.isfinite(all_off.levels).all()  # too many to skip: all are used


@pytest.mark.parametrize("name", SENSOR_MODELS)
def test_every_model_prefers_the_true_pose(name: str) -> None:
    field = MapField(grid_5x5(SE2()), 2.0)
    model = make_sensor(field, AmclConfig(laser_model_type=name))
    poses = np.array([[0.25, 1.25, 0.0], [0.25, 1.25, 0.5]])
    factors = model.weigh(poses, seen(np.array([[1.0, 0.0]]))).factors
    assert factors[0] > factors[1] > 0.0


def test_an_endpoint_in_the_unknown_is_at_least_as_likely_as_any_reading() -> None:
    grid = grid_5x5(SE2())
    grid.data[:, 4] = -1
    model = LikelihoodField(MapField(grid, 2.0), CONFIG)
    factors = model.weigh(poses_at_cells(grid), seen(HERE)).factors.reshape(5, 5)
    np.testing.assert_allclose(factors[:, 4], 1.0 + (1.0 / RANGE_MAX) ** 3, rtol=1e-6)
    np.testing.assert_allclose(factors[:, :4], 1.0 + GOLDEN[:, :4] ** 3, rtol=1e-6)


BEAM = AmclConfig(
    laser_model_type="beam", z_hit=0.6, z_short=0.2, z_max=0.05, z_rand=0.15, lambda_short=0.5
)


def grid_with_edge(origin: SE2, edge: int = 100) -> OccupancyGrid:
    """Free, the last column occupied or what else is asked for."""
    data = np.zeros((5, 5), np.int8)
    data[:, 4] = edge
    data[0, 0] = 100  # a map has both
    return OccupancyGrid(GridFrame(0.5, 5, 5, origin), data)


def density(
    grid: OccupancyGrid,
    column: int,
    reading: float,
    bearing: float = 0.0,
    config: AmclConfig = BEAM,
    range_max: float = RANGE_MAX,
) -> float:
    """The model's density of one beam from the middle row and a column, at an angle to the row."""
    x, y = grid.frame.to_point(2, column)
    mount = SE2(0.3, -0.7, 0.4)
    pose: Floats = (SE2(x, y, grid.frame.origin.theta) @ mount.inverse()).array()[np.newaxis]
    scan = Scan(np.array([reading]), bearing, 0.1, 0.05, range_max, T_base_sensor=mount)
    model = BeamModel(MapField(grid, 2.0), config)
    factor = model.weigh(pose, ScanView.of(scan, config)).factors[0]
    return float((factor - 1.0) ** (1.0 / 3.0))


@pytest.mark.parametrize("origin", ORIGINS)
@pytest.mark.parametrize(
    ("column", "ahead", "degrees"),
    [(0, 1.75, 0.0), (1, 1.25, 0.0), (2, 0.75, -30.0), (3, 0.25, 45.0)],
)
@pytest.mark.parametrize("error", [-0.2, 0.0, 0.1])
def test_a_reading_is_weighed_against_the_range_to_the_obstacle(
    origin: SE2, column: int, ahead: float, degrees: float, error: float
) -> None:
    bearing = math.radians(degrees)
    reading = ahead / math.cos(bearing) + error
    if reading <= 0.05:
        return  # shorter than the lidar reads
    theory = 0.6 * math.exp(-(error**2) / (2 * 0.2**2)) + 0.15 / RANGE_MAX
    if error < 0.0:
        theory += 0.2 * 0.5 * math.exp(-0.5 * reading)
    measured = density(grid_with_edge(origin), column, reading, bearing)
    if error == 0.0:  # by a millimetre's rounding it may count as short
        assert measured in (
            pytest.approx(theory, rel=1e-4),
            pytest.approx(theory + 0.1 * math.exp(-0.5 * reading), rel=1e-4),
        )
    else:
        assert measured == pytest.approx(theory, rel=3e-3)


def test_no_return_has_the_share_of_readings_that_do_not_return() -> None:
    assert density(grid_with_edge(SE2()), 1, math.inf) == pytest.approx(0.05, rel=1e-6)
    open_to_the_east = grid_with_edge(SE2(), edge=0)
    hit = 0.6  # nothing is expected, nothing is read
    assert density(open_to_the_east, 1, math.inf) == pytest.approx(hit + 0.05, rel=1e-6)
    far = density(open_to_the_east, 1, math.inf, range_max=100.0)
    assert far == pytest.approx(hit + 0.05, rel=1e-6)
    near = replace(BEAM, laser_max_range=1.0)  # nearer than the wall
    beyond = density(grid_with_edge(SE2()), 1, math.inf, config=near)
    assert beyond == pytest.approx(hit + 0.05, rel=1e-6)


def test_beyond_where_the_map_ends_in_the_unknown_any_reading_is_as_likely() -> None:
    unknown = grid_with_edge(SE2(), edge=-1)
    assert density(unknown, 1, 1.6) == pytest.approx(1.0 / RANGE_MAX, rel=1e-6)
    assert density(unknown, 1, 4.0) == pytest.approx(1.0 / RANGE_MAX, rel=1e-6)
    short = 0.15 / RANGE_MAX + 0.2 * 0.5 * math.exp(-0.5 * 0.6)
    assert density(unknown, 1, 0.6) == pytest.approx(short, rel=1e-6)


def test_what_the_cache_says_is_what_the_first_cast_said() -> None:
    grid = grid_with_edge(SE2(1.0, 2.0, 0.3))
    model = BeamModel(MapField(grid, 2.0), BEAM)
    rng = np.random.default_rng(0)
    poses = np.column_stack((*grid.frame.to_points(rng.integers(0, 5, (50, 2))).T, np.zeros(50)))
    poses[:, 2] = rng.uniform(-math.pi, math.pi, 50)
    scan = Scan(rng.uniform(0.1, 3.0, 36), -math.pi, math.pi / 18, 0.05, RANGE_MAX)
    seen = ScanView.of(scan, BEAM)
    first = model.weigh(poses, seen).factors
    np.testing.assert_array_equal(model.weigh(poses, seen).factors, first)
    assert (first > 1.0).all()


@pytest.mark.parametrize(
    ("edge", "headings"), [(596, 360), (597, 180), (1192, 90), (1193, 45), (2000, 45)]
)
def test_ranges_of_large_maps_are_kept_for_fewer_headings(edge: int, headings: int) -> None:
    large = MapField(grid_with_edge(SE2()), 2.0)
    large.occupied = large.unknown = np.zeros((edge, edge), np.bool_)
    assert BeamModel(large, AmclConfig())._cache.shape == (edge, edge, headings)
