"""The contract of every smoother."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import scipy
from numpy.typing import NDArray
from scipy.linalg import solve_banded

from arjuna_core.errors import ConfigError
from arjuna_core.se2 import SE2
from arjuna_nav.planners import path as paths
from arjuna_nav.smoothers.constrained import ConstrainedSmoother
from arjuna_nav.smoothers.smoothers import (
    SMOOTHERS,
    SavitzkyGolayConfig,
    SavitzkyGolaySmoother,
    SimpleSmoother,
    SimpleSmootherConfig,
    Smoother,
    SmoothStatus,
)
from tests.nav.worlds import costmap_of, empty_grid, grid_of, polyline

CORNER = polyline([(1.0, 1.0), (3.0, 1.0), (3.0, 3.0)], 0.5)


def sharpest_turn(path: NDArray[np.float64]) -> float:
    headings = np.arctan2(*np.diff(path[:, :2], axis=0).T[::-1])
    return float(np.abs(np.diff(np.unwrap(headings))).max())


@pytest.fixture(params=SMOOTHERS.types)
def smoother(request: pytest.FixtureRequest) -> Smoother:
    cls = SMOOTHERS.resolve(request.param)
    bound = {"w_dist": 1e5} if cls is ConstrainedSmoother else {}  # by default nothing holds it
    made: Smoother = cls(cls.Config(**bound))
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
    assert result.path[-1, 2] == 0.3
    assert sharpest_turn(result.path) < 0.5 * sharpest_turn(stairs())
    assert paths.deviation(result.path, stairs()) < 0.05


@pytest.mark.parametrize("count", [1, 2, 3, 5])
def test_leaves_a_short_path_where_it_is(smoother: Smoother, count: int) -> None:
    result = smoother.smooth(stairs()[:count], costmap_of(empty_grid(4.0, 4.0)))
    assert result.status is SmoothStatus.SUCCEEDED
    assert np.abs(result.path[:, :2] - stairs()[:count, :2]).max() < 0.03


def test_does_not_smooth_into_an_obstacle() -> None:
    grid = grid_of(4.0, 4.0, (2.9, 1.05, 0.05, 0.05))  # in the corner's inside
    costmap = costmap_of(grid, radius=0.02, inflation_radius=0.02)
    result = SimpleSmoother(SimpleSmootherConfig(w_data=0.05)).smooth(CORNER, costmap)
    assert result.status is SmoothStatus.FAILED_TO_SMOOTH_PATH
    assert "as it was before" in result.message
    cells = costmap.frame.to_cells(result.path[:, :2])
    assert costmap.data[tuple(cells.T)].max() < 253


def test_refuses_what_is_no_path(smoother: Smoother) -> None:
    result = smoother.smooth(np.empty((0, 3)), costmap_of(empty_grid(1.0, 1.0)))
    assert result.status is SmoothStatus.INVALID_PATH
    assert result.message == "a path must be (N, 3) with N > 0, got (0, 3)"
    for shape in ((4, 2), (3,)):
        refused = smoother.smooth(np.zeros(shape), costmap_of(empty_grid(1.0, 1.0)))
        assert refused.status is SmoothStatus.INVALID_PATH


def noisy(count: int = 30) -> NDArray[np.float64]:
    """Return a path that does not turn back: it would be smoothed part by part."""
    y = np.random.default_rng(2).normal(2.0, 0.03, count)
    return np.column_stack((0.5 + 0.1 * np.arange(count), y, np.zeros(count)))


def fitted(points: NDArray[np.float64], size: int = 7, order: int = 2) -> NDArray[np.float64]:
    """Return the middles of polynomials; both ends are mirrored and stay."""
    k = size // 2
    before, after = 2.0 * points[0] - points[k:0:-1], 2.0 * points[-1] - points[-2 : -2 - k : -1]
    longer = np.vstack((before, points, after))
    result = scipy.signal.savgol_filter(longer, size, order, axis=0)[k:-k]
    result[[0, -1]] = points[[0, -1]]
    return np.asarray(result)


def settled(points: NDArray[np.float64], w_data: float, w_smooth: float) -> NDArray[np.float64]:
    """Return where the pulls to where a point was and to its neighbours' middle are even."""
    count = len(points)
    bands = np.zeros((3, count))
    bands[1] = w_data + 2.0 * w_smooth
    bands[0, 2:] = bands[2, :-2] = -w_smooth
    bands[1, [0, -1]] = 1.0  # the ends stay
    given = w_data * points
    given[[0, -1]] = points[[0, -1]]
    return np.asarray(solve_banded((1, 1), bands, given))


@pytest.mark.parametrize(("wanted", "again", "passes"), [(True, 2, 3), (True, 0, 1), (False, 5, 1)])
def test_each_pass_is_what_it_is_defined_to_be(wanted: bool, again: int, passes: int) -> None:
    costmap, quadratic, pulled = costmap_of(empty_grid(4.0, 4.0)), noisy()[:, :2], noisy()[:, :2]
    for _ in range(passes):
        quadratic, pulled = fitted(quadratic), settled(pulled, 0.15, 0.25)
    simple = SimpleSmootherConfig(
        w_data=0.15, w_smooth=0.25, do_refinement=wanted, refinement_num=again
    )
    for smoother, expected in (
        (SavitzkyGolaySmoother(SavitzkyGolayConfig(wanted, again)), quadratic),
        (SimpleSmoother(simple), pulled),
    ):
        result = smoother.smooth(noisy(), costmap)
        assert result.path[:, :2] == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize("weights", [(0.1, 0.5), (0.05, 0.9), (0.2, 3e4), (2.0, 1.0)])
