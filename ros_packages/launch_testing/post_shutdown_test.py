"""Tests behind the end of a launch."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

T = TypeVar("T", bound=type)


def post_shutdown_test() -> Callable[[T], T]:
    """Have the tests of a class run when all processes have ended."""

    def decorate(case: T) -> T:
        case.__post_shutdown_test__ = True  # type: ignore[attr-defined]
        return case

    return decorate
