"""The constrained smoother: the least of its squares, bends that can be driven, and few costs."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from arjuna_core.errors import ConfigError
from arjuna_core.grid import GridFrame
from arjuna_core.se2 import SE2
from arjuna_nav.costmap import Costmap
from arjuna_nav.planners import path as paths
from arjuna_nav.smoothers.constrained import (
    ConstrainedSmoother,
    ConstrainedSmootherConfig,
    costs_at,
)
from arjuna_nav.smoothers.smoothers import SimpleSmoother, SimpleSmootherConfig, SmoothStatus
from tests.nav.worlds import costmap_of, empty_grid, grid_of, polyline

Path = NDArray[np.float64]
EMPTY = costmap_of(empty_grid(8.0, 6.0))
RIGHT_ANGLE = polyline([(1.0, 1.0), (4.0, 1.0), (4.0, 4.0)], np.pi / 2)


def smoothed(path: Path, costmap: Costmap = EMPTY, **values: Any) -> Path:
    result = ConstrainedSmoother(ConstrainedSmootherConfig(**values)).smooth(path, costmap)
    assert result.status is SmoothStatus.SUCCEEDED
    return result.path


def sharpest(path: Path) -> float:
    """Return the greatest curvature of a path's points [1/m]."""
    a, b = np.diff(path[:-1, :2], axis=0), np.diff(path[1:, :2], axis=0)
    sides = [np.hypot(*side.T) for side in (a, b, a + b)]
    return float(np.abs(2.0 * (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) / np.prod(sides, 0)).max())


def cusped() -> Path:
    """Return a path that goes ahead to (3, 1.6) and back from there, looking along itself."""
    ahead, back = polyline([(1.0, 1.0), (3.0, 1.6)], 0.29), polyline([(3.0, 1.6), (1.0, 2.2)], 0.0)
    back[:, 2] = back[0, 2] - np.pi
    return np.vstack((ahead[:-1], back))


def squares(points: Path, given: Path, w_dist: float, w_smooth: float) -> float:
    """Return the sum of squares of evenly spaced points without bends or costs, as published."""
    second = points[2:] - 2.0 * points[1:-1] + points[:-2]
    return float(w_smooth * (second**2).sum() + w_dist * ((points - given) ** 2).sum())


def test_it_is_the_least_of_the_published_squares() -> None:
    rng, given = np.random.default_rng(4), RIGHT_ANGLE[:60].copy()
    given[1:-1, :2] += rng.normal(0.0, 1e-5, (58, 2))  # so that steps are not all even
    weights: dict[str, Any] = {"w_dist": 2.0, "w_smooth": 1e3}
    path = smoothed(given, w_curve=0.0, w_cost=0.0, **weights)
    least = squares(path[:, :2], given[:, :2], **weights)
    for scale in (1e-2, 3e-3, 1e-3):
        other = path[:, :2].copy()
        other[2:-2] += rng.normal(0.0, scale, (56, 2))
        assert squares(other, given[:, :2], **weights) > least


@pytest.mark.parametrize(
    ("radius", "w_curve", "w_smooth"), [(0.3, 1e4, 1e2), (0.4, 1e3, 1e2), (0.8, 1e2, 1e4)]
)
def test_a_corner_becomes_a_bend_that_the_robot_can_drive(
    radius: float, w_curve: float, w_smooth: float
) -> None:
    loose: dict[str, Any] = {"w_smooth": w_smooth, "w_dist": 1.0, "w_cost": 0.0}
    loose["minimum_turning_radius"] = radius
    assert sharpest(smoothed(RIGHT_ANGLE, w_curve=0.0, **loose)) > 1.5 / radius
    bent = smoothed(RIGHT_ANGLE, w_curve=w_curve, **loose)
    assert sharpest(bent) < 1.06 / radius
    assert paths.directions(bent) == [1]


@pytest.mark.parametrize(("radius", "w_curve"), [(0.8, 1e4), (1.5, 1e5)])
def test_it_does_not_fold_a_path_to_bend_less(radius: float, w_curve: float) -> None:
    config = ConstrainedSmootherConfig(
        minimum_turning_radius=radius, w_curve=w_curve, w_smooth=100.0, w_dist=1.0
    )
    result = ConstrainedSmoother(config).smooth(RIGHT_ANGLE, EMPTY)
    assert paths.directions(result.path) == [1]
    assert result.status is SmoothStatus.FAILED_TO_SMOOTH_PATH
    assert "would drive it to and fro" in result.message


