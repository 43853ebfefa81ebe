"""What a client waits in: a connection to a running robot, or a lock-step robot."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any, Protocol

from rclpy.executors import Executor
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter

from arjuna_core.errors import ArjunaError
from arjuna_core.ros.context import new_context

POLL = 0.02
"""From one look at whether something is done to the next [s]."""


_PATIENCE = 2.5
"""How long to wait without a word [s]; what runs is mostly found within one."""


class ClientError(ArjunaError):
    """Nobody answers in time, or a request is refused; the message says what to do."""


class Session(Protocol):
    """A node, and a way to let the graph run while its owner waits; `LockStep` is one too."""

    client: Node

    @property
    def now(self) -> float:
        """The time that timeouts are of [s]."""

    def run_until(
        self, done: Callable[[], bool], timeout: float, what: str = "", required: bool = True
    ) -> bool:
        """Let the graph run until something is done; tell whether it was in time [s].

        Raises:
            ArjunaError: It was not, and is required.
        """

    def call(self, service_type: Any, name: str, request: Any, timeout: float = 5.0) -> Any:
        """Return a service's response.

        Raises:
            ArjunaError: It does not answer in time [s].
        """


def wait_for(
    session: Session, done: Callable[[], bool], timeout: float, what: str, cure: str
) -> None:
    """Wait until something is done; soon say what is waited for and what would bring it.

    Args:
        session: The connection.
        done: Asked after each event.
        timeout: [s].
        what: What is waited for.
        cure: What to do if it does not come, a question or an order.

    Raises:
        ClientError: It was not done in time.
    """
    soon = min(_PATIENCE, timeout)
    if session.run_until(done, soon, required=False):
        return
    if timeout > soon:
        session.client.get_logger().warning(f"waiting for {what}: {cure}")
        if session.run_until(done, timeout - soon, required=False):
            return
    raise ClientError(f"{what} did not come within {timeout:g} s: {cure}")


class Connection:
    """A node among those of the robots on this machine; times are real times.

    Args:
        name: The node's name.
        namespace: The robot's namespace.
        use_sim_time: Whether the node's clock is the robot's.
        executor: What runs its callbacks.

    Attributes:
        client: The node.
    """

    def __init__(
        self,
        name: str = "arjuna_client",
        namespace: str = "",
        use_sim_time: bool = False,
        executor: type[Executor] = EventsExecutor,
    ) -> None:
        self._context = new_context()
        self.client = Node(
            name,
            context=self._context,
            namespace=namespace,
            start_parameter_services=False,
            parameter_overrides=[Parameter("use_sim_time", value=use_sim_time)],
        )
        self._executor = executor(context=self._context)
        self._executor.add_node(self.client)

    @property
    def now(self) -> float:
        """A steady time [s]."""
        return time.monotonic()

    def run_until(
        self, done: Callable[[], bool], timeout: float, what: str = "", required: bool = True
    ) -> bool:
        """Handle what comes until something is done.

        Args:
            done: Asked after each event.
            timeout: [s].
            what: What is waited for, for the error.
            required: Whether a timeout is an error.

        Returns:
            Whether it was done in time.

        Raises:
            ClientError: It was not, and is required.
        """
        deadline = self.now + timeout
        while not done():
            left = deadline - self.now
            if left <= 0.0:
                if required:
                    raise ClientError(f"{what} did not come within {timeout:g} s")
                return False
            self.spin_once(min(left, POLL))
        return True

    def spin_once(self, timeout: float = POLL) -> None:
        """Handle what comes next, within a timeout [s]."""
        self._executor.spin_once(timeout_sec=timeout)

    def call(self, service_type: Any, name: str, request: Any, timeout: float = 5.0) -> Any:
        """Return a service's response.

        Raises:
            ClientError: Nobody serves it, or does not answer in time [s].
        """
        client = self.client.create_client(service_type, name)
        try:
            if not self.run_until(client.service_is_ready, timeout, required=False):
                raise ClientError(f"nobody serves '{name}' within {timeout:g} s")
            future = client.call_async(request)
            self.run_until(future.done, timeout, f"an answer of '{name}'")
            return future.result()
        finally:
            self.client.destroy_client(client)

    def close(self) -> None:
        """Leave the graph."""
        self._executor.shutdown()
        self.client.destroy_node()
        self._context.shutdown()
        self._context.destroy()  # else the graph keeps it until it is collected
