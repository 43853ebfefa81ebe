"""Statistics of topics, and errors of the ros2 command."""

from __future__ import annotations

import contextlib
import os
import signal
import time
from collections import deque
from collections.abc import Iterator

import pytest

from bringup.interrupts import check_interrupts, watch_interrupts
from bringup.ros2 import main
from bringup.ros2.statistics import Intervals, bandwidth_text, spread_text


def test_a_steady_rate_has_no_spread() -> None:
    intervals = Intervals(window=100)
    for step in range(11):
        intervals.add(0.25 * step)
    assert intervals.text() == (
        "average rate: 4.000\n\tmin: 0.250s max: 0.250s std dev: 0.00000s window: 10"
    )


@pytest.mark.parametrize(
    ("window", "times", "values"),
    [
        (2, [0.0, 5.0, 6.0, 8.0], [1.0, 2.0]),  # the oldest is forgotten
        (10, [7.0, 8.0, 1.0, 1.5], [0.5]),  # time set back starts again
        (10, [1.0], []),  # one message has no rate
    ],
)
def test_a_window_has_the_newest_intervals(
    window: int, times: list[float], values: list[float]
) -> None:
    intervals = Intervals(window)
    for now in times:
        intervals.add(now)
    assert list(intervals.values) == values


def test_deviation_is_that_of_the_whole_window() -> None:
    assert "std dev: 1.00000s" in spread_text(deque([1.0, 3.0]))


@pytest.mark.parametrize(
    ("sizes", "text"),
    [
        ([100, 200], "300 B/s from 2 messages\n\tMessage size mean: 150 B min: 100 B max: 200 B"),
        (
            [1000, 3000],
            "4.00 KB/s from 2 messages\n\tMessage size mean: 2.00 KB min: 1.00 KB max: 3.00 KB",
        ),
        (
            [4_000_000, 4_000_000],
            "8.00 MB/s from 2 messages\n\tMessage size mean: 4.00 MB min: 4.00 MB max: 4.00 MB",
        ),
    ],
)
def test_one_unit_for_the_whole_line(sizes: list[int], text: str) -> None:
    assert bandwidth_text(deque(sizes), 1.0) == text


@pytest.fixture(autouse=True)
def _handler_given_back() -> Iterator[None]:
    before = signal.getsignal(signal.SIGINT)
    yield
    watch_interrupts()  # forgets those of the test, which would end the next client here
    signal.signal(signal.SIGINT, before)


class Interrupted:
    """Is interrupted while it is destroyed."""

    def __del__(self) -> None:
        signal.raise_signal(signal.SIGINT)


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_what_a_destructor_drops_is_raised_at_the_next_look_and_not_before() -> None:
    watch_interrupts()
    check_interrupts()
    Interrupted()
    with pytest.raises(KeyboardInterrupt, match=r"^$"):
        check_interrupts()


def test_an_import_that_ctrl_c_broke_ends_as_ctrl_c_does(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(words: list[str]) -> int:
        with contextlib.suppress(KeyboardInterrupt):  # as numpy's extensions do
            signal.raise_signal(signal.SIGINT)
        raise ImportError("PyCapsule_Import could not import module")

    monkeypatch.setattr(main, "_run", broken)
    assert main.main(["topic", "list"]) == main.INTERRUPTED


def test_a_signal_that_is_sent_twice_interrupts_once(monkeypatch: pytest.MonkeyPatch) -> None:
    watch_interrupts()
    with pytest.raises(KeyboardInterrupt, match=r"^$"):
        signal.raise_signal(signal.SIGINT)
    signal.raise_signal(signal.SIGINT)
    later = time.monotonic() + 2.0
    monkeypatch.setattr(time, "monotonic", lambda: later)
    with pytest.raises(KeyboardInterrupt, match=r"^$"):
        signal.raise_signal(signal.SIGINT)


def test_a_command_that_ends_cannot_be_interrupted(monkeypatch: pytest.MonkeyPatch) -> None:
    ends = []
    monkeypatch.delenv("ROS_DISTRO", raising=False)
    monkeypatch.setattr(main, "_guarded", lambda words: 3)
    monkeypatch.setattr(
        os, "_exit", lambda code: ends.append((code, signal.getsignal(signal.SIGINT)))
    )
    main.main()
    assert ends == [(3, signal.SIG_IGN)]
