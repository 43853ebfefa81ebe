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


@pytest.mark.parametrize(
    ("periodic", "times", "fired"),
    [
        (Periodic(0.1), [0.02 * n for n in range(31)], [0.02 * n for n in range(0, 31, 5)]),
        (Periodic(1.0, phase=0.5), [0.0, 0.49, 0.5, 1.4, 1.5], [0.5, 1.5]),
        (Periodic(0.1), [0.0, 5.0, 5.05], [0.0, 5.0]),
        (Periodic(0.5), [100.0, 3.0, 3.25], [100.0, 3.0]),
    ],
    ids=["exact multiples", "a phase", "missed ones are not made up for", "a clock set back"],
)
def test_it_fires_at_times(periodic: Periodic, times: list[float], fired: list[float]) -> None:
    assert [now for now in times if periodic.due(now)] == fired


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
