"""Handlers of lifecycles' events."""

from __future__ import annotations

from typing import Any

from launch.event_handler import EventHandler

from launch_ros.events.lifecycle import StateTransition


class OnStateTransition(EventHandler):
    """Does something when a node has changed its state."""

    def __init__(
        self,
        *,
        entities: Any,
        target_lifecycle_node: Any = None,
        transition: str | None = None,
        start_state: str | None = None,
        goal_state: str | None = None,
        handle_once: bool = False,
    ) -> None:
        def matches(event: Any) -> bool:
            return (
                isinstance(event, StateTransition)
                and target_lifecycle_node in (None, event.action)
                and start_state in (None, event.start_state)
                and goal_state in (None, event.goal_state)
            )

        super().__init__(matcher=matches, entities=entities, handle_once=handle_once)
