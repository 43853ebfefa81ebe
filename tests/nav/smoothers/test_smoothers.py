"""What every smoother must do."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from arjuna_nav.planners import path as paths
from arjuna_nav.smoothers.base import Smoother, SmoothStatus
from arjuna_nav.smoothers.plugins import SMOOTHERS
from arjuna_nav.smoothers.simple import SimpleSmoother, SimpleSmootherConfig
from tests.nav.worlds import block, costmap_of, empty_grid, polyline

CORNER = polyline([(1.0, 1.0), (3.0, 1.0), (3.0, 3.0)], 0.5)


def sharpest_turn(path: NDArray[np.float64]) -> float:
    headings = np.arctan2(*np.diff(path[:, :2], axis=0).T[::-1])
    return float(np.abs(np.diff(np.unwrap(headings))).max())


@pytest.fixture(params=SMOOTHERS.types)
def smoother(request: pytest.FixtureRequest) -> Smoother:
    cls = SMOOTHERS.resolve(request.param)
    made: Smoother = cls(cls.Config())
    return made


def stairs() -> NDArray[np.float64]:
    """Return a path that goes as a grid's: a step along, a step across, at 27 degrees."""
    steps = np.tile([[0.05, 0.0], [0.05, 0.05]], (20, 1))
    points = np.vstack(([[1.0, 1.0]], 1.0 + np.cumsum(steps, axis=0)))
    return np.column_stack((points, np.full(len(points), 0.3)))


def test_takes_the_stairs_out_of_a_path(smoother: Smoother) -> None:
    result = smoother.smooth(stairs(), costmap_of(empty_grid(4.0, 4.0)))
    assert result.status is SmoothStatus.SUCCEEDED
    np.testing.assert_array_equal(result.path[[0, -1], :2], stairs()[[0, -1], :2])
    assert sharpest_turn(result.path) < 0.5 * sharpest_turn(stairs())
    assert paths.deviation(result.path, stairs()) < 0.05


@pytest.mark.parametrize("count", [1, 2, 3, 5])
def test_leaves_a_short_path_where_it_is(smoother: Smoother, count: int) -> None:
    result = smoother.smooth(stairs()[:count], costmap_of(empty_grid(4.0, 4.0)))
    assert result.status is SmoothStatus.SUCCEEDED
    assert np.abs(result.path[:, :2] - stairs()[:count, :2]).max() < 0.03


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


def test_refuses_what_is_no_path(smoother: Smoother) -> None:
    result = smoother.smooth(np.empty((0, 3)), costmap_of(empty_grid(1.0, 1.0)))
    assert result.status is SmoothStatus.INVALID_PATH
