"""Filters of scans and of the IMU."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from arjuna_core.errors import ConfigError
from arjuna_core.pose3 import ORIGIN, Pose3
from arjuna_sim.processing.madgwick import (
    UP,
    MadgwickFilter,
    _gradient,
    orientation,
    quaternion_of,
    rotation,
)
from arjuna_sim.processing.scan_filters import FILTERS
from arjuna_sim.processing.sweep import (
    ArrayFilter,
    AverageChain,
    AverageFilter,
    Observations,
    Sweep,
)

NAN = math.nan


def sweep(
    ranges: Sequence[float], degrees: float = 1.0, intensities: Sequence[float] = ()
) -> Sweep:
    """Return beams that are spread about straight ahead."""
    step = math.radians(degrees)
    start = -step * (len(ranges) - 1) / 2.0
    return Sweep(np.array(ranges, float), np.array(intensities, float), start, step, 0.1, 10.0)


def filtered(kind: str, given: Sweep, T: Any = ORIGIN, **values: Any) -> Sweep:
    """Return what a class of filter makes of a sweep."""
    return FILTERS[f"laser_filters/{kind}"](**values).apply(given, lambda frame: T, {})


def test_ranges_outside_the_limits_are_replaced() -> None:
    given = sweep([0.2, 0.3, 1.0, 3.0, math.inf])
    got = filtered("LaserScanRangeFilter", given, lower_threshold=0.3, upper_threshold=3.0)
    np.testing.assert_array_equal(got.ranges, [NAN, NAN, 1.0, NAN, NAN])
    values = {"lower_replacement_value": -math.inf, "upper_replacement_value": 9.0}
    got = filtered(
        "LaserScanRangeFilter", sweep([0.05, 2, 11]), use_message_range_limits=True, **values
    )
    np.testing.assert_array_equal(got.ranges, [-math.inf, 2.0, 9.0])


def test_angular_bounds_cut_the_scan() -> None:
    given = sweep([1, 2, 3, 4, 5], degrees=10, intensities=[1, 2, 3, 4, 5])
    bounds = {"lower_angle": -0.1, "upper_angle": 0.2}
    got = filtered("LaserScanAngularBoundsFilter", given, **bounds)
    np.testing.assert_array_equal(got.ranges, [3.0, 4.0])
    np.testing.assert_array_equal(got.intensities, [3.0, 4.0])
    assert got.angle_min == pytest.approx(0.0)
    assert got.first == 2
    got = filtered("LaserScanAngularBoundsFilterInPlace", given, **bounds)
    np.testing.assert_array_equal(got.ranges, [1.0, 2.0, 11.0, 11.0, 5.0])
    np.testing.assert_array_equal(got.intensities, [1.0, 2.0, 0.0, 0.0, 5.0])
    got = filtered("LaserScanAngularBoundsFilterInPlace", given, replace_with_nan=True, **bounds)
    np.testing.assert_array_equal(got.ranges, [1.0, 2.0, NAN, NAN, 5.0])


def test_points_in_a_box_about_the_robot_are_removed() -> None:
    given = sweep([1.0, 1.0, 1.0], degrees=90)
    ahead = Pose3((0.5, 0.0, 0.2))  # the laser, on the robot
    box = {"min_x": 1.4, "max_x": 1.6, "min_y": -0.1, "max_y": 0.1, "min_z": 0.1, "max_z": 0.3}
    got = filtered("LaserScanBoxFilter", given, ahead, **box)
    np.testing.assert_array_equal(got.ranges, [1.0, NAN, 1.0])
    got = filtered("LaserScanBoxFilter", given, ahead, invert=True, **box)
    np.testing.assert_array_equal(got.ranges, [NAN, 1.0, NAN])
    got = filtered("LaserScanBoxFilter", given, Pose3((0.5, 0.0, 1.0)), **box)
    np.testing.assert_array_equal(got.ranges, [1.0, 1.0, 1.0])


def test_points_in_a_polygon_or_the_footprint_are_removed() -> None:
    given = sweep([1.0, 1.0, 1.0, 0.2], degrees=90)
    triangle = "[[0.0, 0.3], [0.8, 0.8], [0.8, -0.8], [0.0, -0.3]]"
    got = filtered("LaserScanPolygonFilter", given, polygon=triangle)
    np.testing.assert_array_equal(got.ranges, [1.0, NAN, NAN, 0.2])
    square = "[[-0.05, 0.1], [0.05, 0.1], [0.05, -0.1], [-0.05, -0.1]]"
    for padding, last in ((0.0, 0.2), (0.1, NAN)):
        padded = {"polygon": square, "polygon_padding": padding}
        got = filtered("StaticLaserScanPolygonFilter", given, **padded)
        np.testing.assert_array_equal(got.ranges, [1.0, 1.0, 1.0, last])
    got = filtered("LaserScanFootprintFilter", given, inscribed_radius=0.3)
    np.testing.assert_array_equal(got.ranges, [1.0, 1.0, 1.0, 11.0])


def test_a_polygon_of_another_form_is_refused() -> None:
    with pytest.raises(ConfigError, match="'polygon' is '0, 1, 2'; valid"):
        filtered("LaserScanPolygonFilter", sweep([1.0]), polygon="0, 1, 2")


def test_a_sector_is_cleared_inside_or_outside() -> None:
    given = sweep([1.0, 1.0, 3.0], degrees=10)
    sector = {"angle_min": -0.05, "angle_max": 0.3, "range_min": 0.5, "range_max": 2.0}
    got = filtered("LaserScanSectorFilter", given, **sector)
    np.testing.assert_array_equal(got.ranges, [1.0, 11.0, 3.0])
    got = filtered("LaserScanSectorFilter", given, clear_inside=False, **sector)
    np.testing.assert_array_equal(got.ranges, [11.0, 1.0, 11.0])
    got = filtered("LaserScanSectorFilter", given, clear_inside=False, invert=True, **sector)
    np.testing.assert_array_equal(got.ranges, [11.0, 1.0, 11.0])


@pytest.mark.parametrize(
    ("angle_min", "angle_max", "expected"),
    [
        (-math.pi, math.pi, [11.0, 11.0, 3.0]),  # a whole turn
        (0.1, -0.1, [11.0, 1.0, 3.0]),  # over the back
    ],
)
def test_a_sector_may_be_a_whole_turn_or_reach_over_the_back(
    angle_min: float, angle_max: float, expected: list[float]
) -> None:
    given = replace(sweep([1.0, 1.0, 3.0], degrees=10), intensities=np.ones(3))
    sector = {"angle_min": angle_min, "angle_max": angle_max, "range_max": 2.0}
    got = filtered("LaserScanSectorFilter", given, **sector)
    np.testing.assert_array_equal(got.ranges, expected)
    np.testing.assert_array_equal(got.intensities, np.array(expected) < 11.0)


def test_veiling_points_between_an_edge_and_the_wall_are_removed() -> None:
    edge = [1.0] * 5 + [1.7, 2.4] + [3.0] * 5
    got = filtered("ScanShadowsFilter", sweep(edge), window=1, neighbors=0)
    np.testing.assert_array_equal(got.ranges, edge)  # no farther neighbour is taken with it
    got = filtered("ScanShadowsFilter", sweep(edge), window=1, neighbors=1)
    assert np.flatnonzero(np.isnan(got.ranges)).tolist() == [5, 6, 7]
    values = {"window": 1, "neighbors": 1, "remove_shadow_start_point": True}
    got = filtered("ScanShadowsFilter", sweep(edge), **values)
    assert np.flatnonzero(np.isnan(got.ranges)).tolist() == [4, 5, 6, 7]


def test_speckles_are_removed_that_stand_alone() -> None:
    given = sweep([1.0, 1.01, 0.4, 1.02, 1.03, 5.0])
    got = filtered("LaserScanSpeckleFilter", given)
    np.testing.assert_array_equal(got.ranges, [1.0, 1.01, NAN, 1.02, 1.03, 5.0])
    given = sweep([1.0, 1.0, 1.0, 1.0, 0.4, 0.7, 0.2, 1.0, 1.0, 1.0, 1.0])
    got = filtered("LaserScanSpeckleFilter", given, filter_type=1)  # 4 is in the window of 3
    assert np.flatnonzero(np.isnan(got.ranges)).tolist() == [5, 6]


def test_gaps_are_filled_by_the_mean_of_both_sides() -> None:
    got = filtered("InterpolationFilter", sweep([2.0, 11.0, 0.05, 4.0, math.inf]))
    np.testing.assert_allclose(got.ranges, [2.0, 3.0, 3.0, 4.0, (4.0 + 9.99) / 2.0])


def test_weak_returns_are_removed() -> None:
    given = sweep([1.0, 2.0, 3.0], intensities=[10, 9000, 200000])
    got = filtered("LaserScanIntensityFilter", given, filter_override_intensity=True)
    np.testing.assert_array_equal(got.ranges, [NAN, 2.0, NAN])
    np.testing.assert_array_equal(got.intensities, [0.0, 9000.0, 0.0])
    got = filtered("LaserScanIntensityFilter", given, invert=True)
    np.testing.assert_array_equal(got.ranges, [1.0, NAN, 3.0])
    assert filtered("LaserScanIntensityFilter", sweep([1.0])).ranges.tolist() == [1.0]


@pytest.mark.parametrize(("name", "expected"), [("Median", 2.0), ("Mean", 4.0)])
def test_averages_are_over_scans(name: str, expected: float) -> None:
    one = AverageFilter(type=f"filters/MultiChannel{name}FilterFloat", params=Observations(3))
    chain, memory = ArrayFilter(range_filter_chain=AverageChain(one)), dict[str, Any]()
    for value in (50.0, 1.0, 2.0, 9.0):
        got = chain.apply(sweep([value], intensities=[value]), lambda frame: ORIGIN, memory)
    assert got.ranges.tolist() == [expected]
    assert got.intensities.tolist() == [9.0]


NORTH = {"enu": (0.0, 0.4, -0.9), "nwu": (0.4, 0.0, -0.9), "ned": (0.4, 0.0, 0.9)}
"""The earth's field in each world frame, of the northern half."""


