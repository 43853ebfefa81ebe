"""Actions for tests: the one that says when they begin, and processes that are tests themselves."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from typing import Any

from launch.action import Action, Entities
from launch.actions import EmitEvent, ExecuteProcess, TimerAction
from launch.events.process import ShutdownProcess
from launch.launch_context import LaunchContext

__all__ = ["GTest", "PyTest", "ReadyToTest", "Test"]


class ReadyToTest(Action):
    """Lets the tests begin; who runs them sets `is_ready` in the context."""

    def __init__(self) -> None:
        super().__init__()

    def execute(self, context: LaunchContext) -> None:
        getattr(context.locals, "is_ready", lambda: None)()


class Test(ExecuteProcess):
    """A process that is a test: its exit code is the result, after a timeout [s] it is ended."""

    __test__ = False

    def __init__(self, *, timeout: float | None = None, **kwargs: Any) -> None:
        super().__init__(**{"output": "screen", **kwargs})
        self._timeout = timeout

    def execute(self, context: LaunchContext) -> Entities | None:
        """Run it; end it after the timeout."""
        super().execute(context)
        if self._timeout is None:
            return None
        end = EmitEvent(event=ShutdownProcess(process_matcher=lambda one: one is self))
        return [TimerAction(period=float(self._timeout), actions=[end])]


class GTest(Test):
    """A program of GoogleTest."""

    def __init__(self, *, path: str, timeout: float | None = None, **kwargs: Any) -> None:
        super().__init__(cmd=[path, *kwargs.pop("args", ())], timeout=timeout, **kwargs)


class PyTest(Test):
    """A file of pytest."""

    def __init__(
        self, *, path: str, timeout: float | None = None, args: Iterable[str] = (), **kwargs: Any
    ) -> None:
        super().__init__(
            cmd=[sys.executable, "-m", "pytest", path, *args], timeout=timeout, **kwargs
        )
