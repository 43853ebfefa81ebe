"""One action goal at a time: sent, waited for, cancelled."""

from __future__ import annotations

from enum import Enum
from typing import Any

import rclpy
from action_msgs.msg import GoalStatus

from bringup.client.session import POLL, Session

SERVER_TIMEOUT = 60.0  # [s]; the original waits for ever


class TaskResult(Enum):
    """The outcome of a task."""

    UNKNOWN = 0
    SUCCEEDED = 1
    CANCELED = 2
    FAILED = 3


_RESULTS = {
    GoalStatus.STATUS_SUCCEEDED: TaskResult.SUCCEEDED,
    GoalStatus.STATUS_ABORTED: TaskResult.FAILED,
    GoalStatus.STATUS_CANCELED: TaskResult.CANCELED,
}


class NavigatorError(RuntimeError):
    """A server is not there, or does not answer in time."""


class Task(Session):
    """The goal of a navigator that runs, or the last one.

    Its state is the navigator's own, under the original's names (`goal_handle`, `result_future`,
    `status`), because programs read it and set it.
    """

    error = NavigatorError

    def __init__(self, navigator: Any) -> None:
        self.client = self._navigator = navigator

    def spin_once(self, timeout: float = POLL) -> None:
        """Let a callback run, as `rclpy.spin_once` does."""
        rclpy.spin_once(self.client, timeout_sec=timeout)

    def start(self, client: Any, goal: Any) -> bool:
        """Send a goal; return whether it was accepted.

        Raises:
            NavigatorError: Nobody serves the action, or answers in time.
        """
        own, name = self._navigator, client._action_name
        self.run_until(client.server_is_ready, SERVER_TIMEOUT, f"the action '{name}'")
        own.status = own.result_future = None
        own.goal_handle = self.send_goal(client, goal, own._feedbackCallback)
        if not own.goal_handle.accepted:
            own.error(f"{name}: the goal was rejected")
            own.status = GoalStatus.STATUS_ABORTED
            return False
        own.result_future = own.goal_handle.get_result_async()
        return True

    def finish(self, client: Any, goal: Any) -> Any:
        """Send a goal, wait until it ends, and return its result, or None where it is rejected."""
        if not self.start(client, goal):
            return None
        while not self.complete():
            pass
        return self._navigator.result_future.result().result

    def complete(self, timeout: float = 0.1) -> bool:
        """Let callbacks run for at most a time [s]; return whether the goal has ended."""
        future = self._navigator.result_future
        if future is None:
            return True
        self.run_until(future.done, timeout, required=False)
        if future.done() and future.result() is not None:
            self._navigator.status = future.result().status
            return True
        return False

    def end(self) -> None:
        future = self._navigator.result_future
        if future is not None and not future.done():
            self.cancel(self._navigator.goal_handle)

    def outcome(self) -> TaskResult:
        return _RESULTS.get(self._navigator.status, TaskResult.UNKNOWN)

    def failure(self) -> tuple[int, str]:
        """Return the error code and message with which the goal ended; 0 and "" where none."""
        future = self._navigator.result_future
        if future is None or not future.done():
            return 0, ""
        result = future.result().result
        return int(result.error_code), str(result.error_msg)
