"""Navigation seen from outside: the goal under way and its end, whoever gave it."""

from __future__ import annotations

from functools import partial
from typing import Any

from action_msgs.msg import GoalInfo, GoalStatus, GoalStatusArray
from action_msgs.srv import CancelGoal
from nav2_msgs.action import NavigateThroughPoses, NavigateToPose
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from unique_identifier_msgs.msg import UUID

from arjuna_core.ros import qos
from arjuna_core.ros.convert import pose_stamped, seconds
from arjuna_core.se2 import SE2
from bringup.viewing.drawing.status import Navigation
from bringup.viewing.robot.services import Services

_ACTIONS = {"navigate_to_pose": NavigateToPose, "navigate_through_poses": NavigateThroughPoses}
_CANCELLED_TOO = (*_ACTIONS, "follow_waypoints")
_OVER = {GoalStatus.STATUS_SUCCEEDED, GoalStatus.STATUS_CANCELED, GoalStatus.STATUS_ABORTED}
_RESULT_DEADLINE = 3600.0
_FEEDBACK = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)


class NavigationWatch:
    """Follows what the navigator's actions say to everybody, and sends goals.

    It speaks the actions' own services and topics: an ActionClient hears only of its own goals.

    Args:
        node: The viewer's node.
        services: Its service clients.
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
        kind, topic = action.Impl.FeedbackMessage, f"{name}/_action/feedback"
        status = f"{name}/_action/status"
        follow = partial(self._on_status, name, action)
        create = self._node.create_subscription
        self._open.append(create(kind, topic, self._on_feedback, _FEEDBACK))
        self._open.append(create(GoalStatusArray, status, follow, qos.LATCHED))

    def _on_feedback(self, message: Any) -> None:
        told = message.feedback
        time = seconds(told.navigation_time)
        self.state = self.state.driving(told.distance_remaining, time, told.number_of_recoveries)

    def _on_status(self, name: str, action: Any, message: Any) -> None:
        """Ask for the result of the newest goal, which comes when the goal ends."""
        if not message.status_list:
            return
        newest = max(message.status_list, key=lambda item: seconds(item.goal_info.stamp))
        identity = newest.goal_info.goal_id
        if newest.status not in _OVER and identity != self._followed:
            self._follow(name, action, identity)

    def _follow(self, name: str, action: Any, identity: UUID) -> None:
        self._followed = identity
        self.state = Navigation("driving")
        kind = action.Impl.GetResultService
        request = kind.Request(goal_id=identity)
        self._services.ask(
            kind, f"{name}/_action/get_result", request, self._on_result, _RESULT_DEADLINE
        )

    def _on_result(self, response: Any) -> None:
        result = response.result
        self.state = self.state.ended(response.status, result.error_code, result.error_msg)

    def send(self, goal: SE2, frame: str) -> None:
        """Ask the navigator to drive to a pose in a frame."""
        kind = NavigateToPose.Impl.SendGoalService
        identity = UUID(uuid=self._new_identity())
        request = kind.Request(
            goal_id=identity, goal=NavigateToPose.Goal(pose=pose_stamped(goal, frame, 0.0))
        )
        asked = self._services.ask(
            kind, "navigate_to_pose/_action/send_goal", request, self._on_accepted
        )
        self.state = Navigation("sent" if asked else "no goal")
        if not asked:
            self._refuse("no navigator is running; start one with 'python -m bringup nav'")

    def _new_identity(self) -> list[int]:
        """Return a goal's identity: the clock's time is unique enough for one person's clicks."""
        stamp = self._node.get_clock().now().nanoseconds
        return list(stamp.to_bytes(16, "big"))

    def _on_accepted(self, response: Any) -> None:
        if not response.accepted:
            self._refuse("the navigator rejects the goal: is it active?")

    def _refuse(self, reason: str) -> None:
        self.state = Navigation("no goal", error=reason)

    def cancel(self) -> None:
        """Cancel every goal, whoever gave it."""
        for name in _CANCELLED_TOO:
            request = CancelGoal.Request(goal_info=GoalInfo())  # zero means all
            self._services.ask(
                CancelGoal, f"{name}/_action/cancel_goal", request, lambda response: None
            )
