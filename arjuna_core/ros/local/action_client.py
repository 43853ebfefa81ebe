"""Action clients of the local transport: ROS's own services and topics of an action."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from action_msgs.msg import GoalInfo, GoalStatus, GoalStatusArray
from action_msgs.srv import CancelGoal
from rclpy.action import ActionClient, get_action_server_names_and_types_by_node
from rclpy.action.client import ClientGoalHandle
from rclpy.qos import QoSProfile, qos_profile_action_status_default
from rclpy.task import Future
from unique_identifier_msgs.msg import UUID

_SEND = "/_action/send_goal"
_FEEDBACK = QoSProfile(depth=10)
_ENDED = (GoalStatus.STATUS_SUCCEEDED, GoalStatus.STATUS_CANCELED, GoalStatus.STATUS_ABORTED)


def action_client(node: Any, action_type: Any, name: str, **profiles: Any) -> Any:
    """Return an action client of the transport that a node speaks through.

    Args:
        node: The node.
        action_type: The action.
        name: Its name.
        profiles: QoS of its parts, as rclpy's ActionClient takes them.
    """
    if getattr(node, "transport", None) is None:
        return ActionClient(node, action_type, name, **profiles)
    return LocalActionClient(node, action_type, name)


def served_actions(asker: Any, name: str, namespace: str) -> list[str]:
    """Return the actions that a node serves.

    Args:
        asker: The node that wants to know.
        name: The server's node.
        namespace: Its namespace.
    """
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
    """An action's client; what rclpy's ActionClient is to its owner.

    Args:
        node: The node.
        action_type: The action.
        name: Its name.
    """

    def __init__(self, node: Any, action_type: Any, name: str) -> None:
        self._node = node
        self._impl = impl = action_type.Impl
        self._handles: dict[bytes, ClientGoalHandle] = {}
        self._feedback: dict[bytes, Callable[[Any], Any]] = {}
        client, door = node.create_client, f"{name}/_action/"
        self._goal_client = client(impl.SendGoalService, f"{door}send_goal")
        self._cancel_client = client(impl.CancelGoalService, f"{door}cancel_goal")
        self._result_client = client(impl.GetResultService, f"{door}get_result")
        self._subscriptions = [
            node.create_subscription(
                impl.FeedbackMessage, f"{door}feedback", self._take_feedback, _FEEDBACK
            ),
            node.create_subscription(
                GoalStatusArray,
                f"{door}status",
                self._take_status,
                qos_profile_action_status_default,
            ),
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
