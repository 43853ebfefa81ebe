"""Events of launch."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from launch.event_handler import Event
from launch.events import process


class Shutdown(Event):
    """All is to end."""

    name = "launch.events.Shutdown"

    def __init__(self, *, reason: str = "reason not given", due_to_sigint: bool = False) -> None:
        self.reason = self.__reason = reason
        self.due_to_sigint = due_to_sigint


class ExecutionComplete(Event):
    """An action is done."""

    name = "launch.events.ExecutionComplete"

    def __init__(self, *, action: Any) -> None:
        self.action = action


class TimerEvent(Event):
    """A timer has run out."""

    name = "launch.events.TimerEvent"

    def __init__(self, *, timer_action: Any) -> None:
        self.timer_action = timer_action


def matches_action(action: Any) -> Callable[[Any], bool]:
    return lambda other: other is action
