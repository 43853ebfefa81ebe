"""The services of a recorder or player, and its keys' names."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from rclpy.node import Node


class Controls:
    """Services of a node that no executor runs; `poll` answers what has been asked.

    Those of the local transport answer by themselves.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._services: list[Any] = []

    def add(self, kind: Any, name: str, answer: Callable[[Any], dict[str, Any] | None]) -> None:
        """Offer a service `~/NAME`, whose function returns the response's fields."""

        def respond(request: Any, response: Any) -> Any:
            for field, value in (answer(request) or {}).items():
                setattr(response, field, value)
            return response

        self._services.append(self._node.create_service(kind, f"~/{name}", respond))

    def announcing(self, event: Any, name: str) -> Callable[[Path, Path], None]:
        """Return what publishes, as an event of rosbag2's, that a file follows another."""
        events = self._node.create_publisher(event, name, 1)

        def announce(closed: Path, opened: Path) -> None:
            files = {"closed_file": str(closed), "opened_file": str(opened)}
            events.publish(event(**files, node_name=self._node.get_fully_qualified_name()))

        return announce

    def poll(self) -> None:
        """Answer all requests that wait."""
        for service in self._services:
            handle = getattr(service, "handle", None)
            if handle is None:
                continue
            with handle:
                while (taken := handle.service_take_request(service.srv_type.Request))[0]:
                    request, header = taken
                    response = service.callback(request, service.srv_type.Response())
                    service.send_response(response, header)
