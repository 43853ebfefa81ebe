"""Handlers of processes' events, of ends and of shutdown."""

from __future__ import annotations

from typing import Any

from launch.action import Entities, entities
from launch.event_handler import EventHandler
from launch.events import ExecutionComplete, Shutdown
from launch.events.process import ProcessExited, ProcessIO, ProcessStarted
from launch.launch_context import LaunchContext


class OnActionEventBase(EventHandler):
    """Handles an event of one action, of those that a function chooses, or of every one."""

    event: type[Any]
    reaction = ""

    def __init__(self, *, target_action: Any = None, **kwargs: Any) -> None:
        def matches(event: Any) -> bool:
            if not isinstance(event, self.event):
                return False
            chosen = target_action is None or event.action is target_action
            is_matcher = callable(target_action) and not hasattr(target_action, "execute")
            return chosen or (is_matcher and bool(target_action(event.action)))

        once = kwargs.pop("handle_once", False)
        reaction = kwargs.pop(self.reaction, None)
        if kwargs:
            valid = f"target_action, {self.reaction}, handle_once"
            raise TypeError(f"{type(self).__name__}: no {', '.join(kwargs)}; valid: {valid}")
        super().__init__(matcher=matches, entities=reaction, handle_once=once)
        self.__target_action = target_action
        self.__actions_on_event = [] if callable(reaction) else entities(reaction)


class OnProcessStart(OnActionEventBase):
    """Does something when a process has started."""

    event, reaction = ProcessStarted, "on_start"


class OnProcessExit(OnActionEventBase):
    """Does something when a process has ended."""

    event, reaction = ProcessExited, "on_exit"


class OnExecutionComplete(OnActionEventBase):
    """Does something when an action is done."""

    event, reaction = ExecutionComplete, "on_completion"


class OnProcessIO(OnActionEventBase):
    """Does something when a process writes."""

    event, reaction = ProcessIO, ""

    def __init__(
        self,
        *,
        target_action: Any = None,
        on_stdin: Any = None,
        on_stdout: Any = None,
        on_stderr: Any = None,
        **kwargs: Any,
    ) -> None:
        super().__init__(target_action=target_action, **kwargs)
        self._reactions = (on_stdin, on_stdout, on_stderr)

    def handle(self, event: Any, context: LaunchContext) -> Entities:
        super().handle(event, context)
        reaction = self._reactions[event.fd]
        return entities(reaction(event) if callable(reaction) else reaction)


class OnShutdown(EventHandler):
    """Does something when all is to end."""

    def __init__(self, *, on_shutdown: Any, handle_once: bool = False) -> None:
        super().__init__(
            matcher=lambda event: isinstance(event, Shutdown),
            entities=on_shutdown,
            handle_once=handle_once,
        )
