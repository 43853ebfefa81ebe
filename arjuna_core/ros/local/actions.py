"""Actions of the local transport: ROS's own services and topics of an action."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from action_msgs.msg import GoalInfo, GoalStatus, GoalStatusArray
from action_msgs.srv import CancelGoal
from rclpy.action import (
    ActionClient,
    CancelResponse,
    GoalResponse,
    get_action_server_names_and_types_by_node,
)
from rclpy.action.client import ClientGoalHandle
from rclpy.qos import QoSProfile, qos_profile_action_status_default
from rclpy.task import Future
from unique_identifier_msgs.msg import UUID

from arjuna_core.ros.local.services import Respond
from arjuna_core.timing import NANOSECONDS

_SEND = "/_action/send_goal"
_FEEDBACK = QoSProfile(depth=10)
_CANCELING = GoalStatus.STATUS_CANCELING  # asked each tick, and a function of Python's each time
_RUNNING = (GoalStatus.STATUS_ACCEPTED, GoalStatus.STATUS_EXECUTING, _CANCELING)
_ENDED = (GoalStatus.STATUS_SUCCEEDED, GoalStatus.STATUS_CANCELED, GoalStatus.STATUS_ABORTED)


def action_client(node: Any, action_type: Any, name: str, **profiles: Any) -> Any:
    """Return an action client of a node's transport; profiles are those of rclpy's ActionClient."""
    if getattr(node, "transport", None) is None:
        return ActionClient(node, action_type, name, **profiles)
    return LocalActionClient(node, action_type, name)


def served_actions(asker: Any, name: str, namespace: str) -> list[str]:
    """Return the actions that a node of a name and namespace serves, as another node sees it."""
    if getattr(asker, "transport", None) is None:
        return [
            each for each, _ in get_action_server_names_and_types_by_node(asker, name, namespace)
        ]
    full_name = f"{namespace.rstrip('/')}/{name}"
    return [
        service.removesuffix(_SEND)
        for service, found in asker.transport.services.items()
        if service.endswith(_SEND)
        and any(each.node.get_fully_qualified_name() == full_name for each in found)
    ]


class LocalActionClient:
    """An action's client; what rclpy's ActionClient is to its owner."""

    def __init__(self, node: Any, action_type: Any, name: str) -> None:
        self._node = node
        self._impl = impl = action_type.Impl
        self._handles: dict[bytes, ClientGoalHandle] = {}
        self._feedback: dict[bytes, Callable[[Any], Any]] = {}
        client, listen, door = node.create_client, node.create_subscription, f"{name}/_action/"
        self._goal_client = client(impl.SendGoalService, f"{door}send_goal")
        self._cancel_client = client(impl.CancelGoalService, f"{door}cancel_goal")
        self._result_client = client(impl.GetResultService, f"{door}get_result")
        status = qos_profile_action_status_default
        self._subscriptions = [
            listen(impl.FeedbackMessage, f"{door}feedback", self._take_feedback, _FEEDBACK),
            listen(GoalStatusArray, f"{door}status", self._take_status, status),
        ]

    def server_is_ready(self) -> bool:
        """Return whether a server is there."""
        return bool(self._goal_client.service_is_ready())

    def wait_for_server(self, timeout_sec: float | None = None) -> bool:
        """Return whether a server is there; none comes while a callback runs."""
        return self.server_is_ready()

    def send_goal_async(
        self,
        goal: Any,
        feedback_callback: Callable[[Any], Any] | None = None,
        goal_uuid: UUID | None = None,
    ) -> Future:
        """Send a goal; the future returned takes its handle."""
        goal_id = goal_uuid or self._node.transport.new_uuid()
        if feedback_callback is not None:
            self._feedback[bytes(goal_id.uuid)] = feedback_callback
        request = self._impl.SendGoalService.Request(goal_id=goal_id, goal=goal)
        return self._ask(self._goal_client, request, partial(self._handle_of, goal_id))

    def _ask(self, client: Any, request: Any, read: Callable[[Any], Any]) -> Future:
        """Send a request; the future returned takes what is read from the response.

        It takes it a turn later than a service's client would, as rclpy's actions do.
        """
        answered = Future(executor=self._node.executor)
        client.call_async(request).add_done_callback(
            lambda sent: answered.set_result(read(sent.result()))
        )
        return answered

    def _handle_of(self, goal_id: UUID, response: Any) -> ClientGoalHandle:
        handle = ClientGoalHandle(self, goal_id, response)
        if handle.accepted:
            self._handles[bytes(goal_id.uuid)] = handle
        else:
            self._feedback.pop(bytes(goal_id.uuid), None)
        return handle

    def _cancel_goal_async(self, handle: ClientGoalHandle) -> Future:
        request = CancelGoal.Request(goal_info=GoalInfo(goal_id=handle.goal_id))
        return self._ask(self._cancel_client, request, lambda response: response)

    def _get_result_async(self, handle: ClientGoalHandle) -> Future:
        request = self._impl.GetResultService.Request(goal_id=handle.goal_id)
        return self._ask(self._result_client, request, partial(self._result_of, handle))

    def _result_of(self, handle: ClientGoalHandle, response: Any) -> Any:
        self._feedback.pop(bytes(handle.goal_id.uuid), None)
        return response

    def _take_feedback(self, message: Any) -> None:
        callback = self._feedback.get(bytes(message.goal_id.uuid))
        if callback is not None:
            self._node.executor.put(partial(callback, message))

    def _take_status(self, message: Any) -> None:
        for each in message.status_list:
            handle = self._handles.get(bytes(each.goal_info.goal_id.uuid))
            if handle is not None:
                handle._status = each.status
                if each.status in _ENDED:
                    del self._handles[bytes(handle.goal_id.uuid)]

    def destroy(self) -> None:
        """Take no more answers."""
        for client in (self._goal_client, self._cancel_client, self._result_client):
            self._node.destroy_client(client)
        for subscription in self._subscriptions:
            self._node.destroy_subscription(subscription)


class LocalGoalHandle:
    """A goal as its server sees it; what rclpy's ServerGoalHandle is."""

    def __init__(self, server: LocalActionServer, request: Any, info: GoalInfo) -> None:
        self._server = server
        self.request, self.info, self.goal_id = request, info, info.goal_id
        self.status: int = GoalStatus.STATUS_ACCEPTED
        self.ended_at = 0
        self.response: Any = None
        self.waiting: list[Respond] = []

    @property
    def is_active(self) -> bool:
        """True until it has ended."""
        return self.status in _RUNNING

    @property
    def is_cancel_requested(self) -> bool:
        """True where it is to be cancelled."""
        return self.status == _CANCELING  # type: ignore[no-any-return]

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

    def publish_feedback(self, feedback: Any) -> None:
        """Publish feedback on it."""
        self._server.publish_feedback(self.goal_id, feedback)


