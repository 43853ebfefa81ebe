"""Conditions of actions."""

from __future__ import annotations

from collections.abc import Callable

from launch.launch_context import LaunchContext


class Condition:
    """Decides whether an action is done, by a function of the context."""

    def __init__(self, *, predicate: Callable[[LaunchContext], bool] | None = None) -> None:
        self._predicate = predicate

    def evaluate(self, context: LaunchContext) -> bool:
        return self._predicate is None or self._predicate(context)
