"""Handlers of events that tests wait for."""

from __future__ import annotations

from typing import Any

from launch.event_handlers import OnProcessIO


class StdoutReadyListener(OnProcessIO):
    """Does something when a process writes a text to standard output: it is ready."""

    def __init__(self, *, target_action: Any = None, ready_txt: str, actions: Any) -> None:
        def written(event: Any) -> Any:
            return actions if ready_txt in event.text.decode("utf-8", "replace") else None

        super().__init__(target_action=target_action, on_stdout=written)
