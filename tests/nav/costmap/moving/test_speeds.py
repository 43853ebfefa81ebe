"""The velocity of a track from its sightings."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from arjuna_nav.costmap.moving.speeds import KEPT, _slopes, _velocity

NOW = 50.0


def track(ages: list[float], *velocities: tuple[float, float]) -> NDArray[np.float64]:
    """Return sightings of so long ago of two points that move by so much."""
    seen = np.zeros((KEPT, 7))
    for row, age in zip(seen, ages, strict=False):
        row[0] = NOW - age
        row[1:5] = [7.0 - age * v for velocity in velocities for v in velocity]
    return seen


@pytest.mark.parametrize("count", [1, 5, 8, 11])
def test_slopes_are_those_of_straight_lines_through_what_was_seen_of_late(count: int) -> None:
    rng = np.random.default_rng(count)
    seen = rng.uniform(-1.0, 1.0, (KEPT, 7))
    seen[:, 0] = NOW - np.linspace(0.0, 1.2, KEPT)
    late = seen[: min(count, KEPT)]
    late = late[NOW - late[:, 0] <= 0.9]
    number, duration, slopes = _slopes(seen, count, NOW, 0.9)
    if len(late) == 1:
        assert (number, duration) == (0, 0.0)
        return
    assert number == len(late)
    assert duration == pytest.approx(np.ptp(late[:, 0]))
    lines = np.polyfit(late[:, 0] - NOW, late[:, 1:5], 1)
    np.testing.assert_allclose(slopes, lines[0], atol=1e-9)


TENTHS = [0.3, 0.2, 0.1, 0.0]


@pytest.mark.parametrize(
    ("ages", "first", "last", "expected"),
    [
        (TENTHS, (0.6, 0.1), (0.7, 0.2), (0.6, 0.1)),  # that of the slower point
        (TENTHS, (0.7, 0.2), (0.0, -0.6), (0.0, 0.0)),  # they part
        (TENTHS, (-0.7, -0.2), (-0.6, 0.1), (-0.6, 0.1)),
        (TENTHS, (0.51, 0.0), (0.51, 0.0), (0.51, 0.0)),
        (TENTHS, (0.49, 0.0), (0.8, 0.0), (0.0, 0.0)),  # it has not travelled 0.15 m
        (TENTHS[1:], (1.0, 0.0), (1.0, 0.0), (0.0, 0.0)),  # too few
        (TENTHS, (2.9, 0.0), (3.5, 0.0), (2.9, 0.0)),
        (TENTHS, (3.1, 0.0), (3.5, 0.0), (0.0, 0.0)),  # faster than anybody
        ([0.88, 0.6, 0.3, 0.0], (0.0, 0.21), (0.0, 0.21), (0.0, 0.21)),
        ([0.88, 0.6, 0.3, 0.0], (0.0, 0.19), (0.0, 0.3), (0.0, 0.0)),
        ([0.92, 0.6, 0.3, 0.0], (0.5, 0.0), (0.5, 0.0), (0.0, 0.0)),  # the first is too old
    ],
)
def test_both_outer_points_must_agree_that_a_thing_moves(
    ages: list[float],
    first: tuple[float, float],
    last: tuple[float, float],
    expected: tuple[float, float],
) -> None:
    found = _velocity(track(ages, first, last), len(ages), False, NOW)
    assert found == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize(
    ("ages", "first", "last", "expected"),
    [
        ([0.1, 0.0], (0.5, 0.1), (0.1, 0.5), (0.3, 0.3)),
        ([0.48, 0.0], (-0.21, 0.0), (-0.21, 0.0), (-0.21, 0.0)),
        ([0.48, 0.0], (-0.19, 0.0), (-0.19, 0.0), (0.0, 0.0)),
        ([0.48, 0.0], (3.1, 0.0), (3.1, 0.0), (0.0, 0.0)),
        ([0.52, 0.0], (0.5, 0.0), (0.5, 0.0), (0.0, 0.0)),  # the first is too old
    ],
)
def test_what_is_known_to_move_has_the_mean_of_both(
    ages: list[float],
    first: tuple[float, float],
    last: tuple[float, float],
    expected: tuple[float, float],
) -> None:
    found = _velocity(track(ages, first, last), len(ages), True, NOW)
    assert found == pytest.approx(expected, abs=1e-9)