def test_weights_of_any_size_settle(weights: tuple[float, float]) -> None:
    config = SimpleSmootherConfig(
        w_data=weights[0], w_smooth=weights[1], do_refinement=False, max_its=20_000
    )
    path = SimpleSmoother(config).smooth(noisy(), costmap_of(empty_grid(4.0, 4.0))).path
    assert path[:, :2] == pytest.approx(settled(noisy()[:, :2], *weights), abs=1e-4)


def test_it_ends_after_its_iterations_or_where_little_changes() -> None:
    costmap, settles = costmap_of(empty_grid(4.0, 4.0)), settled(noisy()[:, :2], 0.2, 0.3)

    def off(**values: float) -> float:
        config = SimpleSmootherConfig(do_refinement=False, **values)  # type: ignore[arg-type]
        path = SimpleSmoother(config).smooth(noisy(), costmap).path
        return float(np.abs(path[:, :2] - settles).max())

    assert off(max_its=1) > off(max_its=3) > off(max_its=10) > 1e-6 > off()
    assert off(tolerance=0.1) > 1e-4


@pytest.mark.parametrize("cls", [SimpleSmoother, SavitzkyGolaySmoother])
def test_a_path_is_smoothed_on_either_side_of_where_it_inverts(cls: Any) -> None:
    smoother = cls(cls.Config())
    ahead = stairs()
    back = ahead[-2::-1] + np.array([0.0, 0.02, 0.0]) * np.arange(1, len(ahead))[:, None]
    path = np.vstack((ahead, back))
    path[:, 2] = 0.4
    smoothed = smoother.smooth(path, costmap_of(empty_grid(5.0, 5.0))).path
    cusp = len(ahead) - 1
    assert smoothed[cusp, :2].tolist() == path[cusp, :2].tolist()
    alone = smoother.smooth(ahead, costmap_of(empty_grid(5.0, 5.0))).path
    np.testing.assert_array_equal(smoothed[: cusp + 1, :2], alone[:, :2])
    # forwards it looks along it, and in reverse as before
    assert np.abs(smoothed[:, 2] - 0.4).max() < 0.9


@pytest.mark.parametrize(("size", "order"), [(5, 2), (7, 3), (9, 4), (11, 1)])
def test_the_polynomials_have_the_window_and_the_order(size: int, order: int) -> None:
    config = SavitzkyGolayConfig(False, 0, window_size=size, poly_order=order)
    path = SavitzkyGolaySmoother(config).smooth(noisy(), costmap_of(empty_grid(4.0, 4.0))).path
    assert path[:, :2] == pytest.approx(fitted(noisy()[:, :2], size, order), abs=1e-9)


@pytest.mark.parametrize(("size", "order"), [(6, 2), (5, 5), (3, 4)])
def test_a_window_that_fits_no_polynomial_is_refused(size: int, order: int) -> None:
    with pytest.raises(ConfigError, match=f"'window_size' is {size}; valid: an odd number above"):
        SavitzkyGolayConfig(window_size=size, poly_order=order)


@pytest.mark.parametrize("cls", [SimpleSmoother, SavitzkyGolaySmoother])
def test_a_cusp_is_smoothed_like_a_corner_where_asked(cls: Any) -> None:
    ahead, back = polyline([(1.0, 1.0), (3.0, 2.0)], 0.0), polyline([(3.0, 2.0), (1.0, 3.0)], 0.0)
    back[:, 2] = back[0, 2] - np.pi
    given, cusp = np.vstack((ahead, back[1:])), len(ahead) - 1
    smoother = cls(cls.Config(enforce_path_inversion=False))
    path = smoother.smooth(given, costmap_of(empty_grid(4.0, 4.0))).path
    assert path[cusp, 0] < given[cusp, 0] - 0.01
    assert -1 not in paths.directions(path)


@pytest.mark.parametrize("angle", [-3.0, -1.2, 0.4, 2.0, 3.1])
@pytest.mark.parametrize("ahead", [1.0, -1.0])
def test_a_turn_on_the_spot_stays(smoother: Smoother, angle: float, ahead: float) -> None:
    """The path goes 2 m, turns on the spot and goes on, all ahead or all in reverse."""
    rng, pose, poses, turn = np.random.default_rng(7), SE2(4.0, 4.0, 1.0), [], range(41, 47)
    for k in range(80):
        noise = rng.normal(0.0, 0.003 * (k not in turn), 2)
        poses.append(pose.array() + np.append(noise, 0.0))
        pose = pose @ (SE2(0.0, 0.0, angle / 5.0) if k in turn[:-1] else SE2(0.05 * ahead))
    path = np.array(poses)
    result = smoother.smooth(path, costmap_of(empty_grid(8.0, 8.0)))
    assert result.status is SmoothStatus.SUCCEEDED
    np.testing.assert_array_equal(result.path[turn[:-1]], path[turn[:-1]])
    assert paths.directions(result.path) == [ahead]
    steps, yaws = np.diff(result.path[:, :2], axis=0), result.path[:-1, 2]
    along = ahead * (steps[:, 0] * np.cos(yaws) + steps[:, 1] * np.sin(yaws))
    assert (along >= 0.7 * np.hypot(*steps.T)).all()


@pytest.mark.parametrize("cls", [SimpleSmoother, SavitzkyGolaySmoother])
def test_one_heading_does_not_turn_a_path_round(cls: Any) -> None:
    path = stairs()
    path[0, 2] += np.pi  # where a robot stands that has yet to turn
    smoothed = cls(cls.Config()).smooth(path, costmap_of(empty_grid(4.0, 4.0))).path
    assert np.abs(smoothed[:, 2] - 0.4).max() < 0.5
