"""Commands of slow senders hold until the next; those of quick ones that fall silent end soon."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import pytest

from arjuna_sim.devices.driving.controller import CommandHold, HoldLimits

_TICK = 0.02
_LIMITS = HoldLimits()


def _sent(period: float, seconds: float, late: float, rng: np.random.Generator) -> list[float]:
    """Return when a sender's commands come, each late by up to a share of its period [s]."""
    first = float(rng.uniform(0.0, period))
    times = np.arange(first, seconds, period)
    return [float(t) for t in times + rng.uniform(0.0, late * period, len(times))]


def _at_rest(times: list[float], limits: HoldLimits, braking: float) -> Iterator[float]:
    """Yield the ticks after the first command at which none holds, up to the last command [s]."""
    hold, waiting = CommandHold(), sorted(times)
    for tick in range(round(waiting[-1] / _TICK)):
        now, came = tick * _TICK, False
        while waiting and waiting[0] <= now:
            waiting.pop(0)
            came = True
        if came:
            hold.take(now, limits)
        if now > min(times) + _TICK and now >= hold.ends(braking):
            yield now


@pytest.mark.parametrize("seed", range(40))
def test_any_sender_down_to_half_a_hertz_drives_evenly(seed: int) -> None:
    """Also late by a tenth of its period, and for robots that brake for long."""
    rng = np.random.default_rng(seed)
    period = float(rng.uniform(0.02, 1.1 if seed % 2 else 0.5))
    times = _sent(period, 30.0, 0.1, rng)
    assert list(_at_rest(times, _LIMITS, braking=float(rng.uniform(0.0, 2.0)))) == []


@pytest.mark.parametrize("period", [1.5, 2.0])
def test_slower_sender_drives_evenly_from_its_second_command_on(period: float) -> None:
    times = _sent(period, 30.0, 0.05, np.random.default_rng(1))
    assert all(now < times[1] + _TICK for now in _at_rest(times, _LIMITS, 0.1))


@pytest.mark.parametrize("seed", range(20))
def test_several_slow_senders_together_drive_evenly(seed: int) -> None:
    """Their gaps are short and long by turns, whoever began first; that shows after three."""
    rng = np.random.default_rng(seed)
    times = [t for _ in range(2 + seed % 2) for t in _sent(1.0, 20.0, 0.02, rng)]
    assert all(now < min(times) + 3.1 for now in _at_rest(times, _LIMITS, 0.2))


@pytest.mark.parametrize("seed", range(40))
def test_quick_sender_that_falls_silent_ends_after_the_least_time(seed: int) -> None:
    """Whatever came before it, from its second command on, and where two of them are late."""
    rng = np.random.default_rng(seed)
    hold, now = CommandHold(), 0.0
    if seed % 2:
        now = 10.0
        for t in _sent(float(rng.uniform(0.3, 2.0)), 10.0, 0.1, rng):
            hold.take(t, _LIMITS)
        now += float(rng.uniform(3.0, 5.0))
    count = 2 + seed
    late = rng.integers(3, count, 2).tolist() if seed > 2 else []
    for k in range(count):
        now += float(rng.uniform(0.4, 0.95) if k in late else rng.uniform(0.02, 0.3))
        hold.take(now, _LIMITS)
    assert hold.ends(0.0) == pytest.approx(now + 0.5)
    assert (
        now + 0.3 - 1e-9 <= hold.ends(9.0) <= now + 0.5
    )  # and brakes ahead, where that takes time


@pytest.mark.parametrize("silence", [0.6, 1.2, 1.6, 2.5, 9.0])
def test_slow_sender_takes_over_from_a_quick_one(silence: float) -> None:
    """At once after 1.5 s of silence, else once three of its gaps are known."""
    quick = [0.05 * k for k in range(40)]
    slow = [quick[-1] + silence + k for k in range(9)]
    standing = list(_at_rest(quick + slow, _LIMITS, 0.1))
    assert all(now < slow[0 if silence >= 1.5 else 3] + _TICK for now in standing)


def test_first_command_holds_for_a_sender_at_one_hertz() -> None:
    hold = CommandHold()
    assert hold.ends(0.0) == -math.inf
    hold.take(4.0, _LIMITS)
    assert hold.ends(0.0) == pytest.approx(5.5)
    assert hold.ends(9.0) == pytest.approx(5.3)
    hold.reset()
    assert hold.ends(0.0) == -math.inf


def test_command_ends_at_the_latest_after_the_longest_time() -> None:
    hold = CommandHold()
    for now in (0.0, 2.9, 5.8):
        hold.take(now, _LIMITS)
    assert hold.ends(0.0) == pytest.approx(8.8)
    hold.take(20.0, _LIMITS)  # so late that it is another's first
    assert hold.ends(0.0) == pytest.approx(21.5)
    hold.take(20.1, HoldLimits(least=5.0))
    assert hold.ends(0.0) == pytest.approx(25.1)


def test_time_that_was_set_back_starts_again() -> None:
    hold = CommandHold()
    hold.take(100.0, _LIMITS)
    hold.take(1.0, _LIMITS)
    assert hold.ends(0.0) == pytest.approx(2.5)


@pytest.mark.parametrize("gap", [0.05, 1.0, 2.0])
def test_fixed_time_out_and_none(gap: float) -> None:
    fixed, forever = CommandHold(), CommandHold()
    for k in range(4):
        fixed.take(k * gap, HoldLimits(0.25, is_fixed=True))
        forever.take(k * gap, HoldLimits(0.0, is_fixed=bool(k % 2)))
    assert fixed.ends(0.0) == fixed.ends(9.0) == pytest.approx(3 * gap + 0.25)
    assert forever.ends(9.0) == math.inf
