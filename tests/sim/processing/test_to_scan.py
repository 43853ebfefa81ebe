"""Clouds and depth images as scans, against distances worked out by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

from arjuna_sim.processing.to_scan import scan_of_depth, scan_of_points

QUARTER = 0.5 * math.pi


def test_the_nearest_point_of_each_sector_counts() -> None:
    points = np.array([[2, 0.2, 9], [1, 0.5, -9], [0.1, 3, 0], [-4, 3, 0], [0.7, -0.1, 0]], float)
    found = scan_of_points(points, 0.0, QUARTER, 2, math.inf)
    assert found == pytest.approx([math.hypot(1.0, 0.5), 5.0])
    found = scan_of_points(points, -2.0 * QUARTER, QUARTER, 4, 9.0)
    assert found == pytest.approx([9.0, math.hypot(0.7, 0.1), math.hypot(1.0, 0.5), 5.0])


@pytest.mark.parametrize("cx", [50.0, 30.0])
def test_a_wall_is_as_far_as_its_bearing_says(cx: float) -> None:
    depth, fx = np.full((7, 101), 2.0), 80.0
    ranges, right, increment = scan_of_depth(depth, fx, cx, 3, 0.1, 10.0)
    left = math.atan(cx / fx)
    assert right == pytest.approx(-math.atan((100.0 - cx) / fx))
    assert right + 100 * increment == pytest.approx(left)
    bearings = right + increment * np.arange(101)
    is_seen = np.isfinite(ranges)
    # Columns lie closer together towards the rims than beams do: some beams have two, some none.
    assert 75 <= is_seen.sum() < 101
    assert ranges[is_seen] == pytest.approx(2.0 / np.cos(bearings[is_seen]), rel=0.01)


def test_rows_in_the_middle_and_what_is_in_range_count() -> None:
    depth = np.full((8, 3), 5.0)
    depth[:, 1] = (0.5, 0.5, 4.0, 3.0, np.nan, 0.0, 0.5, 0.5)
    assert scan_of_depth(depth, 1e3, 1.0, 4, 0.1, 4.5)[0][1] == pytest.approx(3.0)
    assert scan_of_depth(depth, 1e3, 1.0, 4, 3.5, 4.5)[0][1] == pytest.approx(4.0)
    assert np.isnan(scan_of_depth(depth, 1e3, 1.0, 1, 0.1, 4.5)[0]).all()
    assert scan_of_depth(depth, 1e3, 1.0, 6, 0.1, 4.5)[0][1] == pytest.approx(0.5)
    assert scan_of_depth(depth, 1e3, 1.0, 100, 0.5, 5.5)[0][1] == pytest.approx(0.5)
