"""Actions: what a launch description consists of."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from launch.condition import Condition
from launch.launch_context import LaunchContext

Entities = Sequence["LaunchDescriptionEntity"]


class LaunchDescriptionEntity:
    """Base of all that is visited while launching."""

    def visit(self, context: LaunchContext) -> Entities | None:
        """Do it; return what is to be visited next."""
        raise NotImplementedError

    def describe(self) -> str:
        """Return it as text for people."""
        return f"{type(self).__name__}(...)"

    def children(self) -> Iterable[LaunchDescriptionEntity]:
        """Yield what it holds, as far as it is known before it is visited."""
        return ()


class Action(LaunchDescriptionEntity):
    """Something to do, unless a condition says otherwise."""

    def __init__(self, *, condition: Condition | None = None) -> None:
        self.condition = condition

    def visit(self, context: LaunchContext) -> Entities | None:
        """Do it if its condition holds; return what is to be visited next."""
        if self.condition is None or self.condition.evaluate(context):
            return self.execute(context)
        return None

    def execute(self, context: LaunchContext) -> Entities | None:
        """Do it; return what is to be visited next."""
        raise NotImplementedError


def entities(given: Any) -> list[LaunchDescriptionEntity]:
    """Return one or several entities, or none, as a list."""
    if given is None:
        return []
    return [given] if isinstance(given, LaunchDescriptionEntity) else list(given)
