"""The simple smoother."""

from __future__ import annotations

import numpy as np

from arjuna_nav.planners import path as paths
from arjuna_nav.smoothers.base import SmoothStatus
from arjuna_nav.smoothers.simple import SimpleSmoother, SimpleSmootherConfig
from tests.nav.worlds import block, costmap_of, empty_grid, polyline

CORNER = polyline([(1.0, 1.0), (3.0, 1.0), (3.0, 3.0)], 0.5)


def sharpest_turn(path: np.ndarray) -> float:
    headings = np.arctan2(*np.diff(path[:, :2], axis=0).T[::-1])
    return float(np.abs(np.diff(np.unwrap(headings))).max())


def test_rounds_corners_and_keeps_both_ends() -> None:
    result = SimpleSmoother(SimpleSmootherConfig()).smooth(CORNER, costmap_of(empty_grid(4.0, 4.0)))
    assert result.status is SmoothStatus.SUCCEEDED
    np.testing.assert_array_equal(result.path[[0, -1], :2], CORNER[[0, -1], :2])
    assert result.path[-1, 2] == 0.5
    assert sharpest_turn(result.path) < 0.5 * sharpest_turn(CORNER)
    assert paths.deviation(result.path, CORNER) < 0.1


def test_does_not_smooth_into_an_obstacle() -> None:
    grid = empty_grid(4.0, 4.0)
    block(grid, 2.9, 1.05, 0.05, 0.05)  # in the corner's inside
    costmap = costmap_of(grid, radius=0.02, inflation_radius=0.02)
    result = SimpleSmoother(SimpleSmootherConfig(w_data=0.05)).smooth(CORNER, costmap)
    assert result.status is SmoothStatus.FAILED_TO_SMOOTH_PATH
    assert "as it was before" in result.message
    cells = costmap.frame.to_cells(result.path[:, :2])
    assert costmap.data[tuple(cells.T)].max() < 253


def test_refuses_what_is_no_path() -> None:
    smoother = SimpleSmoother(SimpleSmootherConfig())
    result = smoother.smooth(np.empty((0, 3)), costmap_of(empty_grid(1.0, 1.0)))
    assert result.status is SmoothStatus.INVALID_PATH
