"""Claims: a scan's valid beams and end points follow REP 117 and the sensor's pose."""

from __future__ import annotations

import math

import numpy as np
import pytest

from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2


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
