"""The pace that is kept and the one that is achieved, by exact arithmetic."""

from __future__ import annotations

import pytest

from arjuna_sim.physics.pacing import PaceMeter, Pacer


class Clock:
    """A wall clock that is set by hand."""

    now = 100.0

    def __call__(self) -> float:
        return self.now


def test_it_waits_until_real_time_has_come_as_far() -> None:
    clock = Clock()
    pacer = Pacer(2.0, clock)
    assert pacer.wait(30.0) == 0.0
    assert pacer.wait(31.0) == 0.5
    clock.now = 100.4
    assert pacer.wait(31.0) == pytest.approx(0.1)
    clock.now = 100.9  # late, by less than is caught up with
    assert pacer.wait(31.0) == 0.0
    assert pacer.wait(32.0) == pytest.approx(0.1)


def test_what_is_too_late_is_not_caught_up_with() -> None:
    clock = Clock()
    pacer = Pacer(1.0, clock)
    pacer.wait(0.0)
    clock.now = 101.6
    assert pacer.wait(1.0) == 0.0
    assert pacer.wait(1.5) == pytest.approx(0.5)
    pacer.restart()
    assert pacer.wait(9.0) == 0.0
    assert pacer.wait(9.25) == 0.25


def test_a_factor_of_0_waits_for_nothing_and_below_there_is_none() -> None:
    pacer = Pacer(0.0, Clock())
    assert [pacer.wait(now) for now in (0.0, 50.0)] == [0.0, 0.0]
    with pytest.raises(ValueError, match="at least 0, got -1"):
        Pacer(-1.0, Clock())


def test_factor_is_read_once_a_period_of_real_time() -> None:
    meter = PaceMeter(1.0)
    readings = [meter.update(10.0 + i * 0.25, i * 0.5) for i in range(9)]
    assert readings == [None, None, None, None, 2.0, None, None, None, 2.0]
    assert meter.summary == "real-time factor 2.00: 4.0 s in 2.0 s"


def test_pauses_do_not_count() -> None:
    meter = PaceMeter(1.0)
    meter.update(0.0, 0.0)
    assert meter.update(1.0, 1.0) == 1.0
    meter.pause()
    assert meter.update(100.0, 1.0) is None
    assert meter.update(101.0, 1.5) == pytest.approx(0.5)
    assert meter.summary == "real-time factor 0.75: 1.5 s in 2.0 s"


def test_nothing_is_said_of_nothing() -> None:
    assert PaceMeter().summary is None