def test_it_keeps_off_of_costs_where_the_simple_one_does_not() -> None:
    costmap = costmap_of(grid_of(8.0, 6.0, (3.5, 2.15, 0.5, 0.5)), radius=0.2, inflation_radius=1.0)
    given = polyline([(1.0, 3.0), (3.5, 2.95), (6.0, 3.0)], 0.0)

    def cost(path: Path) -> float:
        return float(costs_at(path[:, :2], costmap)[0].max())

    simple = SimpleSmoother(SimpleSmootherConfig()).smooth(given, costmap).path
    path = smoothed(given, costmap)
    assert cost(path) < 0.3 * cost(simple)
    assert cost(smoothed(given, costmap, w_cost=0.0)) > 0.8 * cost(simple)
    assert sharpest(path) < 1.0
    behind = smoothed(given, costmap, cost_check_points=(0.0, -0.3, 1.0))  # its right side's costs
    assert behind[len(given) // 2, 1] > path[len(given) // 2, 1] + 0.1


def test_where_it_would_touch_an_obstacle_the_path_stays() -> None:
    grid = grid_of(8.0, 6.0, (3.0, 1.5, 0.3, 0.3))  # within the corner
    costmap = costmap_of(grid, radius=0.05, inflation_radius=0.05)
    config = ConstrainedSmootherConfig(w_cost=0.0)
    result = ConstrainedSmoother(config).smooth(RIGHT_ANGLE, costmap)
    assert result.status is SmoothStatus.FAILED_TO_SMOOTH_PATH
    assert (result.path == RIGHT_ANGLE).all()


def test_a_cusp_stays_one_and_is_driven_in_reverse_after_it() -> None:
    path = smoothed(cusped(), w_cost=0.0, w_dist=10.0)
    assert paths.directions(path) == [1, -1]
    assert np.abs(path[:, 2]).max() < 0.6
    assert sharpest(path[:30]) < 2.6
    blind = smoothed(cusped(), w_cost=0.0, w_dist=10.0, reversing_enabled=False)
    assert np.abs(blind[-5:-1, 2]).min() > 2.0, "it turns about there"


def test_costs_weigh_more_about_a_cusp() -> None:
    costmap = costmap_of(grid_of(8.0, 6.0, (3.3, 1.4, 0.4, 0.4)), radius=0.1, inflation_radius=1.0)

    def tip(multiplier: float, length: float) -> float:
        values = {"w_cost_cusp_multiplier": multiplier, "cusp_zone_length": length, "w_dist": 500.0}
        return float(smoothed(cusped(), costmap, **values)[:, 0].max())

    assert tip(20.0, 2.5) < tip(1.0, 2.5) - 0.02
    assert tip(20.0, 0.0) > tip(20.0, 2.5)


@pytest.mark.parametrize(("up", "count"), [(0, 21), (1, 61), (2, 121)])
def test_every_third_pose_is_moved_and_what_is_between_lies_on_curves(up: int, count: int) -> None:
    given = polyline([(1.0, 1.0), (4.0, 1.0)], 0.0)
    given[1:-1, 1] += 0.02 * np.sin(np.arange(59))
    values: dict[str, Any] = {"path_downsampling_factor": 3, "path_upsampling_factor": up}
    path = smoothed(given, keep_start_orientation=False, keep_goal_orientation=False, **values)
    assert len(path) == count
    assert np.abs(path[:, 1:] - [1.0, 0.0]).max() < 0.01
    assert (np.diff(path[:, 0]) > 0.0).all()


def test_the_ends_headings_stay_where_asked() -> None:
    given = RIGHT_ANGLE.copy()
    given[0, 2], given[-1, 2] = 0.3, 1.2
    for keep, ends in ((True, (0.3, 1.2)), (False, (0.4, 1.17))):
        path = smoothed(given, keep_start_orientation=keep, keep_goal_orientation=keep, w_dist=1e3)
        assert path[[0, -1], 2] == pytest.approx(ends, abs=0.0 if keep else 0.5)
        assert (path[[1, -2], :2] == given[[1, -2], :2]).all() == keep


def test_turns_on_the_spot_at_the_ends_leave_the_first_and_the_last_heading() -> None:
    turning = np.vstack((RIGHT_ANGLE[:1], RIGHT_ANGLE, RIGHT_ANGLE[-1:]))
    turning[0, 2], turning[-1, 2] = 2.0, -1.0
    path = smoothed(turning, w_dist=1e3)
    assert path[[0, -1], 2].tolist() == [2.0, -1.0]
    assert np.isfinite(path).all()


def test_costs_between_cells_and_their_slopes_in_a_turned_grid() -> None:
    frame = GridFrame(0.1, 30, 20, SE2(1.0, 2.0, 0.7))
    columns = np.arange(30)[None, :] * 5
    costmap = Costmap(frame, (columns + np.arange(20)[:, None] * 3).astype(np.uint8))
    points = frame.origin.apply(np.array([[1.23, 0.77], [2.01, 1.5]]))
    costs, slopes = costs_at(points, costmap)
    assert costs == pytest.approx([11.8 * 5 + 7.2 * 3, 19.6 * 5 + 14.5 * 3])
    for k, step in enumerate(np.eye(2) * 1e-4):
        further = costs_at(points + step, costmap)[0]
        assert (further - costs) / 1e-4 == pytest.approx(slopes[:, k], rel=1e-6)


@pytest.mark.parametrize("points", [(0.1,), (0.1, 0.0), (0.1, 0.0, 0.0), (0.0, 0.0, 1.0, 2.0)])
def test_check_points_are_triples_with_weights(points: tuple[float, ...]) -> None:
    with pytest.raises(ConfigError, match=r"'cost_check_points' is .*; valid: x, y, weight"):
        ConstrainedSmootherConfig(cost_check_points=points)
