"""Claims: a period neither drifts nor fires twice, whatever the steps of its clock."""

from __future__ import annotations

import pytest

from arjuna_core.timing import Periodic, other_clock


@pytest.mark.parametrize(("period", "tick"), [(0.1, 0.02), (0.05, 0.02), (0.1, 0.03), (1.0, 0.02)])
def test_over_a_minute_it_fires_once_a_period(period: float, tick: float) -> None:
    periodic = Periodic(period)
    steps = round(60.0 / tick)
    fired = sum(periodic.due(step * tick) for step in range(steps))
    assert fired == pytest.approx(60.0 / period, abs=1)


def test_it_fires_on_the_exact_multiple_despite_rounding() -> None:
    periodic = Periodic(0.1)
    assert [step for step in range(31) if periodic.due(step * 0.02)] == [0, 5, 10, 15, 20, 25, 30]


def test_the_phase_delays_the_first_occurrence() -> None:
    periodic = Periodic(1.0, phase=0.5)
    assert [periodic.due(now) for now in (0.0, 0.49, 0.5, 1.4, 1.5)] == [
        False,
        False,
        True,
        False,
        True,
    ]


def test_missed_occurrences_are_not_made_up_for() -> None:
    periodic = Periodic(0.1)
    assert periodic.due(0.0)
    assert periodic.due(5.0)
    assert not periodic.due(5.05)


def test_after_the_clock_is_set_back_it_fires_again_within_a_period() -> None:
    periodic = Periodic(0.5)
    assert periodic.due(100.0)
    assert any(periodic.due(now) for now in (3.0, 3.25, 3.5))


@pytest.mark.parametrize("start", [0.0, 1.7e9])
@pytest.mark.parametrize("period", [1e-7, 0.01, 0.1, 1.0])
def test_it_is_never_due_before_the_time_that_it_names(period: float, start: float) -> None:
    periodic, count = Periodic(period), 0
    for step in range(1000):
        now = start + step * 0.02
        early, before, count = now < periodic.next, count, int((now + 1e-9) // period) + 1
        assert periodic.due(now) is (count > before)
        assert not (early and count > before)


@pytest.mark.parametrize("period", [0.0, -1.0, float("nan")])
def test_a_period_that_is_not_positive_is_refused(period: float) -> None:
    with pytest.raises(ValueError, match="period must be positive"):
        Periodic(period)


@pytest.mark.parametrize(
    ("age", "who"), [(1.79e9, "start this node"), (-1.79e9, "start its sender"), (3600.0, "")]
)
def test_two_clocks_are_distinguished_from_a_delay(age: float, who: str) -> None:
    remedy = other_clock(age)
    assert who in remedy
    assert bool(remedy) is bool(who)
