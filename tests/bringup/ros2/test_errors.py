"""Ctrl-C that comes where Python drops the exception."""

from __future__ import annotations

import signal
from collections.abc import Iterator

import pytest

from bringup.ros2.errors import check_interrupts, watch_interrupts


@pytest.fixture(autouse=True)
def _handler_given_back() -> Iterator[None]:
    before = signal.getsignal(signal.SIGINT)
    yield
    signal.signal(signal.SIGINT, before)


class Interrupted:
    """Is interrupted while it is destroyed."""

    def __del__(self) -> None:
        signal.raise_signal(signal.SIGINT)


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_what_a_destructor_drops_is_raised_at_the_next_look() -> None:
    watch_interrupts()
    Interrupted()
    with pytest.raises(KeyboardInterrupt, match=r"^$"):
        check_interrupts()


def test_nothing_is_raised_before() -> None:
    watch_interrupts()
    check_interrupts()