def turned(roll: float, pitch: float, yaw: float) -> Any:
    """Return a rotation into the world by its angles about x, y, z [rad]."""
    from scipy.spatial.transform import Rotation

    return Rotation.from_euler("xyz", (roll, pitch, yaw)).as_matrix()


@pytest.mark.parametrize("world", UP)
@pytest.mark.parametrize("yaw", [0.0, 1.2, -2.5])
def test_the_first_orientation_is_that_of_gravity_and_field(world: str, yaw: float) -> None:
    R = turned(0.2, -0.3, yaw)
    up, field = R.T @ UP[world], R.T @ NORTH[world]
    np.testing.assert_allclose(orientation(9.81 * up, field, world), R, atol=1e-12)
    without = orientation(up, None, world)
    np.testing.assert_allclose(without @ up, UP[world], atol=1e-12)
    assert np.linalg.det(without) == pytest.approx(1.0)


def test_the_gradient_is_that_of_the_squared_error() -> None:
    rng = np.random.default_rng(3)
    q, direction, measured = rng.normal(size=4), rng.normal(size=3), rng.normal(size=3)
    q /= np.linalg.norm(q)

    def body(p: Any) -> Any:  # the paper's form, without the unit length
        w, x, y, z = p
        R = np.array(
            [
                [0.5 - y * y - z * z, x * y - w * z, x * z + w * y],
                [x * y + w * z, 0.5 - x * x - z * z, y * z - w * x],
                [x * z - w * y, y * z + w * x, 0.5 - x * x - y * y],
            ]
        )
        return 2.0 * R.T @ direction

    step = 1e-6
    found = _gradient(q, direction, measured)
    for part in range(4):
        shift = np.eye(4)[part] * step
        errors = [0.5 * np.sum((body(q + sign * shift) - measured) ** 2) for sign in (1, -1)]
        assert (errors[0] - errors[1]) / (2.0 * step) == pytest.approx(found[part], abs=1e-6)


