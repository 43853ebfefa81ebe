"""Events, and what is done about them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from launch.action import Entities, entities
from launch.launch_context import LaunchContext


class Event:
    """Something that has happened."""

    name = "launch.Event"


class BaseEventHandler:
    """Decides which events it handles, and returns what is visited then.

    Attributes:
        configurations: Those of when it was registered.
    """

    def __init__(self, *, matcher: Callable[[Any], bool], handle_once: bool = False) -> None:
        self._matcher, self._once, self._handled = matcher, handle_once, False
        self.configurations: dict[str, str] = {}

    def matches(self, event: Any) -> bool:
        """Return whether it handles an event."""
        return not (self._once and self._handled) and bool(self._matcher(event))

    def handle(self, event: Any, context: LaunchContext) -> Any:
        """Return what is visited because of an event."""
        self._handled = True
        context.extend_locals({"event": event})
        return None


class EventHandler(BaseEventHandler):
    """Visits entities at events that a function chooses."""

    def __init__(
        self,
        *,
        matcher: Callable[[Any], bool],
        entities: Any = None,  # noqa: A002, RUF100 - launch's name
        handle_once: bool = False,
    ) -> None:
        super().__init__(matcher=matcher, handle_once=handle_once)
        self.entities = entities

    def handle(self, event: Any, context: LaunchContext) -> Entities:
        super().handle(event, context)
        given = self.entities
        if callable(given):
            try:
                given = given(event, context)
            except TypeError as error:  # as launch allows: a function of the event alone
                if "positional argument" not in str(error):
                    raise
                given = self.entities(event)
        return entities(given)
