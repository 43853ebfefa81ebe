"""The filters of laser_filters, on scans made by hand."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest

from arjuna_core.errors import ConfigError
from arjuna_core.pose3 import ORIGIN, Pose3
from arjuna_sim.processing.scan_averages import (
    ArrayFilter,
    AverageChain,
    AverageFilter,
    Observations,
)
from arjuna_sim.processing.scan_filters import FILTERS
from arjuna_sim.processing.sweep import Sweep

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
