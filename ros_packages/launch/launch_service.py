"""The service that launches: visits what is described, until nothing runs."""

from __future__ import annotations

import asyncio
import signal
import threading
from collections.abc import Callable, Iterable
from contextlib import suppress
from functools import partial

from bringup.interrupts import AGAIN
from launch.action import LaunchDescriptionEntity
from launch.event_handler import BaseEventHandler, Event
from launch.events import Shutdown
from launch.launch_context import LaunchContext
from launch.logging import get_logger


class LaunchService:
    """Launches descriptions; one after the other has `run`.

    Attributes:
        context: What is known while launching.
        explain: Returns what to do about an error of a launch file.
    """

    explain: Callable[[Exception], str] = staticmethod(lambda error: "")

    def __init__(
        self,
        *,
        argv: Iterable[str] | None = None,
        noninteractive: bool = False,
        debug: bool = False,
    ) -> None:
        self.context = LaunchContext(argv=argv, noninteractive=noninteractive)
        self.context.visit_all, self.context.explain = self._visit_all, self.explain
        self._descriptions: list[LaunchDescriptionEntity] = []
        self._failed, self._debug = False, debug
        self._interrupted: float | None = None

    def include_launch_description(self, launch_description: LaunchDescriptionEntity) -> None:
        """Launch a description too; from any thread, also while it runs."""
        self._descriptions.append(launch_description)
        self.context.wake()

    def emit_event(self, event: Event) -> None:
        self.context.emit_event_sync(event)

    def shutdown(self, force_sync: bool = False) -> None:
        self.emit_event(Shutdown(reason="LaunchService.shutdown() called"))

    def run(self, *, shutdown_when_idle: bool = True) -> int:
        """Launch until nothing runs; return 0, or 1 where something could not be launched."""
        return asyncio.run(self.run_async(shutdown_when_idle=shutdown_when_idle))

    async def run_async(self, *, shutdown_when_idle: bool = True) -> int:
        """Launch until nothing runs; return 0, or 1 where something could not be launched."""
        context = self.context
        loop = asyncio.get_running_loop()
        context.runs_in(loop)
        numbers = (signal.SIGINT, signal.SIGTERM)
        if threading.current_thread() is threading.main_thread():
            for number in numbers:
                loop.add_signal_handler(number, self._on_signal, number)
        try:
            await self._run(shutdown_when_idle)
        finally:
            context.runs_in(None)
            context.remove_files()
            for number in numbers:
                with suppress(ValueError, RuntimeError):
                    loop.remove_signal_handler(number)
        return int(self._failed or bool(context.problems))

    async def _run(self, shutdown_when_idle: bool) -> None:
        context = self.context
        while True:
            while self._descriptions:
                self._guarded(partial(self._visit, self._descriptions.pop(0)))
            while (event := context.take_event()) is not None:
                self._handle(event)
            if not context.tasks and (context.is_shutdown or shutdown_when_idle):
                if context.is_shutdown:
                    return
                context.emit_event_sync(Shutdown(reason="idle"))
                continue
            await context.wait()

    def _on_signal(self, number: int) -> None:
        now = asyncio.get_running_loop().time()
        if self._interrupted is not None:
            if now - self._interrupted >= AGAIN:  # what still runs ends by force
                for end in self.context.on_kill:
                    end()
            return
        self._interrupted = now
        if number == signal.SIGINT:
            get_logger("launch").warning("user interrupted with ctrl-c (SIGINT)")
        name = signal.Signals(number).name
        interrupted = number == signal.SIGINT
        reason = "ctrl-c (SIGINT)" if interrupted else f"signal {name}"
        self.emit_event(Shutdown(reason=reason, due_to_sigint=interrupted))

    def _handle(self, event: Event) -> None:
        context = self.context
        if isinstance(event, Shutdown):
            if context.is_shutdown:  # as where the end of one process asks for that of all
                return
            context.is_shutdown = True
        for handler in context.handlers(event):
            self._guarded(partial(self._handle_by, handler, event))
        if isinstance(event, Shutdown):
            for end in context.on_end:
                end()

    def _handle_by(self, handler: BaseEventHandler, event: Event) -> None:
        context = self.context
        before = getattr(context.locals, "event", None)
        context.within(
            handler.configurations,
            lambda: self._visit_all(handler.handle(event, context) or ()),
        )
        context.extend_locals({"event": before})

    def _guarded(self, do: Callable[[], None]) -> None:
        try:
            do()
        except Exception as error:  # noqa: BLE001 - of a launch file of anyone
            if self._debug:
                get_logger("launch").exception("the traceback")
            self._failed = True
            name = "" if isinstance(error, RuntimeError) else f"{type(error).__name__}: "
            text = f"Caught exception in launch: {name}{error}; {self.explain(error)}"
            get_logger("launch").error(text.rstrip("; "))
            self.emit_event(Shutdown(reason="exception in launch"))

    def _visit_all(self, given: Iterable[LaunchDescriptionEntity]) -> None:
        for entity in given:
            self._visit(entity)

    def _visit(self, entity: LaunchDescriptionEntity) -> None:
        self._visit_all(entity.visit(self.context) or ())