def test_a_turning_sensor_is_followed_and_a_wrong_start_forgotten() -> None:
    filter_ = MadgwickFilter("enu", gain=0.5)
    filter_.quaternion = quaternion_of(turned(0.5, 0.0, 0.0))  # it lies level
    for step in range(1, 2001):
        R = turned(0.0, 0.0, 0.5 * step * 0.01)
        up, field = R.T @ UP["enu"], R.T @ NORTH["enu"]
        filter_.update(0.01, np.array((0.0, 0.0, 0.5)), 9.81 * up, field)
    difference = rotation(filter_.quaternion).T @ R
    assert math.acos(min(1.0, (np.trace(difference) - 1.0) / 2.0)) < 0.02


def test_the_bias_of_the_gyro_is_learnt() -> None:
    filter_ = MadgwickFilter("enu", gain=0.1, zeta=0.05)
    filter_.start(np.array((0.0, 0.0, 9.81)), np.array(NORTH["enu"]))
    for _ in range(4000):
        rates, up = np.array((0.02, 0.0, 0.03)), np.array((0.0, 0.0, 9.81))
        filter_.update(0.01, rates, up, np.array(NORTH["enu"]))
    np.testing.assert_allclose(filter_.bias, (0.02, 0.0, 0.03), atol=0.01)


def test_free_fall_corrects_nothing() -> None:
    filter_ = MadgwickFilter()
    filter_.update(0.5, np.array((0.0, 0.0, 0.2)), np.zeros(3), None)
    assert filter_.quaternion[3] == pytest.approx(math.sin(0.05), abs=1e-3)
