"""Navigation seen from outside: the current goal and its end, whoever gave it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

from action_msgs.msg import GoalInfo, GoalStatus, GoalStatusArray
from action_msgs.srv import CancelGoal
from nav2_msgs.action import FollowWaypoints, NavigateThroughPoses, NavigateToPose
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from unique_identifier_msgs.msg import UUID

from arjuna_core.ros import qos
from arjuna_core.ros.convert import pose_stamped, seconds
from arjuna_core.se2 import SE2
from bringup.viewing.robot.services import Services

_ACTIONS = {"navigate_to_pose": NavigateToPose, "navigate_through_poses": NavigateThroughPoses}
_ENDS = {
    GoalStatus.STATUS_SUCCEEDED: "arrived",
    GoalStatus.STATUS_CANCELED: "cancelled",
    GoalStatus.STATUS_ABORTED: "failed",
}
_FEEDBACK = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)


@dataclass(frozen=True)
class Navigation:
    """The state of the last goal, whoever gave it.

    Attributes:
        distance: Left to drive [m].
        time: Since it started [s].
        recoveries: How often it had to recover.
    """

    state: str = "no goal"
    distance: float | None = None
    time: float | None = None
    recoveries: int = 0
    error: str = ""

    def ended(self, status: int, code: int, message: str) -> Navigation:
        """Return the state after a goal's end: a GoalStatus, the action's code and its reason."""
        reason = message or ("" if code == 0 else f"error code {code}")
        return replace(self, state=_ENDS.get(status, "over"), distance=None, error=reason)

    def text(self) -> str:
        """Return it as Markdown."""
        lines = [f"**{self.state}**"]
        if self.distance is not None:
            lines.append(f"{self.distance:.2f} m to go")
        if self.time is not None:
            lines.append(f"{self.time:.0f} s, recoveries: {self.recoveries}")
        text = " · ".join(lines)
        return f"{text}\n\n⚠ {self.error}" if self.error else text


class NavigationWatch:
    """Follows the navigator's actions, whoever uses them, and sends goals.

    It speaks the actions' own services and topics: an ActionClient hears only of its own goals.
    """

    def __init__(self, node: Node, services: Services) -> None:
        self._node = node
        self._services = services
        self._followed = UUID()
        self._open: list[Any] = []
        self.state = Navigation()

    def listen(self, wanted: bool) -> None:
        """Subscribe, or stop listening."""
        if wanted and not self._open:
            for name, action in _ACTIONS.items():
                self._subscribe(name, action)
        elif not wanted:
            while self._open:
                self._node.destroy_subscription(self._open.pop())

    def _subscribe(self, name: str, action: Any) -> None:
        create, topic = self._node.create_subscription, f"{name}/_action"
        kind, follow = action.Impl.FeedbackMessage, partial(self._on_status, name, action)
        self._open.append(create(kind, f"{topic}/feedback", self._on_feedback, _FEEDBACK))
        self._open.append(create(GoalStatusArray, f"{topic}/status", follow, qos.LATCHED))

    def _on_feedback(self, message: Any) -> None:
        feedback = message.feedback
        self.state = replace(
            self.state,
            state="driving",
            distance=feedback.distance_remaining,
            time=seconds(feedback.navigation_time),
            recoveries=feedback.number_of_recoveries,
        )

    def _on_status(self, name: str, action: Any, message: Any) -> None:
        """Ask for the result of the newest goal, which comes when the goal ends."""
        if not message.status_list:
            return
        newest = max(message.status_list, key=lambda item: seconds(item.goal_info.stamp))
        identity = newest.goal_info.goal_id
        if newest.status in _ENDS or identity == self._followed:
            return
        self._followed, self.state = identity, Navigation("driving")
        kind = action.Impl.GetResultService
        self._services.ask(
            *(kind, f"{name}/_action/get_result", kind.Request(goal_id=identity)),
            *(self._on_result, 3600.0),
        )

    def _on_result(self, response: Any) -> None:
        result = response.result
        self.state = self.state.ended(response.status, result.error_code, result.error_msg)

    def published(self, topic: str, listeners: Iterable[str]) -> None:
        """Take note of a goal that was published for nodes that listen."""
        names = ", ".join(sorted(listeners)) or "nobody"
        self.state = Navigation(f"sent on {topic}, where {names} listens")

    def send(self, goals: Sequence[SE2], frame: str, action: str = "navigate_to_pose") -> None:
        """Ask for a pose in a frame, or for several by an action that takes them."""
        poses = [pose_stamped(goal, frame, 0.0) for goal in goals]
        kind = _ACTIONS.get(action, FollowWaypoints)
        wanted = {"pose": poses[0]} if kind is NavigateToPose else {"poses": poses}
        # the clock's time is unique enough for one person's clicks
        identity = self._node.get_clock().now().nanoseconds.to_bytes(16, "big")
        ask = kind.Impl.SendGoalService
        request = ask.Request(goal_id=UUID(uuid=list(identity)), goal=kind.Goal(**wanted))
        if self._services.ask(ask, f"{action}/_action/send_goal", request, self._on_accepted):
            self.state = Navigation("sent")
        else:
            self._refuse("no navigator is running; start one with 'python -m bringup nav'")

    def _on_accepted(self, response: Any) -> None:
        if not response.accepted:
            self._refuse("the navigator rejects the goal: is it active?")

    def _refuse(self, reason: str) -> None:
        self.state = Navigation("no goal", error=reason)

    def cancel(self) -> None:
        """Cancel every goal, whoever gave it."""
        for name in (*_ACTIONS, "follow_waypoints"):
            request = CancelGoal.Request(goal_info=GoalInfo())  # zero means all
            self._services.ask(
                CancelGoal, f"{name}/_action/cancel_goal", request, lambda response: None
            )
