"""Figures of merit against shapes whose figures are known."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from arjuna_core.grid import GridFrame, OccupancyGrid
from arjuna_core.se2 import SE2
from bringup.demo.measures import (
    Report,
    Samples,
    distance_to_surfaces,
    explored_fraction,
    map_error,
    rmse,
    segments_from,
    summary,
)

SQUARE = np.array([[0, 0, 4, 0], [4, 0, 4, 4], [4, 4, 0, 4], [0, 4, 0, 0]], dtype=np.float64)


def grid(value: int) -> OccupancyGrid:
    frame = GridFrame(0.1, 60, 60, SE2(-1.0, -1.0, 0.0))
    return OccupancyGrid(frame, np.full(frame.shape, value, dtype=np.int8))


def test_distance_is_to_the_segment_not_its_line() -> None:
    points = np.array([[2.0, 1.0], [5.0, 5.0], [-3.0, 0.0]])
    expected = [1.0, np.sqrt(2.0), 3.0]
    np.testing.assert_allclose(distance_to_surfaces(points, SQUARE), expected)


def test_a_map_that_begins_elsewhere_is_measured_there() -> None:
    start = SE2(1.0, 2.0, np.pi / 2.0)
    seen = segments_from(start, SQUARE)
    np.testing.assert_allclose(seen[0], [-2.0, 1.0, -2.0, -3.0], atol=1e-12)
    here, there = np.array([[0.5, 0.5]]), start.apply(np.array([[0.5, 0.5]]))
    assert distance_to_surfaces(here, seen) == pytest.approx(distance_to_surfaces(there, SQUARE))


def test_map_error_is_the_mean_gap_of_occupied_cells() -> None:
    built = grid(0)
    row, column = built.frame.to_cell(2.0, 0.25)
    built.data[row, column] = 100
    assert map_error(built, SQUARE) == pytest.approx(0.25)


def test_map_error_refuses_an_empty_map() -> None:
    with pytest.raises(ValueError, match="no occupied cell"):
        map_error(grid(0), SQUARE)


def test_explored_fraction_counts_only_reachable_free_area() -> None:
    start = SE2(2.0, 2.0, 0.0)
    assert explored_fraction(grid(0), SQUARE, start) == 1.0
    assert explored_fraction(grid(-1), SQUARE, start) == 0.0
    half = grid(0)
    half.data[:, half.frame.to_cell(2.0, 0.0)[1] :] = -1
    assert explored_fraction(half, SQUARE, start) == pytest.approx(0.5, abs=0.02)


def test_rmse_wraps_headings() -> None:
    position, heading = rmse(np.array([[3.0, 4.0, 3.1]]), np.array([[0.0, 0.0, -3.1]]))
    assert position == pytest.approx(5.0)
    assert heading == pytest.approx(2.0 * np.pi - 6.2)


TICK, RATE = 0.02, 0.8


def _turning(error: float, period: int) -> Samples:
    """Turn on the spot; the estimate is off by an error [rad] and comes each so many ticks."""
    samples, stamp = Samples(), 0.0
    for i in range(1, 101):
        now = i * TICK
        stamp = now if i % period == 0 else stamp
        estimate = SE2(0.0, 0.0, RATE * stamp + error) if stamp else None
        samples.add(now, SE2(0.0, 0.0, RATE * now), estimate, (), True, stamp)
    return samples


@pytest.mark.parametrize("period", [1, 5])
def test_an_estimate_is_compared_with_the_truth_of_its_own_time(period: int) -> None:
    _, heading = _turning(0.01, period).localization_rmse()
    assert heading == pytest.approx(0.01, abs=1e-9)


def test_a_touch_is_noted_once_with_its_name_and_place() -> None:
    samples = Samples()
    for i, contacts in enumerate(((), ("b", "a"), ("a",), (), ("c",))):
        samples.add(i * TICK, SE2(float(i), 2.0, 0.0), None, contacts, False)
    assert samples.touched == [("a, b", 1.0, 2.0), ("c", 4.0, 2.0)]


def test_the_area_of_a_start_outside_the_walls_is_not_all_there_is() -> None:
    assert 0.0 <= explored_fraction(grid(0), SQUARE, SE2(-3.0, 2.0, 0.0)) < 1.0


def test_an_estimate_without_a_stamp_is_of_now() -> None:
    samples = Samples()
    samples.add(TICK, SE2(1.0, 0.0, 0.0), SE2(1.0, 0.3, 0.0), (), True)
    assert samples.localization_rmse()[0] == pytest.approx(0.3)


@pytest.mark.parametrize(("off", "lost"), [(0.2, False), (0.3, True)])
def test_a_robot_that_believes_itself_elsewhere_has_not_succeeded(off: float, lost: bool) -> None:
    samples = Samples()
    for i in range(1, 4):
        samples.add(i * TICK, SE2(2.0, 2.0), SE2(2.0, 2.0 + off), (), True)
    facts = {"seed": 5, "exploration_done": True, "kidnap_recovered": None}
    report = Report.of(samples, grid(0), SQUARE, 1.0, kidnap_recovery_s=None, **facts)
    assert report.success is not lost
    assert ("lost" in summary(Path(), report)) is lost
