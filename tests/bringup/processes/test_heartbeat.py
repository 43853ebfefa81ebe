"""Claims: a process that no longer answers is noticed, one that gets no core is not blamed."""

from __future__ import annotations

import os

from bringup.processes.heartbeat import Heartbeat, starved


def test_what_never_gave_a_sign_of_life_is_not_watched() -> None:
    assert Heartbeat().silence(1000.0, 0.0) is None


def test_silence_beyond_the_patience_is_told_with_its_length() -> None:
    heart = Heartbeat()
    heart.hear(10.0, 5.0, 0.0)
    assert heart.silence(14.9, 0.0) is None
    assert heart.silence(16.0, 0.0) == 6.0


def test_a_step_that_was_announced_may_take_its_time() -> None:
    heart = Heartbeat()
    heart.hear(10.0, 90.0, 0.0)
    assert heart.silence(99.0, 0.0) is None
    heart.hear(99.0, 5.0, 0.0)
    assert heart.silence(105.0, 0.0) == 6.0


def test_time_without_a_core_or_without_a_listener_does_not_count() -> None:
    heart = Heartbeat()
    heart.hear(10.0, 5.0, 2.0)
    assert heart.silence(16.0, 4.0) is None
    heart.excuse(30.0)
    assert heart.silence(46.0, 4.0) is None
    assert heart.silence(48.0, 4.0) == 6.0


def test_a_process_s_waiting_for_a_core_is_known_and_none_s_is_0() -> None:
    assert starved(os.getpid()) >= 0.0
    assert starved(2**22 + 1) == 0.0  # more than Linux gives
