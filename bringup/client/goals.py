"""Goals sent as any client would send them, by plain rclpy action clients."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from action_msgs.msg import GoalStatus
from nav2_msgs.action import NavigateToPose, Spin
from rclpy.action import ActionClient

from arjuna_core.ros.convert import duration_msg, pose_stamped
from arjuna_core.se2 import SE2
from bringup.client.session import Session, wait_for

_ANSWER_TIMEOUT = 10.0
_CURE = "is 'python -m bringup nav --map FILE' running and active?"


@dataclass(frozen=True)
class GoalEnd:
    """How a goal ended.

    Attributes:
        succeeded: Whether it was reached.
        reason: Why it was not; empty where it was.
    """

    succeeded: bool
    reason: str = ""


class Goals:
    """Sends goals and waits until they end.

    Args:
        session: The connection to the robot.
    """

    def __init__(self, session: Session) -> None:
        self._session = session
        self._clients: dict[str, Any] = {}

    def navigate(
        self,
        goal: SE2,
        timeout: float,
        progress: Callable[[Any], None] = lambda feedback: None,
    ) -> GoalEnd:
        """Drive to a pose in the map frame.

        Args:
            goal: [m, m, rad].
            timeout: After which the goal is cancelled [s].
            progress: Takes nav2's feedback: distance_remaining, number_of_recoveries and more.
        """
        request = NavigateToPose.Goal(pose=pose_stamped(goal, "map", 0.0))
        return self._run(NavigateToPose, "navigate_to_pose", request, timeout, progress)

    def spin(self, angle: float, timeout: float) -> GoalEnd:
        """Turn on the spot by an angle [rad] within a time [s]."""
        request = Spin.Goal(target_yaw=angle, time_allowance=duration_msg(timeout))
        return self._run(Spin, "spin", request, timeout + _ANSWER_TIMEOUT, lambda feedback: None)

    def _run(
        self,
        action: Any,
        name: str,
        request: Any,
        timeout: float,
        progress: Callable[[Any], None],
    ) -> GoalEnd:
        handle = self._send(action, name, request, progress)
        if not handle.accepted:
            return GoalEnd(False, f"'{name}' refuses the goal; is navigation active?")
        result = handle.get_result_async()
        try:
            in_time = self._session.run_until(result.done, timeout, required=False)
        except KeyboardInterrupt:
            self._cancel(handle)
            raise
        if not in_time:
            self._cancel(handle)
            return GoalEnd(False, f"not done within {timeout:g} s, cancelled")
        return _end(result.result())

    def _send(self, action: Any, name: str, request: Any, progress: Callable[[Any], None]) -> Any:
        client = self._clients.get(name)
        if client is None:
            client = self._clients[name] = ActionClient(self._session.client, action, name)
        what = f"a server of '{name}'"
        wait_for(self._session, client.server_is_ready, _ANSWER_TIMEOUT, what, _CURE)
        sent = client.send_goal_async(
            request, feedback_callback=lambda message: progress(message.feedback)
        )
        self._session.run_until(sent.done, _ANSWER_TIMEOUT, "an answer to the goal")
        return sent.result()

    def _cancel(self, handle: Any) -> None:
        cancelled = handle.cancel_goal_async()
        self._session.run_until(cancelled.done, _ANSWER_TIMEOUT, "an answer to the cancellation")


def _end(answer: Any) -> GoalEnd:
    words = {GoalStatus.STATUS_CANCELED: "cancelled", GoalStatus.STATUS_ABORTED: "aborted"}
    if answer.status == GoalStatus.STATUS_SUCCEEDED:
        return GoalEnd(True)
    why = getattr(answer.result, "error_msg", "") or "no reason given"
    code = getattr(answer.result, "error_code", 0)
    return GoalEnd(False, f"{words.get(answer.status, 'ended')}: {why} ({code})")
