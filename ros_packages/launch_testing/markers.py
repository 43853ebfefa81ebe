"""Marks on descriptions and on tests; several launches of one description."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable, Sequence
from typing import Any, TypeVar

F = TypeVar("F", bound=Callable[..., Any])
T = TypeVar("T", bound=type)


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


def parametrize(argnames: str | Sequence[str], argvalues: Iterable[Any]) -> Callable[[F], F]:
    """Have a description be launched with each of some values, as pytest's `parametrize`."""
    names = (
        [name.strip() for name in argnames.split(",")] if isinstance(argnames, str) else argnames
    )
    rows = [dict(zip(names, row if len(names) > 1 else [row], strict=True)) for row in argvalues]

    def decorate(describe: F) -> F:
        before = getattr(describe, "__parametrized__", [{}])
        describe.__parametrized__ = [{**a, **b} for b in rows for a in before]  # type: ignore[attr-defined]
        return describe

    return decorate


def post_shutdown_test() -> Callable[[T], T]:
    """Have the tests of a class run when all processes have ended."""

    def decorate(case: T) -> T:
        case.__post_shutdown_test__ = True  # type: ignore[attr-defined]
        return case

    return decorate
