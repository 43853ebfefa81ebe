"""A launch beside tests: in a thread of its own, until it is ended."""

from __future__ import annotations

import asyncio
import contextlib
import inspect
import threading
from collections.abc import Callable, Iterator
from typing import Any

from launch import LaunchDescription, LaunchService
from launch.action import LaunchDescriptionEntity
from launch.actions import OpaqueFunction
from launch_testing.actions import ReadyToTest
from launch_testing.launch_test import isolated_domain
from launch_testing.runner import READY

_PATIENCE = 60.0  # [s] for all processes to end


class RunningLaunch:
    """The launch of a description.

    Args:
        described: A description, or it and whatever else, as a fixture returns it.
        shutdown_when_idle: Whether it ends when all its processes have ended.

    Attributes:
        service: The service that launches.
    """

    def __init__(self, described: Any, shutdown_when_idle: bool = False) -> None:
        self._description = described[0] if isinstance(described, tuple) else described
        self.service = LaunchService()
        self._idle, self._ready = shutdown_when_idle, threading.Event()
        self._loop: asyncio.AbstractEventLoop | None = None
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._own = contextlib.ExitStack()

    def start(self) -> None:
        """Launch, and return when the tests may begin.

        Raises:
            TimeoutError: The description's ReadyToTest did not come.
        """
        self._own.enter_context(isolated_domain())
        service = self.service
        service.context.extend_locals({"is_ready": self._ready.set})
        service.include_launch_description(self._description)
        if not any(isinstance(one, ReadyToTest) for one in _walk(self._description)):
            done = OpaqueFunction(function=lambda context: self._ready.set())
            service.include_launch_description(LaunchDescription([done]))
        self._thread.start()
        if not self._ready.wait(READY):
            raise TimeoutError(f"no ReadyToTest within {READY:g} s")

    def _run(self) -> None:
        async def launching() -> None:
            self._loop = asyncio.get_running_loop()
            await self.service.run_async(shutdown_when_idle=self._idle)

        try:
            asyncio.run(launching())
        finally:
            self._ready.set()

    def end(self) -> None:
        """End all processes, and wait for that."""
        if self._thread.is_alive():
            self.service.shutdown()
            self._thread.join(_PATIENCE)
        self._own.close()

    def call(self, test: Callable[..., Any], arguments: dict[str, Any]) -> None:
        """Run a test: a function, or up to a `yield` beside the launch and then behind its end."""
        found = test(**arguments)
        if inspect.iscoroutine(found):
            self._await(found)
        elif inspect.isgenerator(found):
            next(found)
            self.end()
            next(found, None)
        elif inspect.isasyncgen(found):
            self._await(anext(found))
            self.end()
            asyncio.run(_rest(found))

    def _await(self, work: Any) -> None:
        async def awaited() -> None:
            await work

        if self._loop is None:
            asyncio.run(awaited())
        else:
            asyncio.run_coroutine_threadsafe(awaited(), self._loop).result()


async def _rest(found: Any) -> None:
    with contextlib.suppress(StopAsyncIteration):
        await anext(found)


def _walk(entity: LaunchDescriptionEntity) -> Iterator[LaunchDescriptionEntity]:
    yield entity
    for child in entity.children():
        yield from _walk(child)
