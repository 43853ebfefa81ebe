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


RunningTask = Enum(
    "RunningTask",
    "NONE NAVIGATE_TO_POSE NAVIGATE_THROUGH_POSES FOLLOW_PATH FOLLOW_WAYPOINTS"
    " FOLLOW_GPS_WAYPOINTS SPIN BACKUP DRIVE_ON_HEADING ASSISTED_TELEOP DOCK_ROBOT UNDOCK_ROBOT"
    " COMPUTE_AND_TRACK_ROUTE",
    start=0,
)
"""The tasks by the names of later releases, whose methods return them."""

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
    `status`), because programs read it and set it; a second task's begin with a prefix.
    """

    error = NavigatorError

    def __init__(self, navigator: Any, prefix: str = "") -> None:
        self.client = self._navigator = navigator
        self._handle, self._future = f"{prefix}goal_handle", f"{prefix}result_future"
        self._feedback = "_routeFeedbackCallback" if prefix else "_feedbackCallback"

    @property
    def result_future(self) -> Any:
        """The future of the goal's result, None before the first and of a rejected one."""
        return getattr(self._navigator, self._future)

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
        own.status = None
        setattr(own, self._future, None)
        handle = self.send_goal(client, goal, getattr(own, self._feedback))
        setattr(own, self._handle, handle)
        if not handle.accepted:
            own.error(f"{name}: the goal was rejected")
            own.status = GoalStatus.STATUS_ABORTED
            return False
        setattr(own, self._future, handle.get_result_async())
        return True

    def finish(self, client: Any, goal: Any) -> Any:
        """Send a goal, wait until it ends, and return its result, or None where it is rejected."""
        if not self.start(client, goal):
            return None
        while not self.complete():
            pass
        return self.result_future.result().result

    def complete(self, timeout: float = 0.1) -> bool:
        """Let callbacks run for at most a time [s]; return whether the goal has ended."""
        future = self.result_future
        if future is None:
            return True
        self.run_until(future.done, timeout, required=False)
        if future.done() and future.result() is not None:
            self._navigator.status = future.result().status
            return True
        return False

    def end(self) -> None:
        future = self.result_future
        if future is not None and not future.done():
            self.cancel(getattr(self._navigator, self._handle))

    def outcome(self) -> TaskResult:
        return _RESULTS.get(self._navigator.status, TaskResult.UNKNOWN)

    def failure(self) -> tuple[int, str]:
        """Return the error code and message with which the goal ended; 0 and "" where none."""
        future = self.result_future
        if future is None or not future.done():
            return 0, ""
        result = future.result().result
        return int(result.error_code), str(result.error_msg)
