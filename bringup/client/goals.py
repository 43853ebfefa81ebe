"""Goals sent as any client would send them, by plain rclpy action clients."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np
from action_msgs.msg import GoalStatus
from geometry_msgs.msg import PoseWithCovariance, PoseWithCovarianceStamped
from nav2_msgs.action import NavigateToPose, Spin
from std_msgs.msg import String

from arjuna_core.errors import ArjunaError
from arjuna_core.ros import qos
from arjuna_core.ros.convert import (
    duration_msg,
    header,
    planar_covariance,
    pose_msg,
    pose_stamped,
)
from arjuna_core.ros.local.actions import action_client
from arjuna_core.se2 import SE2
from bringup.client.graph import action_server_state
from bringup.client.session import ClientError, Session

_REMEDY = "is 'python -m bringup nav --map FILE' running and active?"
ANSWER = 10.0
"""Time for a server to appear, and to answer a goal [s]."""
_ENDS = {GoalStatus.STATUS_CANCELED: "cancelled", GoalStatus.STATUS_ABORTED: "aborted"}


def initial_pose_msg(pose: SE2, metres: float, radians: float, now: float) -> Any:
    """Return what sets the pose that AMCL starts from, with its standard deviations."""
    covariance = planar_covariance(np.diag([metres**2, metres**2, radians**2]))
    estimate = PoseWithCovariance(pose=pose_msg(pose), covariance=covariance)
    return PoseWithCovarianceStamped(header=header("map", now), pose=estimate)


@contextmanager
def chosen(session: Session, what: str, name: str | None, timeout: float = 10.0) -> Iterator[None]:
    """Let navigation take a plug-in of a kind, as `controller`, meanwhile; None for no choice.

    It is asked for by Nav2's selector topic.

    Raises:
        ArjunaError: Nobody listens in time [s].
    """
    if name is None:
        yield
        return
    topic = f"{what}_selector"
    publisher = session.client.create_publisher(String, topic, qos.LATCHED)
    listeners = publisher.get_subscription_count
    session.wait_for(
        lambda: listeners() > 0, timeout, f"somebody who listens on '{topic}'", _REMEDY
    )

    def choose(choice: str) -> None:
        publisher.publish(String(data=choice))
        session.pause(0.1)  # it is sent

    choose(name)
    try:
        yield
    finally:
        choose("")  # the tree's own
        session.client.destroy_publisher(publisher)


@dataclass(frozen=True)
class GoalEnd:
    """The outcome of a goal.

    Attributes:
        reason: Why it was not; empty where it was.
        refused: Whether the server did not take it.
    """

    succeeded: bool
    reason: str = ""
    refused: bool = False


class Goals:
    """Sends goals and waits until they end."""

    def __init__(self, session: Session) -> None:
        self._session = session
        self._clients: dict[str, Any] = {}

    def navigate(
        self,
        goal: SE2,
        timeout: float,
        progress: Callable[[Any], None] = lambda feedback: None,
        frame: str = "map",
    ) -> GoalEnd:
        """Drive to a pose [m, m, rad] in a frame; cancelled after a time-out [s].

        `progress` takes nav2's feedback: distance_remaining, number_of_recoveries and more.
        """
        request = NavigateToPose.Goal(pose=pose_stamped(goal, frame, 0.0))
        return self._run(NavigateToPose, "navigate_to_pose", request, timeout, progress)

    def spin(self, angle: float, timeout: float) -> GoalEnd:
        """Turn on the spot by an angle [rad] within a time [s]."""
        request = Spin.Goal(target_yaw=angle, time_allowance=duration_msg(timeout))
        return self._run(Spin, "spin", request, timeout + ANSWER, lambda feedback: None)

    def _run(
        self, action: Any, name: str, request: Any, timeout: float, progress: Callable[[Any], None]
    ) -> GoalEnd:
        if name not in self._clients:
            self._clients[name] = action_client(self._session.client, action, name)
        goal = _Goal(self._session, self._clients[name], name, request)
        return goal.run(self._session.now + timeout, progress)


class _Goal:
    def __init__(self, session: Session, client: Any, name: str, request: Any) -> None:
        self._session, self._client, self._name = session, client, name
        self._request = request
        self._logger = session.client.get_logger()
        self._last_contact = session.now

    def run(self, deadline: float, progress: Callable[[Any], None]) -> GoalEnd:
        """Send it, and again where its server loses it, until a time [s]; return how it ended.

        Raises:
            ArjunaError: Nobody answers until the deadline.
        """
        self._deadline, self._progress = deadline, progress
        end = self._deliver()
        while end is None:
            self._logger.warning(
                f"the server of '{self._name}' has lost the goal: it is sent again"
            )
            end = self._deliver_again()
        return end

    def _deliver(self) -> GoalEnd | None:
        """Send it, once more where its server had still to be activated; None where it is lost."""
        end = self._attempt()
        if end is not None and end.refused:
            self._wait_until_active()
            end = self._attempt()
        return end

    def _deliver_again(self) -> GoalEnd | None:
        while True:
            try:
                return self._deliver()
            except ArjunaError:  # nobody answers, not yet
                if self._session.is_past(self._deadline):
                    raise

    @property
    def _remaining(self) -> float:
        return self._deadline - self._session.now

    def _wait_until_active(self) -> None:
        """Wait while the server's node is not active.

        Raises:
            ClientError: It is not activated in time.
        """
        session, name, warned = self._session, self._name, False
        last = min(self._deadline, session.now + 60.0)  # [s] to be activated
        while (state := action_server_state(session, name)) not in ("active", ""):
            if not warned:
                self._logger.warning(f"'{name}' is {state}: waiting until navigation is active")
                warned = True
            if session.now >= last:
                raise ClientError(f"'{name}' is still {state}; 'doctor' says what it lacks")
            session.pause(0.5)

    def _attempt(self) -> GoalEnd | None:
        """Send it and wait for its end; None where its server has lost it."""
        session, what = self._session, f"a server of '{self._name}'"
        session.wait_for(self._client.server_is_ready, ANSWER, what, _REMEDY)
        self._last_contact = session.now
        handle = session.send_goal(self._client, self._request, self._take)
        if not handle.accepted:
            reason = f"'{self._name}' refuses the goal: another goal runs, or it is not active"
            return GoalEnd(False, reason, refused=True)
        limit, result = self._remaining, handle.get_result_async()
        try:
            known = self._is_known_until_end(handle, result)
        except KeyboardInterrupt:
            session.cancel(handle)
            raise
        if not known:
            return None
        if result.done():
            return _end(result.result())
        session.cancel(handle)
        return GoalEnd(False, f"not done within {limit:g} s, cancelled")

    def _take(self, message: Any) -> None:
        self._last_contact = self._session.now
        self._progress(message.feedback)

    def _is_known_until_end(self, handle: Any, result: Any) -> bool:
        """Wait for a goal's result or the deadline; return whether the server has it until then.

        A server that died says nothing, and one that was started again does not know the goal.
        """
        session, warned = self._session, False

        def is_due() -> bool:
            # Servers send ten feedbacks a second: 10 s without one are a silence.
            return bool(result.done()) or session.now - self._last_contact > 10.0

        while True:
            session.run_until(is_due, self._remaining, required=False)
            if result.done():
                return bool(result.result().status != GoalStatus.STATUS_UNKNOWN)
            if session.is_past(self._deadline):
                return True
            if self._is_lost(handle):
                return False
            self._last_contact = session.now
            if not warned:
                warned = True
                self._logger.warning(
                    "the goal is taken, and nothing is heard of it yet; 'doctor' says what is"
                    " missing"
                )

    def _is_lost(self, handle: Any) -> bool:
        """Return whether the server has no such goal: one that only takes its time keeps it."""
        answer = handle.get_result_async()
        self._session.run_until(answer.done, 2.0, required=False)
        if answer.done():
            return bool(answer.result().status == GoalStatus.STATUS_UNKNOWN)
        return not self._client.server_is_ready()


def _end(answer: Any) -> GoalEnd:
    if answer.status == GoalStatus.STATUS_SUCCEEDED:
        return GoalEnd(True)
    why = getattr(answer.result, "error_msg", "") or "no reason given"
    code = getattr(answer.result, "error_code", 0)
    return GoalEnd(False, f"{_ENDS.get(answer.status, 'ended')}: {why} ({code})")
