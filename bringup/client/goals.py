"""Goals sent as any client would send them, by plain rclpy action clients."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from action_msgs.msg import GoalStatus
from nav2_msgs.action import NavigateToPose, Spin

from arjuna_core.errors import ArjunaError
from arjuna_core.ros.convert import duration_msg, pose_stamped
from arjuna_core.ros.local.action_client import action_client
from arjuna_core.se2 import SE2
from bringup.client.graph import action_server_state
from bringup.client.session import ClientError, Session, wait_for

_ANSWER_TIMEOUT = 10.0
_SILENCE = 10.0  # [s] between two feedbacks, of which servers send ten a second
_PAUSE = 0.5  # [s] until a server that is not active is asked again
_PROBE = 2.0  # [s] for a server to say whether it has a goal
_ACTIVATION = 60.0  # [s] for navigation to be activated
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
        self._said = False

    def hear(self, feedback: Any) -> None:
        """Take feedback."""
        self._heard = self._session.now
        self._progress(feedback)

    def is_silent(self) -> bool:
        """Tell whether nothing has been heard for too long."""
        return self._session.now - self._heard > _SILENCE

    def wait_on(self) -> None:
        """Wait as long again: the server has the goal; say so once."""
        self._heard = self._session.now
        if not self._said:
            self._said = True
            self._session.client.get_logger().warning(
                "the goal is taken, and nothing is heard of it yet; 'doctor' says what is missing"
            )


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
        end = self._deliver(order)
        while end is None:
            self._say(f"the server of '{name}' has lost the goal: it is sent again")
            end = self._again(order)
        return end

    def _say(self, text: str) -> None:
        self._session.client.get_logger().warning(text)

    def _again(self, order: _Order) -> GoalEnd | None:
        """Send a goal again, until a server that comes up takes it."""
        while True:
            try:
                return self._deliver(order)
            except ArjunaError:  # nobody answers, not yet
                if self._session.now >= order.deadline:
                    raise

    def _deliver(self, order: _Order) -> GoalEnd | None:
        """Send a goal, once more where its server had still to be activated."""
        end = self._attempt(order)
        if end is not None and end.refused:
            self._wait_until_active(order)
            end = self._attempt(order)
        return end

    def _wait_until_active(self, order: _Order) -> None:
        """Wait while the server's node is not active.

        Raises:
            ClientError: It is not activated in time.
        """
        session, said = self._session, False
        last = min(order.deadline, session.now + _ACTIVATION)
        while (state := action_server_state(session, order.name)) not in ("active", ""):
            if not said:
                self._say(f"'{order.name}' is {state}: waiting until navigation is active")
                said = True
            if session.now >= last:
                raise ClientError(f"'{order.name}' is still {state}; 'doctor' says what it lacks")
            session.run_until(lambda: False, _PAUSE, required=False)

    def _attempt(self, order: _Order) -> GoalEnd | None:
        """Send a goal and wait for its end; None where its server has lost it."""
        session = self._session
        watch = _Watch(session, order.progress)
        handle = self._send(order, watch.hear)
        if not handle.accepted:
            reason = f"'{order.name}' refuses the goal: another goal runs, or it is not active"
            return GoalEnd(False, reason, refused=True)
        result, begun = handle.get_result_async(), session.now
        try:
            while not self._ends(result, watch, order.deadline) and session.now < order.deadline:
                if self._is_lost(order, handle):
                    return None
                watch.wait_on()
        except KeyboardInterrupt:
            self._cancel(handle)
            raise
        if result.done():
            answer = result.result()
            return None if answer.status == GoalStatus.STATUS_UNKNOWN else _end(answer)
        self._cancel(handle)
        return GoalEnd(False, f"not done within {order.deadline - begun:g} s, cancelled")

    def _ends(self, result: Any, watch: _Watch, deadline: float) -> bool:
        """Wait for a goal's result until it comes, nothing is heard of it or its time is over."""
        left = deadline - self._session.now
        self._session.run_until(lambda: result.done() or watch.is_silent(), left, required=False)
        return bool(result.done())

    def _is_lost(self, order: _Order, handle: Any) -> bool:
        """Return whether the server has no such goal: one that only takes its time keeps it."""
        answer, client = handle.get_result_async(), self._clients[order.name]
        self._session.run_until(answer.done, _PROBE, required=False)
        if answer.done():
            return bool(answer.result().status == GoalStatus.STATUS_UNKNOWN)
        return not client.server_is_ready()

    def _send(self, order: _Order, progress: Callable[[Any], None]) -> Any:
        name = order.name
        client = self._clients.get(name)
        if client is None:
            client = self._clients[name] = action_client(self._session.client, order.action, name)
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
