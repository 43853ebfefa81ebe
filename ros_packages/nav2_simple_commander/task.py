"""One action goal at a time: sent, waited for, cancelled."""

from __future__ import annotations

import time
from collections.abc import Callable
from enum import Enum
from typing import Any

import rclpy
from action_msgs.msg import GoalStatus
from rclpy.action import ActionClient
from rclpy.node import Node

SERVER_TIMEOUT, ANSWER_TIMEOUT = 60.0, 10.0  # [s]; the original waits for ever
_POLL = 0.1


class TaskResult(Enum):
    """How a task ended."""

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


class Task:
    """The goal that runs, or the last one.

    Args:
        node: The node; its callbacks run while this waits.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._clients: dict[str, Any] = {}
        self._handle: Any = None
        self._result: Any = None
        self.status: int | None = None
        self.feedback: Any = None

    def start(self, action: Any, name: str, goal: Any) -> bool:
        """Send a goal; tell whether it was accepted.

        Raises:
            NavigatorError: Nobody serves the action, or answers in time.
        """
        client = self._client(action, name)
        self.feedback = self.status = self._result = None
        self._handle = self.answer(client.send_goal_async(goal, self._on_feedback), name)
        if not self._handle.accepted:
            self._node.get_logger().error(f"{name}: the goal was rejected")
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
            self._node.get_logger().warn(f"{name} failed with status {self.status}")
            return None
        return self._result.result().result

    def complete(self) -> bool:
        """Let callbacks run for at most 0.1 s; tell whether the goal has ended."""
        if self._result is None:
            return True
        if self.status is None:
            rclpy.spin_until_future_complete(self._node, self._result, timeout_sec=_POLL)
            if self._result.done() and self._result.result() is not None:
                self.status = self._result.result().status
        return self.status is not None

    def cancel(self) -> None:
        """Cancel the goal that runs."""
        if self._result is not None and self.status is None:
            self.answer(self._handle.cancel_goal_async(), "the cancellation")

    def result(self) -> TaskResult:
        """Return how the goal ended."""
        return TaskResult.UNKNOWN if self.status is None else _RESULTS[self.status]

    def error(self) -> tuple[int, str]:
        """Return the error code and message with which the goal ended; 0 and "" where none."""
        if self.status is None or self._result is None:
            return 0, ""
        result = self._result.result().result
        return int(result.error_code), str(result.error_msg)

    def answer(self, future: Any, name: str) -> Any:
        """Wait for an answer and return it.

        Raises:
            NavigatorError: It does not come in time.
        """
        rclpy.spin_until_future_complete(self._node, future, timeout_sec=ANSWER_TIMEOUT)
        if not future.done():
            raise NavigatorError(f"{name} did not answer within {ANSWER_TIMEOUT:g} s")
        return future.result()

    def wait(self, ready: Callable[[], bool], name: str) -> None:
        """Let callbacks run until something is there.

        Raises:
            NavigatorError: It does not come in time.
        """
        end = time.monotonic() + SERVER_TIMEOUT
        while not ready():
            if time.monotonic() >= end:
                raise NavigatorError(f"{name} is not there after {SERVER_TIMEOUT:g} s")
            rclpy.spin_once(self._node, timeout_sec=_POLL)

    def destroy(self) -> None:
        """Destroy the action clients."""
        for client in self._clients.values():
            client.destroy()
        self._clients.clear()

    def _client(self, action: Any, name: str) -> Any:
        if name not in self._clients:
            self._clients[name] = ActionClient(self._node, action, name)
        self.wait(self._clients[name].server_is_ready, f"the action '{name}'")
        return self._clients[name]

    def _on_feedback(self, message: Any) -> None:
        self.feedback = message.feedback
