"""State that is known while launching, and the bases of what is asked with it."""

from __future__ import annotations

import asyncio
import os
import threading
from collections.abc import Callable, Coroutine, Iterable, Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from types import SimpleNamespace
from typing import Any

from arjuna_core.files.whole_file import own_folder
from launch.logging import get_logger


class Substitution:
    """A text that is known only while launching."""

    def describe(self) -> str:
        """Return it as text for people."""
        values = (str(value) for name, value in vars(self).items() if name[0] != "_")
        return f"{type(self).__name__}({', '.join(values)})"

    def __repr__(self) -> str:
        return self.describe()

    def perform(self, context: LaunchContext) -> str:
        raise NotImplementedError


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


_KEPT: list[TemporaryDirectory[str]] = []


class LaunchContext:
    """The configurations, the environment, and the handlers of events.

    Attributes:
        launch_configurations: Values by name.
        locals: What actions have left here, as attributes.
        first: The environment at the beginning.
        tasks: What still runs: processes and timers.
        problems: What could not be started, a line each.
        on_end: Called when all is to end.
        on_kill: Called when that is asked for again.
        visit_all: Visits entities; the service's.
        explain: Returns what to do about an error; the service's.
    """

    def __init__(self, *, argv: Iterable[str] | None = None, noninteractive: bool = False) -> None:
        self.argv, self.noninteractive = list(argv or ()), noninteractive
        self.launch_configurations: dict[str, Any] = {}
        self.locals = SimpleNamespace()
        self.environment, self.first = os.environ, dict(os.environ)
        self.tasks: set[asyncio.Task[Any]] = set()
        self.problems: list[str] = []
        self.on_end: list[Callable[[], Any]] = []
        self.on_kill: list[Callable[[], Any]] = []
        self.visit_all: Callable[[Iterable[Any]], None] = lambda entities: None
        self.explain: Callable[[Exception], str] = lambda error: ""
        self.asyncio_loop: asyncio.AbstractEventLoop | None = None
        self._thread = 0
        self.is_shutdown = False
        self._saved_configurations: list[dict[str, Any]] = []
        self._saved_environments: list[dict[str, str]] = []
        self._handlers: list[BaseEventHandler] = []
        self._events: list[Event] = []
        self._woken = asyncio.Event()
        self._files = 0
        self._folder: TemporaryDirectory[str] | None = None

    def extend_locals(self, extra: Mapping[str, Any]) -> None:
        vars(self.locals).update(extra)

    extend_globals = extend_locals

    def get_locals_as_dict(self) -> dict[str, Any]:
        return dict(vars(self.locals))

    def perform_substitution(self, sub: Substitution) -> str:
        return sub.perform(self)

    def push_launch_configurations(self) -> None:
        self._saved_configurations.append(dict(self.launch_configurations))

    def pop_launch_configurations(self) -> None:
        self.launch_configurations = self._saved_configurations.pop()

    def replace_environment(self, variables: Mapping[str, str]) -> None:
        """Make the environment these variables and no others."""
        os.environ.clear()
        os.environ.update(variables)

    def push_environment(self) -> None:
        self._saved_environments.append(dict(os.environ))

    def pop_environment(self) -> None:
        self.replace_environment(self._saved_environments.pop())

    def within(self, configurations: Mapping[str, Any], visit: Callable[[], Any]) -> None:
        """Visit with configurations of an earlier time over those of now; new ones stay."""
        before = self.launch_configurations
        start = {**before, **configurations}
        self.launch_configurations = dict(start)
        visit()
        changed = {k: v for k, v in self.launch_configurations.items() if start.get(k) != v}
        self.launch_configurations = {**before, **changed}

    def register_event_handler(self, event_handler: BaseEventHandler) -> None:
        """Take a handler; the last comes first."""
        self._handlers.insert(0, event_handler)

    def unregister_event_handler(self, event_handler: BaseEventHandler) -> None:
        self._handlers.remove(event_handler)

    def handlers(self, event: Event) -> list[BaseEventHandler]:
        return [one for one in self._handlers if one.matches(event)]

    def emit_event_sync(self, event: Event) -> None:
        """Let an event be handled next; from any thread."""
        self._events.append(event)
        self.wake()

    def wake(self) -> None:
        """Have the service look for what there is to do; from any thread."""
        loop = self.asyncio_loop
        if loop is None or threading.get_ident() == self._thread:
            self._woken.set()
        else:
            loop.call_soon_threadsafe(self._woken.set)

    def runs_in(self, loop: asyncio.AbstractEventLoop | None) -> None:
        """Note the loop, of this thread, that launching runs in; None when it has ended."""
        self.asyncio_loop, self._thread = loop, threading.get_ident()

    async def emit_event(self, event: Event) -> None:
        self.emit_event_sync(event)

    def take_event(self) -> Event | None:
        return self._events.pop(0) if self._events else None

    def start(self, work: Coroutine[Any, Any, Any]) -> asyncio.Task[Any]:
        """Run something beside; launching lasts as long as it does."""
        task = asyncio.get_running_loop().create_task(work)
        self.tasks.add(task)
        task.add_done_callback(self._ended)
        return task

    def _ended(self, task: asyncio.Task[Any]) -> None:
        self.tasks.discard(task)
        self._woken.set()
        if not task.cancelled() and (error := task.exception()) is not None:
            self.problems.append(str(error))
            get_logger("launch").error(f"{type(error).__name__}: {error}")

    def new_file(self, text: str) -> Path:
        """Return a new file of parameters, for the processes of this launch; removed at its end.

        That of a context of a launch file's own, in which it performs substitutions, is there
        until this process ends.
        """
        if self._folder is None:
            self._folder = own_folder("launch")
            _KEPT.append(self._folder)
        self._files += 1
        path = Path(self._folder.name, f"{self._files}.yaml")
        path.write_text(text, encoding="utf-8")
        return path

    def remove_files(self) -> None:
        """Remove the files that were made for this launch."""
        if self._folder is not None:
            self._folder.cleanup()
            self._folder = None

    async def wait(self) -> None:
        """Wait for an event, or for the end of something that runs."""
        await self._woken.wait()
        self._woken.clear()
