"""Several launches of one description."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any, TypeVar

F = TypeVar("F", bound=Callable[..., Any])


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
