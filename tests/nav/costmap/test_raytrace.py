"""Rays on a grid and over its edge."""

from __future__ import annotations

import math

import numpy as np
import pytest

from arjuna_nav.costmap.raytrace import enter_scan


@pytest.mark.parametrize("seed", range(8))
def test_a_part_of_a_grid_is_cleared_and_marked_as_in_the_whole(seed: int) -> None:
    rng = np.random.default_rng(seed)
    whole = rng.integers(1, 255, (160, 180)).astype(np.uint8)
    part = whole[50:110, 60:140].copy()
    hits, hits_part = np.zeros(whole.shape, np.uint32), np.zeros(part.shape, np.uint32)
    sensor = np.array([rng.uniform(62.0, 138.0), rng.uniform(52.0, 108.0), rng.uniform(-3.0, 3.0)])
    ranges = rng.uniform(1.0, 48.0, 200)
    ranges[::17], ranges[::29] = math.inf, math.nan
    bearings = np.linspace(-math.pi, math.pi, 200)
    limits = np.array([2.0, 50.0, float(seed % 2), 40.0, 45.0, 0.0, 44.0])
    enter_scan(whole, hits, sensor, ranges, bearings, limits, True, True)
    moved = sensor - (60.0, 50.0, 0.0)
    enter_scan(part, hits_part, moved, ranges, bearings, limits, True, True)
    np.testing.assert_array_equal(part, whole[50:110, 60:140])
    np.testing.assert_array_equal(hits_part > 0, hits[50:110, 60:140] > 0)
    assert (part == 0).any()
