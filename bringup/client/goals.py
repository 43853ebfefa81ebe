"""Goals sent as any client would send them, by plain rclpy action clients."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from action_msgs.msg import GoalStatus
from nav2_msgs.action import NavigateToPose, Spin
from rclpy.action import ActionClient

from arjuna_core.errors import ArjunaError
from arjuna_core.ros.convert import duration_msg, pose_stamped
from arjuna_core.se2 import SE2
from bringup.client.session import Session, wait_for

_ANSWER_TIMEOUT = 10.0
_SILENCE = 10.0  # [s] between two feedbacks, of which servers send ten a second
_PAUSE = 0.5  # [s] until a server that refused a goal is asked again
_CURE = "is 'python -m bringup nav --map FILE' running and active?"


@dataclass(frozen=True)
class GoalEnd:
    """How a goal ended.

    Attributes:
        succeeded: Whether it was reached.
        reason: Why it was not; empty where it was.
        refused: Whether the server did not take it.
    """

    succeeded: bool
    reason: str = ""
    refused: bool = False


@dataclass(frozen=True)
class _Order:
    """A goal, to whom it is sent, until when [s], and who takes its feedback."""

    action: Any
    name: str
    request: Any
    deadline: float
    progress: Callable[[Any], None]


class _Watch:
    """Notices that nothing is heard of a goal any more: a server that died says nothing.

    Args:
        session: Whose time counts.
        progress: Takes the feedback as well.
    """

    def __init__(self, session: Session, progress: Callable[[Any], None]) -> None:
        self._session = session
        self._progress = progress
        self._heard = session.now

    def hear(self, feedback: Any) -> None:
        """Take feedback."""
        self._heard = self._session.now
        self._progress(feedback)

    def is_silent(self) -> bool:
        """Tell whether nothing has been heard for too long."""
        return self._session.now - self._heard > _SILENCE


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
        order = _Order(action, name, request, self._session.now + timeout, progress)
        end = self._attempt(order)
        while end is None:
            self._session.client.get_logger().warning(
                f"nothing is heard of the goal of '{name}' for {_SILENCE:g} s: it is sent again"
            )
            end = self._again(order)
        return end

    def _again(self, order: _Order) -> GoalEnd | None:
        """Send a goal again, until a server that comes up takes it."""
        session = self._session
        while True:
            try:
                end = self._attempt(order)
            except ArjunaError:  # nobody answers, not yet
                if session.now >= order.deadline:
                    raise
                continue
            if end is None or not end.refused or session.now >= order.deadline:
                return end
            session.run_until(lambda: False, _PAUSE, required=False)

    def _attempt(self, order: _Order) -> GoalEnd | None:
        """Send a goal and wait for its end; None where its server is heard no more."""
        session = self._session
        watch = _Watch(session, order.progress)
        handle = self._send(order, watch.hear)
        if not handle.accepted:
            reason = f"'{order.name}' refuses the goal; is navigation active?"
            return GoalEnd(False, reason, refused=True)
        result = handle.get_result_async()
        begun = session.now
        try:
            session.run_until(
                lambda: result.done() or watch.is_silent(), order.deadline - begun, required=False
            )
        except KeyboardInterrupt:
            self._cancel(handle)
            raise
        if result.done():
            return _end(result.result())
        if session.now < order.deadline:
            return None
        self._cancel(handle)
        return GoalEnd(False, f"not done within {order.deadline - begun:g} s, cancelled")

    def _send(self, order: _Order, progress: Callable[[Any], None]) -> Any:
        name = order.name
        client = self._clients.get(name)
        if client is None:
            client = self._clients[name] = ActionClient(self._session.client, order.action, name)
        what = f"a server of '{name}'"
        wait_for(self._session, client.server_is_ready, _ANSWER_TIMEOUT, what, _CURE)
        sent = client.send_goal_async(
            order.request, feedback_callback=lambda message: progress(message.feedback)
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
