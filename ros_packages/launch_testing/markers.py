"""Marks on descriptions and on tests."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any, TypeVar

F = TypeVar("F", bound=Callable[..., Any])


def keep_alive(describe: F) -> F:
    """Have the launch last until the tests end, though all its processes have ended."""
    describe.keep_alive = True  # type: ignore[attr-defined]
    return describe


def retry_on_failure(*, times: int) -> Callable[[F], F]:
    """Have a test be tried so many times until it passes."""

    def decorate(test: F) -> F:
        @functools.wraps(test)
        def tried(*args: Any, **kwargs: Any) -> Any:
            for _ in range(times - 1):
                try:
                    return test(*args, **kwargs)
                except AssertionError:
                    continue
            return test(*args, **kwargs)

        return tried  # type: ignore[return-value]

    return decorate
