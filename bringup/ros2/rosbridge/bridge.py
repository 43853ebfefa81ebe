"""`ros2 run rosbridge_server rosbridge_websocket`: a robot for clients of rosbridge's protocol.

Source: rosbridge_suite's ROSBRIDGE_PROTOCOL.md, version 2, and what its `ros2` branch answers.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from typing import Any

from rclpy.context import Context
from rclpy.exceptions import InvalidServiceNameException, InvalidTopicNameException
from rclpy.parameter import Parameter

from bringup.ros2.errors import Ros2Error
from bringup.ros2.rosbridge.calls import Calls, Goals, Served
from bringup.ros2.rosbridge.topics import Publications, Subscriptions
from bringup.ros2.verbs.forward import ros_arguments
from bringup.terminal import stopped_by_signals
from bringup.viewing.foxglove.graph_server import MALFORMED, GraphServer
from bringup.viewing.foxglove.server import Client, Server

PORT = 9090
"""rosbridge's own."""
_UNNAMED = (InvalidServiceNameException, InvalidTopicNameException)
_IGNORED = ("auth", "set_level", "status")


class Bridge(GraphServer):
    """Serves a robot to rosbridge's clients.

    Args:
        port: The port; 0 for any.

    Raises:
        BridgeError: The address is taken, or not this machine's.
    """

    def __init__(self, host: str, port: int = PORT, context: Context | None = None) -> None:
        # The time of /clock where there is one: until it comes it is 0, and the machine's is taken.
        simulated = Parameter("use_sim_time", value=True)
        server = Server(host, port, (), self._refuse)
        super().__init__(server, "rosbridge_websocket", context, parameter_overrides=[simulated])
        self._heard, self._sent = Subscriptions(self._node), Publications(self._node, self._now)
        self._calls, self._goals = Calls(self._node, self._now), Goals(self._node, self._now)
        self._served = Served(self._context, self._now)
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

    def _now(self) -> Any:
        now = self._node.get_clock().now()
        return now.to_msg() if now.nanoseconds else _machine_time()

    def _refuse(self, origin: str) -> None:
        remedy = "serve its folder ('python -m http.server') and open http://localhost:8000"
        self._node.get_logger().warning(
            f"a page of origin '{origin}' is refused, for any site could drive the robot; {remedy}"
        )

    def _refresh(self) -> None:
        self._heard.refresh()

    def _tick(self) -> None:
        self._sent.flush()
        self._served.step()

    def _greet(self, client: Client) -> None:
        self._count("connected")

    def _forget(self, client: Client) -> None:
        for part in (self._heard, self._sent, self._served, self._goals):
            part.forget(client)
        self._count("disconnected")

    def _count(self, word: str) -> None:
        self._node.get_logger().info(f"Client {word}. {len(self._clients)} clients total.")

    def _handle(self, client: Client, message: str | bytes) -> None:
        number: Any = None
        try:
            fields = json.loads(message)
            number, op = fields.get("id"), fields["op"]
            if op not in self._ops:
                raise Ros2Error(f"Unknown operation: {op}; valid: {', '.join(sorted(self._ops))}")
            self._ops[op](client, fields)
        except (Ros2Error, *_UNNAMED, *MALFORMED) as error:
            text = (
                str(error) if isinstance(error, Ros2Error) else f"{type(error).__name__}: {error}"
            )
            self._node.get_logger().error(text)
            client.send_message("status", level="error", msg=text, id=number)

    def close(self) -> None:
        """Disconnect the clients and leave the graph."""
        self._served.close()
        super().close()


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
