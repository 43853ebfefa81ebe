"""Action servers of the local transport: ROS's own services and topics of an action."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from action_msgs.msg import GoalInfo, GoalStatus, GoalStatusArray
from action_msgs.srv import CancelGoal
from rclpy.action import CancelResponse, GoalResponse
from rclpy.qos import QoSProfile, qos_profile_action_status_default
from unique_identifier_msgs.msg import UUID

from arjuna_core.ros.local.services import Respond

_FEEDBACK = QoSProfile(depth=10)
_RUNNING = (
    GoalStatus.STATUS_ACCEPTED,
    GoalStatus.STATUS_EXECUTING,
    GoalStatus.STATUS_CANCELING,
)
_NANO = 1_000_000_000


class LocalGoalHandle:
    """A goal as its server sees it; what rclpy's ServerGoalHandle is.

    Attributes:
        request: The goal.
        goal_id: Its number.
        stamp: When it was accepted.
        status: A GoalStatus constant.
    """

    def __init__(self, server: LocalActionServer, request: Any, goal_id: UUID, stamp: Any) -> None:
        self._server = server
        self.request, self.goal_id, self.stamp = request, goal_id, stamp
        self.status: int = GoalStatus.STATUS_ACCEPTED
        self.ended_at = 0
        self.response: Any = None
        self.waiting: list[Respond] = []

    @property
    def info(self) -> GoalInfo:
        """Its number and when it was accepted."""
        return GoalInfo(goal_id=self.goal_id, stamp=self.stamp)

    @property
    def is_active(self) -> bool:
        """Whether it has not ended."""
        return self.status in _RUNNING

    @property
    def is_cancel_requested(self) -> bool:
        """Whether it is to be cancelled."""
        return bool(self.status == GoalStatus.STATUS_CANCELING)

    def become(self, status: int) -> None:
        """Take a state and publish it; one that has ended stays as it is."""
        if self.is_active:
            self.status = status
            self.ended_at = self._server.now
            self._server.publish_status()

    def execute(self) -> None:
        """Begin it, unless it is to be cancelled already."""
        if not self.is_cancel_requested:
            self.become(GoalStatus.STATUS_EXECUTING)

    def succeed(self) -> None:
        """End it as reached."""
        self.become(GoalStatus.STATUS_SUCCEEDED)

    def abort(self) -> None:
        """End it as aborted."""
        self.become(GoalStatus.STATUS_ABORTED)

    def canceled(self) -> None:
        """End it as cancelled."""
        self.become(GoalStatus.STATUS_CANCELED)

    def publish_feedback(self, feedback: Any) -> None:
        """Publish feedback on it."""
        self._server.publish_feedback(self.goal_id, feedback)


class LocalActionServer:
    """An action's server whose goals stay executing until `finish`.

    Args:
        node: The node.
        action_type: The action.
        name: Its name.
        goal_callback: Given a goal, says whether it is accepted.
        handle_accepted_callback: Takes the handle of one that was.
        cancel_callback: Given a handle, says whether it may be cancelled.
        result_timeout: How long a result is kept [s].
        options: What rclpy's server needs beyond.
    """

    def __init__(
        self,
        node: Any,
        action_type: Any,
        name: str,
        *,
        goal_callback: Callable[[Any], Any],
        handle_accepted_callback: Callable[[Any], None],
        cancel_callback: Callable[[Any], Any],
        result_timeout: float,
        **options: Any,
    ) -> None:
        self._node = node
        self._impl = impl = action_type.Impl
        self._on_goal, self._on_accepted = goal_callback, handle_accepted_callback
        self._on_cancel = cancel_callback
        self._kept_ns = round(result_timeout * _NANO)
        self._goal_handles: dict[bytes, LocalGoalHandle] = {}
        serve, door = node.create_deferred_service, f"{name}/_action/"
        self._services = [
            serve(impl.SendGoalService, f"{door}send_goal", self._take_goal),
            serve(impl.CancelGoalService, f"{door}cancel_goal", self._take_cancellation),
            serve(impl.GetResultService, f"{door}get_result", self._take_result_request),
        ]
        publisher = node.create_publisher
        self._feedback_out = publisher(impl.FeedbackMessage, f"{door}feedback", _FEEDBACK)
        self._status_out = publisher(
            GoalStatusArray, f"{door}status", qos_profile_action_status_default
        )

    @property
    def now(self) -> int:
        """The node's time [ns]."""
        return int(self._node.get_clock().now().nanoseconds)

    def _take_goal(self, request: Any, respond: Respond) -> None:
        self._forget_old()
        key, handle = bytes(request.goal_id.uuid), None
        if key not in self._goal_handles and self._on_goal(request.goal) == GoalResponse.ACCEPT:
            stamp = self._node.get_clock().now().to_msg()
            handle = LocalGoalHandle(self, request.goal, request.goal_id, stamp)
            self._goal_handles[key] = handle
        response = self._impl.SendGoalService.Response(accepted=handle is not None)
        if handle is not None:
            response.stamp = handle.stamp
        respond(response)
        if handle is not None:
            self.publish_status()
            self._on_accepted(handle)

    def _take_cancellation(self, request: Any, respond: Respond) -> None:
        response = CancelGoal.Response()
        for handle in self._named(request.goal_info, response):
            if self._on_cancel(handle) == CancelResponse.ACCEPT:
                handle.become(GoalStatus.STATUS_CANCELING)
                response.goals_canceling.append(handle.info)
        respond(response)

    def _named(self, info: Any, response: Any) -> list[LocalGoalHandle]:
        """Return the goals that a request to cancel names, as rcl does."""
        key, until = bytes(info.goal_id.uuid), _ns(info.stamp)
        running = [
            g for g in self._goal_handles.values() if g.is_active and not g.is_cancel_requested
        ]
        if any(key) and not until:
            known = key in self._goal_handles
            codes = CancelGoal.Response
            code = codes.ERROR_GOAL_TERMINATED if known else codes.ERROR_UNKNOWN_GOAL_ID
            found = [goal for goal in running if bytes(goal.goal_id.uuid) == key]
            response.return_code = codes.ERROR_NONE if found else code
            return found
        return [
            goal
            for goal in running
            if not until or _ns(goal.stamp) <= until or bytes(goal.goal_id.uuid) == key
        ]

    def _take_result_request(self, request: Any, respond: Respond) -> None:
        self._forget_old()
        handle = self._goal_handles.get(bytes(request.goal_id.uuid))
        if handle is None:
            unknown = GoalStatus.STATUS_UNKNOWN
            respond(self._impl.GetResultService.Response(status=unknown))
        elif handle.response is not None:
            respond(handle.response)
        else:
            handle.waiting.append(respond)

    def finish(self, handle: LocalGoalHandle, result: Any) -> None:
        """Send the result of a goal whose final state is set."""
        response = self._impl.GetResultService.Response(status=handle.status, result=result)
        handle.response = response
        for respond in handle.waiting:
            respond(response)
        handle.waiting.clear()

    def _forget_old(self) -> None:
        """Forget results that were kept long enough."""
        before = self.now - self._kept_ns
        self._goal_handles = {
            key: goal
            for key, goal in self._goal_handles.items()
            if goal.is_active or goal.ended_at >= before
        }

    def publish_status(self) -> None:
        """Publish the states of all goals."""
        message = GoalStatusArray()
        for goal in self._goal_handles.values():
            message.status_list.append(GoalStatus(goal_info=goal.info, status=goal.status))
        self._status_out.publish(message)

    def publish_feedback(self, goal_id: UUID, feedback: Any) -> None:
        """Publish feedback on a goal."""
        self._feedback_out.publish(self._impl.FeedbackMessage(goal_id=goal_id, feedback=feedback))

    def destroy(self) -> None:
        """Take no more goals."""
        for service in self._services:
            self._node.destroy_service(service)
        for publisher in (self._feedback_out, self._status_out):
            self._node.destroy_publisher(publisher)


def _ns(stamp: Any) -> int:
    return int(stamp.sec) * _NANO + int(stamp.nanosec)
