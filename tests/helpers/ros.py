"""A process for tests of nodes: time moves only when the test says so."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rosgraph_msgs.msg import Clock

from arjuna_core.ros import qos
from arjuna_core.ros.convert import time_msg
from arjuna_core.ros.process import Process, Transport
from tests.helpers.processes import wait_until

TICK = 0.02


def changed(message: Any, path: str, value: Any) -> Any:
    """Return a message with one field changed."""
    *parts, last = path.split(".")
    within = message
    for part in parts:
        within = getattr(within, part)
    setattr(within, last, value)
    return message


class RosBench:
    """One process under test, with a helper node that plays the rest of the robot.

    Args:
        strict: Whether what a callback raises fails the test.
        transport: `dds` where the middleware is the subject, or nodes of rclpy's own take part.

    Attributes:
        process: The process that the nodes under test are made in.
        node: A plain node for clients of the test.
    """

    def __init__(self, strict: bool = True, transport: Transport = "local") -> None:
        self.process = Process("bench", isolated=True, strict=strict, transport=transport)
        self.node = self.process.make_node("bench_client")
        self._clock = self.node.create_publisher(Clock, "/clock", qos.LATEST)
        self._publishers: dict[str, Any] = {}
        self._ticks = 0
        self.process.drain()

    def activated(self, node: Callable[[Process], Any]) -> Any:
        """Return a node of a class that is made, configured and activated."""
        made = node(self.process)
        made.trigger_configure()
        made.trigger_activate()
        self.process.drain()
        return made

    def advance(self, duration: float = TICK, ticks: int = 1) -> None:
        """Move time on by a duration [s], some ticks at a time, draining after each."""
        for _ in range(round(duration / (TICK * ticks))):
            self._ticks += ticks
            self._clock.publish(Clock(clock=time_msg(self._ticks * TICK)))
            self.process.drain()

    def set_back(self) -> None:
        """Set time back to its first tick, as a restarted simulator does."""
        self._ticks = 0
        self.advance()

    def publish(self, message_type: Any, topic: str, message: Any, profile: Any = qos.TF) -> None:
        """Publish a message and run what it causes."""
        if topic not in self._publishers:
            self._publishers[topic] = self.node.create_publisher(message_type, topic, profile)
        self._publishers[topic].publish(message)
        self.process.drain()

    def collect(self, message_type: Any, topic: str, profile: Any = qos.TF) -> list[Any]:
        """Return a list that grows with every message of a topic."""
        messages: list[Any] = []
        self.node.create_subscription(message_type, topic, messages.append, profile)
        self.process.drain()
        return messages

    def latched(self, message_type: Any, topic: str) -> list[Any]:
        """Return such a list once what a topic holds for whoever comes late is in it.

        The middleware brings that on a thread of its own.
        """
        messages = self.collect(message_type, topic, qos.LATCHED)
        self.until(lambda: messages, f"{topic} to hold something")
        return messages

    def until(self, done: Callable[[], Any], what: object) -> None:
        """Spin until something is so that comes from another thread."""
        wait_until(done, lambda: self.process.spin_once(0.01), what)

    def call(self, service_type: Any, name: str, request: Any) -> Any:
        """Call a service of a node under test and return its response."""
        client = self.node.create_client(service_type, name)
        self.process.drain()
        future = client.call_async(request)
        self.process.drain()
        assert future.done(), f"{name} did not answer"
        self.node.destroy_client(client)
        assert isinstance(future.result(), service_type.Response), f"{name} answered nothing"
        return future.result()

    def close(self) -> None:
        """Leave the graph."""
        self.node.destroy_node()
        self.process.close()
