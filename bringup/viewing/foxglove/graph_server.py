"""A node whose graph clients reach by a socket; each protocol says how they speak."""

from __future__ import annotations

import abc
import time
from typing import Any

from rclpy.context import Context
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.node import Node

from arjuna_core.ros.context import new_context
from bringup.viewing.foxglove.server import Client, Server

MALFORMED = (ArithmeticError, AttributeError, LookupError, RecursionError, TypeError, ValueError)
"""What a message that makes no sense raises."""


class GraphServer(abc.ABC):
    """Serves a robot to clients.

    Args:
        server: The socket.
        name: Of the node.
        context: One that is the caller's; None for one of its own.
        options: Those of rclpy's Node.
    """

    def __init__(
        self, server: Server, name: str, context: Context | None = None, **options: Any
    ) -> None:
        self._server, self._owned = server, context is None
        self._context = context or new_context()
        self._node = Node(name, context=self._context, **options)
        self._executor = EventsExecutor(context=self._context)
        self._executor.add_node(self._node)
        self._clients: list[Client] = []
        self._refresh_due = 0.0

    @property
    def port(self) -> int:
        """The port that is served."""
        return self._server.port

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
            self._refresh()
        for client, message in self._server.take():
            if message is True:
                self._clients.append(client)
                self._greet(client)
            elif message is False:
                self._clients.remove(client)
                self._forget(client)
            else:
                self._handle(client, message)
        self._tick()
        self._executor.spin_once(timeout_sec=busy if self._clients else idle)

    @abc.abstractmethod
    def _refresh(self) -> None:
        """Look at the graph."""

    @abc.abstractmethod
    def _greet(self, client: Client) -> None:
        """Take note of a new client."""

    @abc.abstractmethod
    def _forget(self, client: Client) -> None:
        """Take note that a client is gone."""

    @abc.abstractmethod
    def _handle(self, client: Client, message: str | bytes) -> None:
        """Do what a client's message asks for; what makes no sense is answered with why."""

    @abc.abstractmethod
    def _tick(self) -> None:
        """Do what is due at each step."""

    def close(self) -> None:
        """Disconnect the clients and leave the graph."""
        self._server.close()
        self._node.destroy_node()
        self._executor.shutdown()
        if self._owned:
            self._context.shutdown()
