"""Launches whose result is that of some of their processes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from launch import LaunchDescription, LaunchService
from launch.actions import EmitEvent, ExecuteProcess, RegisterEventHandler
from launch.event_handlers import OnExecutionComplete, OnProcessExit
from launch.events import Shutdown


class LaunchTestService:
    """Runs processes that are tests beside a launch, and ends it with the last of them."""

    def __init__(self) -> None:
        self._tests: list[Any] = []
        self._codes: dict[Any, int] = {}

    def add_test_action(self, launch_description: LaunchDescription, action: Any) -> Any:
        """Add a process to a description, whose exit code is a result, or what is one when done."""
        self._tests.append(action)
        self._end_with(launch_description, action)
        launch_description.add_action(action)
        return action

    def add_fixture_action(
        self,
        launch_description: LaunchDescription,
        action: Any,
        exit_allowed: bool | list[int] = False,
    ) -> Any:
        """Add a process that has to run as long as the tests do, unless it may end."""
        allowed = (lambda code: code in exit_allowed) if isinstance(exit_allowed, list) else None
        if exit_allowed is not True:
            self._end_with(launch_description, action, allowed or (lambda code: False))
        launch_description.add_action(action)
        return action

    def _end_with(
        self,
        description: LaunchDescription,
        action: Any,
        allowed: Callable[[int], bool] | None = None,
    ) -> None:
        is_process = isinstance(action, ExecuteProcess)

        def ended(event: Any, context: Any) -> list[Any]:
            if context.is_shutdown or (allowed is not None and allowed(event.returncode)):
                return []
            code = event.returncode if is_process else 0
            self._codes[action] = code or (0 if allowed is None else 1)
            over = allowed is not None or all(test in self._codes for test in self._tests)
            return [EmitEvent(event=Shutdown(reason="the tests have ended"))] if over else []

        handler = (
            OnProcessExit(target_action=action, on_exit=ended)
            if is_process
            else OnExecutionComplete(target_action=action, on_completion=ended)
        )
        description.add_action(RegisterEventHandler(handler))

    def run(self, launch_service: LaunchService, *args: Any, **kwargs: Any) -> int:
        """Launch; return 0, or the exit code of a test that failed."""
        code = launch_service.run(*args, **kwargs)
        missing = [1 for test in self._tests if test not in self._codes]
        return next((one for one in (*self._codes.values(), *missing, code) if one), 0)
