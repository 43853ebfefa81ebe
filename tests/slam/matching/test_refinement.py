"""Claims: distances and their gradients are those of the field; the solver solves."""

from __future__ import annotations

import numpy as np
import pytest

from arjuna_slam.matching.refinement import sample_distance, solve
from arjuna_slam.matching.scan_matcher import invert

RESOLUTION = 0.05


@pytest.mark.parametrize("seed", range(5))
def test_the_gradient_of_the_distance_is_that_of_finite_differences(seed: int) -> None:
    rng = np.random.default_rng(seed)
    distances = rng.random((6, 8)).astype(np.float32)
    column, row = rng.integers(1, 5, 2) + rng.uniform(0.6, 1.3, 2)  # inside four cells' centres
    step = 1e-3
    _, nx, ny, trust = sample_distance(distances, column, row, RESOLUTION)
    assert trust == 1.0

    def at(dx: float, dy: float) -> float:
        return float(sample_distance(distances, column + dx, row + dy, RESOLUTION)[0])

    if all(step < part % 1.0 < 1.0 - step for part in (column - 0.5, row - 0.5)):
        slope = 2.0 * step * RESOLUTION
        assert nx == pytest.approx((at(step, 0.0) - at(-step, 0.0)) / slope, rel=1e-4)
        assert ny == pytest.approx((at(0.0, step) - at(0.0, -step)) / slope, rel=1e-4)


def test_a_cell_centre_has_its_own_distance_and_points_off_the_field_none() -> None:
    distances = np.arange(12, dtype=np.float32).reshape(3, 4)
    assert sample_distance(distances, 2.5, 1.5, RESOLUTION)[0] == distances[1, 2]
    assert sample_distance(distances, -0.1, 1.5, RESOLUTION)[3] == 0.0
    assert sample_distance(distances, 3.6, 1.5, RESOLUTION)[3] == 0.0


@pytest.mark.parametrize("seed", range(5))
def test_solving_and_inverting_agree_with_numpy(seed: int) -> None:
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(3, 3))
    matrix, right = root @ root.T + 0.1 * np.eye(3), rng.normal(size=3)
    np.testing.assert_allclose(solve(matrix, right), np.linalg.solve(matrix, right), rtol=1e-9)
    np.testing.assert_allclose(invert(matrix), np.linalg.inv(matrix), rtol=1e-9)