class LocalActionServer:
    """An action's server whose goals stay executing until `finish`; arguments are rclpy's."""

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
        self._kept_ns = round(result_timeout * NANOSECONDS)
        self._goal_handles: dict[bytes, LocalGoalHandle] = {}
        serve, publisher, door = node.create_deferred_service, node.create_publisher, "/_action/"
        self._services = [
            serve(impl.SendGoalService, f"{name}{door}send_goal", self._take_goal),
            serve(impl.CancelGoalService, f"{name}{door}cancel_goal", self._take_cancellation),
            serve(impl.GetResultService, f"{name}{door}get_result", self._take_result_request),
        ]
        status = qos_profile_action_status_default
        self._feedback_out = publisher(impl.FeedbackMessage, f"{name}{door}feedback", _FEEDBACK)
        self._status_out = publisher(GoalStatusArray, f"{name}{door}status", status)

    @property
    def now(self) -> int:
        """The node's time [ns]."""
        return int(self._node.get_clock().now().nanoseconds)

    def _take_goal(self, request: Any, respond: Respond) -> None:
        self._forget_old()
        key, response = bytes(request.goal_id.uuid), self._impl.SendGoalService.Response()
        if key in self._goal_handles or self._on_goal(request.goal) != GoalResponse.ACCEPT:
            respond(response)
            return
        response.accepted, response.stamp = True, self._node.get_clock().now().to_msg()
        info = GoalInfo(goal_id=request.goal_id, stamp=response.stamp)
        handle = self._goal_handles[key] = LocalGoalHandle(self, request.goal, info)
        respond(response)
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
            codes = CancelGoal.Response
            known = key in self._goal_handles
            code = codes.ERROR_GOAL_TERMINATED if known else codes.ERROR_UNKNOWN_GOAL_ID
            found = [goal for goal in running if bytes(goal.goal_id.uuid) == key]
            response.return_code = codes.ERROR_NONE if found else code
            return found
        return [
            goal
            for goal in running
            if not until or _ns(goal.info.stamp) <= until or bytes(goal.goal_id.uuid) == key
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

    def finish(self, handle: LocalGoalHandle, status: int, result: Any) -> None:
        """End a goal in a final state and send its result."""
        handle.become(status)
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
        states = [
            GoalStatus(goal_info=g.info, status=g.status) for g in self._goal_handles.values()
        ]
        self._status_out.publish(GoalStatusArray(status_list=states))

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
    return int(stamp.sec) * NANOSECONDS + int(stamp.nanosec)
