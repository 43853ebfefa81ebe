"""Waiting for what a process writes, for its start and its end; output needs `cached_output`."""

from __future__ import annotations

import asyncio
import functools
import threading
import time
from collections.abc import Callable, Coroutine
from typing import Any, TypeVar

T = TypeVar("T")


def _fulfilled(text: Callable[[], str], validate: Callable[[str], Any]) -> Callable[[], bool]:
    """Return whether a text fulfils a function, which returns False or raises if not; as a call."""

    def fulfilled() -> bool:
        try:
            return validate(text()) is not False
        except AssertionError:
            return False

    return fulfilled


def _wait(is_there: Callable[[], bool], timeout: float | None) -> bool:
    deadline, never = time.monotonic() + (timeout or 10.0), threading.Event()
    while not is_there():
        if time.monotonic() > deadline:
            return is_there()
        never.wait(0.02)  # [s] to the next look
    return True


def _of(stream: str) -> tuple[Callable[..., bool], Callable[..., None]]:
    """Return what waits until a process' stream fulfils a function within a time [s].

    The first returns whether it does, the second raises an AssertionError where it does not.
    """

    def wait(context: Any, action: Any, validate_output: Any, timeout: float | None = None) -> bool:
        return _wait(_fulfilled(getattr(action, stream), validate_output), timeout)

    def assert_it(
        context: Any, action: Any, validate_output: Any, timeout: float | None = None
    ) -> None:
        if not wait(context, action, validate_output, timeout):
            text = getattr(action, stream)()
            assert validate_output(text) is not False, text

    return wait, assert_it


wait_for_output_sync, assert_output_sync = _of("get_stdout")
wait_for_stderr_sync, assert_stderr_sync = _of("get_stderr")


def wait_for_start_sync(context: Any, action: Any, timeout: float | None = None) -> bool:
    """Return whether a process starts within a time [s]."""
    return _wait(lambda: "pid" in action.process_details, timeout)


def wait_for_exit_sync(context: Any, action: Any, timeout: float | None = None) -> bool:
    """Return whether a process ends within a time [s]."""
    return _wait(lambda: action.return_code is not None, timeout)


def _awaited(wait: Callable[..., T]) -> Callable[..., Coroutine[Any, Any, T]]:
    """Return a wait as a coroutine, beside which the launch goes on."""

    @functools.wraps(wait)
    async def awaited(*args: Any, **kwargs: Any) -> T:
        return await asyncio.to_thread(wait, *args, **kwargs)

    return awaited


wait_for_output = _awaited(wait_for_output_sync)
wait_for_stderr = _awaited(wait_for_stderr_sync)
assert_output = _awaited(assert_output_sync)
assert_stderr = _awaited(assert_stderr_sync)
wait_for_start = _awaited(wait_for_start_sync)
wait_for_exit = _awaited(wait_for_exit_sync)
