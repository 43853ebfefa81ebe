"""The bridge between a ROS graph and Foxglove's WebSocket protocol."""

from __future__ import annotations

import queue
import time

import foxglove
from foxglove.websocket import Capability, StatusLevel
from rclpy.context import Context
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.node import Node

from arjuna_core.errors import ArjunaError
from arjuna_core.ros.context import new_context
from bringup.viewing.foxglove import listener
from bringup.viewing.foxglove.channels import Channels
from bringup.viewing.foxglove.parameters import Parameters
from bringup.viewing.foxglove.publications import Publications
from bringup.viewing.robot.services import Services

PORT = 8765
"""Foxglove's own."""
_LOOK_AROUND = 1.0  # between two looks at the graph [s]
_BUSY, _IDLE = 0.02, 0.2  # how long to wait for a message before looking at the queue [s]


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
        self._events: queue.SimpleQueue[listener.Event] = queue.SimpleQueue()
        scene = foxglove.Context()
        try:
            self._server = foxglove.start_server(
                name="Arjuna",
                host=host,
                port=port,
                capabilities=[Capability.ClientPublish, Capability.Parameters],
                supported_encodings=["cdr"],
                server_listener=listener.Listener(self._events),
                context=scene,
            )
        except RuntimeError as error:
            raise BridgeError(f"'{host}' port {port} cannot be served: {error}") from error
        self._owned = context is None
        self._context = context or new_context()
        self._node = Node("foxglove_bridge", context=self._context, start_parameter_services=False)
        self._executor = EventsExecutor(context=self._context)
        self._executor.add_node(self._node)
        self._channels = Channels(self._node, scene)
        self._publications = Publications(self._node)
        self._parameters = Parameters(Services(self._node))
        self._look_at = 0.0

    @property
    def port(self) -> int:
        """The port that is served."""
        return self._server.port

    def step(self) -> None:
        """Pass on what comes, in both directions."""
        now = time.monotonic()
        if now >= self._look_at:
            self._look_at = now + _LOOK_AROUND
            self._channels.refresh()
        while not self._events.empty():
            self._handle(self._events.get())
        self._parameters.tick()
        self._executor.spin_once(timeout_sec=_IDLE if self._channels.idle else _BUSY)

    def _handle(self, event: listener.Event) -> None:
        if isinstance(event, listener.Subscribed):
            self._channels.subscribe(event.topic)
        elif isinstance(event, listener.Unsubscribed):
            self._channels.unsubscribe(event.topic)
        elif isinstance(event, listener.Advertised):
            problem = self._publications.advertise(event)
            if problem is not None:
                self._node.get_logger().warning(problem)
                self._server.publish_status(problem, StatusLevel.Warning)
        elif isinstance(event, listener.Unadvertised):
            self._publications.unadvertise(event.key)
        elif isinstance(event, listener.Published):
            self._publications.publish(event.key, event.data)
        else:
            self._parameters.ask(event)

    def close(self) -> None:
        """Hang up and leave the graph."""
        self._server.stop()
        self._node.destroy_node()
        self._executor.shutdown()
        if self._owned:
            self._context.shutdown()
