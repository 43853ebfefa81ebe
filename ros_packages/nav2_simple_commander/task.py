"""One action goal at a time: sent, waited for, cancelled."""

from __future__ import annotations

from enum import Enum
from typing import Any

import rclpy
from action_msgs.msg import GoalStatus
from rclpy.action import ActionClient
from rclpy.node import Node

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
    """The goal that runs, or the last one."""

    error = NavigatorError

    def __init__(self, node: Node) -> None:
        self.client = node
        self._clients: dict[str, Any] = {}
        self._handle: Any = None
        self._result: Any = None
        self.status: int | None = None
        self.feedback: Any = None

    def spin_once(self, timeout: float = POLL) -> None:
        """Let a callback run, as `rclpy.spin_once` does."""
        rclpy.spin_once(self.client, timeout_sec=timeout)

    def start(self, action: Any, name: str, goal: Any) -> bool:
        """Send a goal; return whether it was accepted.

        Raises:
            NavigatorError: Nobody serves the action, or answers in time.
        """
        if name not in self._clients:
            self._clients[name] = ActionClient(self.client, action, name)
        client = self._clients[name]
        self.run_until(client.server_is_ready, SERVER_TIMEOUT, f"the action '{name}'")
        self.feedback = self.status = self._result = None
        self._handle = self.send_goal(client, goal, self._on_feedback)
        if not self._handle.accepted:
            self.client.get_logger().error(f"{name}: the goal was rejected")
            self.status = GoalStatus.STATUS_ABORTED
            return False
        self._result = self._handle.get_result_async()
        return True

    def finish(self, action: Any, name: str, goal: Any) -> Any:
        """Send a goal, wait until it ends, and return its result, or None where it failed."""
        if not self.start(action, name, goal):
            return None
        while not self.complete():
            pass
        if self.status != GoalStatus.STATUS_SUCCEEDED:
            self.client.get_logger().warn(f"{name} failed with status {self.status}")
            return None
        return self._result.result().result

    def complete(self, timeout: float = 0.1) -> bool:
        """Let callbacks run for at most a time [s]; return whether the goal has ended."""
        if self._result is None:
            return True
        if self.status is None:
            self.run_until(self._result.done, timeout, required=False)
            if self._result.done() and self._result.result() is not None:
                self.status = self._result.result().status
        return self.status is not None

    def end(self) -> None:
        """Cancel the goal that runs."""
        if self._result is not None and self.status is None:
            self.cancel(self._handle)

    def outcome(self) -> TaskResult:
        """Return how the goal ended."""
        return TaskResult.UNKNOWN if self.status is None else _RESULTS[self.status]

    def failure(self) -> tuple[int, str]:
        """Return the error code and message with which the goal ended; 0 and "" where none."""
        if self.status is None or self._result is None:
            return 0, ""
        result = self._result.result().result
        return int(result.error_code), str(result.error_msg)

    def destroy(self) -> None:
        """Destroy the action clients."""
        for client in self._clients.values():
            client.destroy()
        self._clients.clear()

    def _on_feedback(self, message: Any) -> None:
        self.feedback = message.feedback
