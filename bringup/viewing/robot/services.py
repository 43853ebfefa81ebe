"""Services asked without waiting: each answer comes by callback, or never."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from rclpy.node import Node


class Services:
    """Clients of services, made when they are first asked."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self._clients: dict[str, Any] = {}
        self._pending: dict[str, tuple[Any, float]] = {}

    def ask(
        self,
        kind: Any,
        name: str,
        request: Any,
        then: Callable[[Any], None],
        deadline: float = 5.0,
    ) -> bool:
        """Send a request; an earlier one to the same service that is not answered is dropped.

        Args:
            deadline: How long a request keeps `busy` true [s, monotonic].

        Returns:
            Whether somebody serves it.
        """
        client = self._clients.get(name)
        if client is None:
            client = self._clients[name] = self._node.create_client(kind, name)
            client.wait_for_service(timeout_sec=0.3)  # it finds its server within that
        if not client.service_is_ready():
            return False
        self._drop(name)
        future = client.call_async(request)
        self._pending[name] = (future, time.monotonic() + deadline)
        future.add_done_callback(lambda done: self._answered(name, done, then))
        return True

    def busy(self, name: str) -> bool:
        """Return whether an answer may still come."""
        return name in self._pending and time.monotonic() < self._pending[name][1]

    def _drop(self, name: str) -> None:
        if name in self._pending:
            self._clients[name].remove_pending_request(self._pending.pop(name)[0])

    def _answered(self, name: str, future: Any, then: Callable[[Any], None]) -> None:
        if name in self._pending and self._pending[name][0] is future:
            del self._pending[name]
            then(future.result())

    def of_type(self, type_name: str) -> list[str]:
        """Return the names of all services of a type, `package/srv/Name`."""
        found = self._node.get_service_names_and_types()
        return sorted(name for name, types in found if type_name in types)
