"""Services that clients call and those that they serve, and goals of actions that they send."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from action_msgs.msg import GoalStatus
from rclpy.action import ActionClient
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.task import Future

from bringup.ros2.errors import Ros2Error
from bringup.ros2.rosbridge.rosapi import RosApi
from bringup.ros2.rosbridge.topics import absolute
from bringup.ros2.rosbridge.values import filled, to_json
from bringup.ros2.types import interface_class
from bringup.viewing.foxglove.server import Client

_THERE = 1.0  # [s] in which a service that is there is found


def _named(message: Any) -> dict[str, Any]:
    return {"id": message["id"]} if message.get("id") is not None else {}


class Calls:
    """Calls services for clients."""

    def __init__(self, node: Node, now: Callable[[], Any]) -> None:
        self._node, self._now = node, now
        self._api = RosApi(node, self._send)
        self._clients: dict[str, tuple[Any, Any]] = {}

    def call(self, client: Client, message: Any) -> None:
        """Call a service, or answer for rosapi; the answer is sent when it comes, or why not."""
        name = str(message["service"])
        fields = {"service": name, **_named(message)}

        def answered(values: Any, result: bool = True) -> None:
            client.send_message("service_response", **fields, values=values, result=result)

        args = message.get("args") or {}
        try:
            if self._api.answers(absolute(name)):
                self._api.call(absolute(name), args, answered)
            else:
                self._send(absolute(name), args, lambda response: answered(to_json(response)))
        except (Ros2Error, LookupError, ValueError) as error:
            answered(str(error), False)

    def _send(self, name: str, args: Any, then: Callable[[Any], None]) -> None:
        found = dict(self._node.get_service_names_and_types()).get(name)
        if not found:
            raise Ros2Error(f"Service {name} does not exist")
        if name not in self._clients:
            kind = interface_class(found[0], "srv")
            self._clients[name] = kind, self._node.create_client(kind, name)
        kind, caller = self._clients[name]
        request = kind.Request()
        if isinstance(args, list):
            args = dict(zip(request.get_fields_and_field_types(), args, strict=False))
        filled(request, args, self._now)
        if not caller.wait_for_service(timeout_sec=_THERE):
            raise Ros2Error(f"Service {name} does not exist")
        caller.call_async(request).add_done_callback(lambda future: then(future.result()))


class Served:
    """Services that clients answer, by an executor whose callbacks can wait for that."""

    def __init__(self, context: Context, now: Callable[[], Any]) -> None:
        self._context, self._now = context, now
        self._executor: Any = None
        self._served: dict[str, tuple[Client, Any]] = {}
        self._asked: dict[str, tuple[str, Any, Future]] = {}
        self._count = 0

    def _node(self) -> Any:
        """Return the node that serves, made once a client serves something."""
        if self._executor is None:
            self._executor = SingleThreadedExecutor(context=self._context)
            name = "rosbridge_services"
            node = Node(name, context=self._context, start_parameter_services=False)
            self._executor.add_node(node)
        return self._executor.get_nodes()[0]

    def step(self) -> None:
        """Take what came."""
        if self._executor is not None:
            self._executor.spin_once(timeout_sec=0.0)

    def advertise(self, client: Client, message: Any) -> None:
        """Serve a service that a client answers."""
        name = absolute(str(message["service"]))
        kind = interface_class(str(message["type"]), "srv")
        self._drop(name)

        async def ask(request: Any, response: Any) -> Any:
            self._count += 1
            number, future = f"service_request:{name}:{self._count}", Future()
            self._asked[number] = name, response, future
            fields = {"service": message["service"], "args": to_json(request)}
            client.send_message("call_service", id=number, **fields)
            await future
            return response

        self._served[name] = client, self._node().create_service(kind, name, ask)

    def answer(self, client: Client, message: Any) -> None:
        """Pass on what a client answers."""
        _, response, future = self._asked.pop(message["id"])
        try:
            filled(response, message.get("values") or {}, self._now)
        finally:
            future.set_result(None)

    def unadvertise(self, client: Client, message: Any) -> None:
        """Serve a service no longer."""
        self._drop(absolute(str(message["service"])))

    def forget(self, client: Client) -> None:
        """Take note that a client is gone."""
        for name in [name for name, (owner, _) in self._served.items() if owner is client]:
            self._drop(name)

    def _drop(self, name: str) -> None:
        """End a service; what it was asked gets an answer of defaults."""
        if name not in self._served:
            return
        for number in [each for each, asked in self._asked.items() if asked[0] == name]:
            self._asked.pop(number)[2].set_result(None)
        for _ in range(8):  # turns of the executor, in which the last answers are sent
            self.step()
        self._node().destroy_service(self._served.pop(name)[1])

    def close(self) -> None:
        """Leave the graph."""
        if self._executor is not None:
            self._node().destroy_node()
            self._executor.shutdown()


class Goals:
    """Sends goals of actions for clients."""

    def __init__(self, node: Node, now: Callable[[], Any]) -> None:
        self._node, self._now = node, now
        self._actions: dict[tuple[str, str], tuple[Any, Any]] = {}
        self._handles: dict[tuple[Client, Any], Any] = {}
        self._cancelled: set[tuple[Client, Any]] = set()

    def send(self, client: Client, message: Any) -> None:
        """Send a goal; its feedback comes where it is wanted, its result at the end."""
        name, key = str(message["action"]), (client, message.get("id"))
        fields = {"action": name, **_named(message)}

        def ended(
            values: Any, status: int = GoalStatus.STATUS_UNKNOWN, result: bool = False
        ) -> None:
            self._forget(key)
            whole = {**fields, "values": values, "status": status, "result": result}
            client.send_message("action_result", **whole)

        def feedback(told: Any) -> None:
            client.send_message("action_feedback", **fields, values=to_json(told.feedback))

        def accepted(future: Any) -> None:
            handle = self._handles[key] = future.result()
            if not handle.accepted:
                ended("Action goal was rejected")
                return
            if key in self._cancelled:
                handle.cancel_goal_async()
            handle.get_result_async().add_done_callback(
                lambda done: ended(to_json(done.result().result), done.result().status, True)
            )

        try:
            kind, caller = self._action(name, str(message["action_type"]))
            goal = filled(kind.Goal(), message.get("args") or {}, self._now)
            if not caller.wait_for_server(timeout_sec=_THERE):
                raise Ros2Error(f"Action {name} does not exist")
        except Ros2Error as error:
            ended(str(error))
            return
        self._handles[key] = None
        told = feedback if message.get("feedback") else None
        caller.send_goal_async(goal, feedback_callback=told).add_done_callback(accepted)

    def _action(self, name: str, type_name: str) -> tuple[Any, Any]:
        key = absolute(name), type_name
        if key not in self._actions:
            kind = interface_class(type_name, "action")
            self._actions[key] = kind, ActionClient(self._node, kind, key[0])
        return self._actions[key]

    def cancel(self, client: Client, message: Any) -> None:
        """Cancel a goal, also one that is not accepted yet."""
        key = client, message.get("id")
        if key in self._handles:
            self._cancelled.add(key)
        if self._handles.get(key) is not None:
            self._handles[key].cancel_goal_async()

    def forget(self, client: Client) -> None:
        """Take note that a client is gone; its goals run on, as rosbridge's do."""
        for key in [key for key in self._handles if key[0] is client]:
            self._forget(key)

    def _forget(self, key: tuple[Client, Any]) -> None:
        self._handles.pop(key, None)
        self._cancelled.discard(key)
