"""A ROS service whose answer comes later, without waiting inside its callback."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.node import Node


class DeferredService:
    """A service answered whenever its work is done.

    rclpy's executors send what a callback returns through `Service.send_response`; here that
    keeps the request's header instead, and `reply` sends the real answer. Coroutines as
    callbacks, the other way to do it, do not work under the EventsExecutor of rclpy 7.1.6.

    Args:
        node: The node that offers it.
        service_type: Its type.
        name: Its name.
        on_request: Called with each request and the function that answers it.
    """

    def __init__(
        self,
        node: Node,
        service_type: Any,
        name: str,
        on_request: Callable[[Any, Callable[[Any], None]], None],
    ) -> None:
        self._on_request = on_request
        self._request: Any = None
        self._service = node.create_service(service_type, name, self._keep_request)
        self._send = self._service.send_response
        self._service.send_response = self._keep_header

    def _keep_request(self, request: Any, response: Any) -> Any:
        self._request = request
        return response

    def _keep_header(self, response: Any, header: Any) -> None:
        self._on_request(self._request, lambda answer: self._send(answer, header))
