"""The bridge between a ROS graph and Foxglove's WebSocket protocol."""

from __future__ import annotations

import queue
import time
from collections.abc import Callable, Sequence
from concurrent.futures import TimeoutError as TimedOut
from typing import Any

import foxglove
from foxglove.websocket import (
    Capability,
    ChannelView,
    Client,
    ClientChannel,
    Parameter,
    ServerListener,
    StatusLevel,
)
from rclpy.context import Context
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.node import Node

from arjuna_core.errors import ArjunaError
from arjuna_core.ros.context import new_context
from bringup.viewing.foxglove.channels import Channels, Publications
from bringup.viewing.foxglove.parameters import Parameters, Question
from bringup.viewing.robot.services import Services

PORT = 8765
"""Foxglove's own."""


class BridgeError(ArjunaError):
    """The bridge cannot be served where it was asked for."""


class Bridge:
    """Serves a robot to Foxglove.

    Args:
        host: The address; the loopback's, unless others shall reach it.
        port: The port; 0 for any.
        context: An rclpy context to live in; its own if None.

    Raises:
        BridgeError: The address is taken, or not this machine's.
    """

    def __init__(self, host: str, port: int = PORT, context: Context | None = None) -> None:
        self._calls: queue.SimpleQueue[Callable[[], None]] = queue.SimpleQueue()
        scene = foxglove.Context()
        try:
            self._server = foxglove.start_server(
                name="Arjuna",
                host=host,
                port=port,
                capabilities=[Capability.ClientPublish, Capability.Parameters],
                supported_encodings=["cdr"],
                server_listener=_Listener(self),
                context=scene,
            )
        except RuntimeError as error:
            raise BridgeError(f"'{host}' port {port} cannot be served: {error}") from error
        self._owned = context is None
        self._context = context or new_context()
        self._node = Node("foxglove_bridge", context=self._context, start_parameter_services=False)
        self._executor = EventsExecutor(context=self._context)
        self._executor.add_node(self._node)
        self.channels = Channels(self._node, scene)
        self.publications = Publications(self._node)
        self.parameters = Parameters(Services(self._node))
        self._refresh_due = 0.0

    @property
    def port(self) -> int:
        """The port that is served."""
        return self._server.port

    def queue(self, call: Callable[[], None]) -> None:
        """Have something called by `step`; the server's threads must not touch ROS."""
        self._calls.put(call)

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
            self.channels.refresh()
        while not self._calls.empty():
            self._calls.get()()
        self.parameters.tick()
        self._executor.spin_once(timeout_sec=idle if self.channels.idle else busy)

    def advertise(self, key: tuple[int, int], topic: str, type_name: str, encoding: str) -> None:
        """Publish for a client on a topic from now on, or report why that is not possible."""
        problem = self.publications.advertise(key, topic, type_name, encoding)
        if problem is not None:
            self._node.get_logger().warning(problem)
            self._server.publish_status(problem, StatusLevel.Warning)

    def close(self) -> None:
        """Disconnect the clients and leave the graph."""
        self._server.stop()
        self._node.destroy_node()
        self._executor.shutdown()
        if self._owned:
            self._context.shutdown()


class _Listener(ServerListener):
    """Queues all that clients ask for; only questions for parameters wait for their answer."""

    def __init__(self, bridge: Bridge) -> None:
        self._bridge = bridge

    def _call(self, of: Callable[[Bridge], Callable[..., None]], *values: Any) -> None:
        self._bridge.queue(lambda: of(self._bridge)(*values))

    def on_subscribe(self, client: Client, channel: ChannelView) -> None:
        self._call(lambda bridge: bridge.channels.subscribe, channel.topic)

    def on_unsubscribe(self, client: Client, channel: ChannelView) -> None:
        self._call(lambda bridge: bridge.channels.unsubscribe, channel.topic)

    def on_client_advertise(self, client: Client, channel: ClientChannel) -> None:
        named = (channel.topic, channel.schema_name, channel.encoding)
        self._call(lambda bridge: bridge.advertise, (client.id, channel.id), *named)

    def on_client_unadvertise(self, client: Client, client_channel_id: int) -> None:
        self._call(lambda bridge: bridge.publications.unadvertise, (client.id, client_channel_id))

    def on_message_data(self, client: Client, client_channel_id: int, data: bytes) -> None:
        key = (client.id, client_channel_id)
        self._call(lambda bridge: bridge.publications.publish, key, data)

    def on_get_parameters(
        self, client: Client, param_names: list[str], request_id: str | None = None
    ) -> list[Parameter]:
        return self._ask(Question(tuple(param_names)))

    def on_set_parameters(
        self, client: Client, parameters: list[Parameter], request_id: str | None = None
    ) -> list[Parameter]:
        values = {item.name: item.get_value() for item in parameters}
        return self._ask(Question(tuple(values), values))

    def _ask(self, question: Question) -> list[Parameter]:
        self._call(lambda bridge: bridge.parameters.ask, question)
        try:
            found = question.answer.result(timeout=5.0)
        except TimedOut:
            return []
        return [Parameter(name, value=_native(value)) for name, value in found.items()]


def _native(value: Any) -> Any:
    sequence = isinstance(value, Sequence) and not isinstance(value, str | bytes)
    return list(value) if sequence else value
