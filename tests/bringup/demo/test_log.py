"""A demo's log: what it counts against the truth, and when."""

from __future__ import annotations

import pytest

from arjuna_core.se2 import SE2
from bringup.demo.log import RunLog

TICK, RATE = 0.02, 0.8


def _turning(error: float, period: int) -> RunLog:
    """Turn on the spot; the estimate is off by an error [rad] and comes each so many ticks."""
    log, stamp = RunLog(), 0.0
    for i in range(1, 101):
        now = i * TICK
        stamp = now if i % period == 0 else stamp
        estimate = SE2(0.0, 0.0, RATE * stamp + error) if stamp else None
        log.add(now, SE2(0.0, 0.0, RATE * now), estimate, (), True, stamp)
    return log


@pytest.mark.parametrize("period", [1, 5])
def test_an_estimate_is_compared_with_the_truth_of_its_own_time(period: int) -> None:
    _, heading = _turning(0.01, period).localization_rmse()
    assert heading == pytest.approx(0.01, abs=1e-9)


def test_an_estimate_without_a_stamp_is_of_now() -> None:
    log = RunLog()
    log.add(TICK, SE2(1.0, 0.0, 0.0), SE2(1.0, 0.3, 0.0), (), True)
    assert log.localization_rmse()[0] == pytest.approx(0.3)
