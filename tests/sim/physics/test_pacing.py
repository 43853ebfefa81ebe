"""The achieved pace, by exact arithmetic."""

from __future__ import annotations

import pytest

from arjuna_sim.physics.pacing import PaceMeter


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
