"""`ros2 run rosbridge_server rosbridge_websocket`: a robot for clients of rosbridge's protocol.

Source: rosbridge_suite's ROSBRIDGE_PROTOCOL.md, version 2, and what its `ros2` branch answers.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Sequence
from typing import Any

from rclpy.context import Context
from rclpy.exceptions import InvalidServiceNameException, InvalidTopicNameException
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter

from arjuna_core.ros.context import new_context
from bringup.ros2.errors import Ros2Error
from bringup.ros2.rosbridge.calls import Calls, Goals, Served
from bringup.ros2.rosbridge.topics import Publications, Subscriptions
from bringup.ros2.verbs.forward import ros_arguments
from bringup.terminal import stopped_by_signals
from bringup.viewing.foxglove.server import Client, Server

PORT = 9090
"""rosbridge's own."""
_MALFORMED = (ArithmeticError, AttributeError, LookupError, RecursionError, TypeError, ValueError)
_UNNAMED = (InvalidServiceNameException, InvalidTopicNameException)
_IGNORED = ("auth", "set_level", "status")


class Bridge:
    """Serves a robot to rosbridge's clients.

    Args:
        port: The port; 0 for any.

    Raises:
        BridgeError: The address is taken, or not this machine's.
    """

    def __init__(self, host: str, port: int = PORT, context: Context | None = None) -> None:
        self._server = Server(host, port, (), self._refuse)
        self._owned = context is None
        self._context = context or new_context()
        # The time of /clock where there is one: until it comes it is 0, and the machine's is taken.
        simulated = Parameter("use_sim_time", value=True)
        self._node = Node(
            "rosbridge_websocket", context=self._context, parameter_overrides=[simulated]
        )
        self._executor = EventsExecutor(context=self._context)
        self._executor.add_node(self._node)
        self._clients: list[Client] = []
        self._heard, self._sent = Subscriptions(self._node), Publications(self._node, self._now)
        self._calls, self._goals = Calls(self._node, self._now), Goals(self._node, self._now)
        self._served = Served(self._context, self._now)
        self._refresh_due = 0.0
        self._ops: dict[str, Callable[[Client, Any], None]] = {
            "subscribe": self._heard.subscribe,
            "unsubscribe": self._heard.unsubscribe,
            "advertise": self._sent.advertise,
            "unadvertise": self._sent.unadvertise,
            "publish": self._sent.publish,
            "call_service": self._calls.call,
            "advertise_service": self._served.advertise,
            "unadvertise_service": self._served.unadvertise,
            "service_response": self._served.answer,
            "send_action_goal": self._goals.send,
            "cancel_action_goal": self._goals.cancel,
            **dict.fromkeys(_IGNORED, lambda *_: None),
        }
        self._node.get_logger().info(f"Rosbridge WebSocket server started on port {self.port}")

    @property
    def port(self) -> int:
        """The port that is served."""
        return self._server.port

    def _now(self) -> Any:
        now = self._node.get_clock().now()
        return now.to_msg() if now.nanoseconds else _machine_time()

    def _refuse(self, origin: str) -> None:
        remedy = "serve its folder ('python -m http.server') and open http://localhost:8000"
        self._node.get_logger().warning(
            f"a page of origin '{origin}' is refused, for any site could drive the robot; {remedy}"
        )

    def step(self, refresh: float = 1.0, busy: float = 0.02, idle: float = 0.2) -> None:
        """Pass on what comes, in both directions.

        Args:
            refresh: Period between two looks at the graph [s].
            busy: Longest wait for a message while somebody listens [s].
            idle: The same while nobody does [s].
        """
        now = time.monotonic()
        if now >= self._refresh_due:
            self._refresh_due = now + refresh
            self._heard.refresh()
        for client, message in self._server.take():
            if isinstance(message, bool):
                self._count(client, message)
            else:
                self._handle(client, message)
        self._sent.flush()
        self._served.step()
        self._executor.spin_once(timeout_sec=busy if self._clients else idle)

    def _count(self, client: Client, came: bool) -> None:
        if came:
            self._clients.append(client)
        else:
            self._clients.remove(client)
            for part in (self._heard, self._sent, self._served, self._goals):
                part.forget(client)
        word = "connected" if came else "disconnected"
        self._node.get_logger().info(f"Client {word}. {len(self._clients)} clients total.")

    def _handle(self, client: Client, message: str | bytes) -> None:
        """Do what a client's message asks for; what makes no sense is answered with why."""
        number: Any = None
        try:
            fields = json.loads(message)
            number, op = fields.get("id"), fields["op"]
            if op not in self._ops:
                raise Ros2Error(f"Unknown operation: {op}; valid: {', '.join(sorted(self._ops))}")
            self._ops[op](client, fields)
        except (Ros2Error, *_UNNAMED, *_MALFORMED) as error:
            text = (
                str(error) if isinstance(error, Ros2Error) else f"{type(error).__name__}: {error}"
            )
            self._node.get_logger().error(text)
            client.send_message("status", level="error", msg=text, id=number)

    def close(self) -> None:
        """Disconnect the clients and leave the graph."""
        self._server.close()
        self._served.close()
        self._node.destroy_node()
        self._executor.shutdown()
        if self._owned:
            self._context.shutdown()


def _machine_time() -> Any:
    from rclpy.clock import Clock

    return Clock().now().to_msg()


def main(words: Sequence[str]) -> None:
    """Serve until it is stopped, by the parameters `port` and `address`.

    Raises:
        ArjunaError: It cannot be served there.
    """
    given = ros_arguments(list(words)).values
    port = given.get("port") or str(PORT)
    if not port.isdigit():
        raise Ros2Error(f"port: '{port}' is none; valid: 0 to 65535")
    bridge = Bridge(given.get("address") or "127.0.0.1", int(port))
    stopped = stopped_by_signals()
    while not stopped.is_set():
        bridge.step()
    bridge.close()
