"""Events, and what is done about them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from launch.action import Entities, entities
from launch.launch_context import BaseEventHandler, Event, LaunchContext

__all__ = ["BaseEventHandler", "Event", "EventHandler"]


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
