"""Services of rclpy that answer later."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.node import Node


def deferred_service(
    node: Node,
    service_type: Any,
    name: str,
    on_request: Callable[[Any, Callable[[Any], None]], None],
) -> Any:
    """Create a service whose `on_request` takes a request and the function that answers it.

    rclpy's executors send what a callback returns through `Service.send_response`; here that
    keeps the request's header instead, and the function sends the real answer. Coroutines as
    callbacks, the alternative, do not work under the EventsExecutor of rclpy 7.1.6.
    """
    requests: list[Any] = []

    def keep_request(request: Any, response: Any) -> Any:
        requests.append(request)
        return response

    service: Any = node.create_service(service_type, name, keep_request)
    send = service.send_response

    def keep_header(response: Any, header: Any) -> None:
        if requests:
            on_request(requests.pop(), lambda answer: send(answer, header))
        else:  # what could not be used was refused
            send(response, header)

    service.send_response = keep_header
    return service
