"""Services of one process: requests and responses are queued as objects."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from rclpy.task import Future

from arjuna_core.ros.local.reading import handed_over
from arjuna_core.ros.local.transport import Registry

Respond = Callable[[Any], None]


class LocalService:
    """The end of a service that answers; what rclpy's Service is to its owner."""

    def __init__(
        self,
        registry: Registry,
        node: Any,
        srv_type: Any,
        srv_name: str,
        callback: Callable[[Any, Any], Any],
    ) -> None:
        self.node = node
        self._registry = registry
        self.srv_type, self.srv_name, self.callback = srv_type, srv_name, callback
        self.service_name = srv_name
        self._sent = handed_over(srv_type.Response, node.trusted)
        registry.services[srv_name].append(self)

    def take(self, request: Any, respond: Respond, trusted: bool) -> None:
        """Answer a request."""
        self._registry.trusted = trusted
        self._answer(respond, self.callback(request, self.srv_type.Response()))

    def _answer(self, respond: Respond, response: Any) -> None:
        if self._sent is not None:
            response = self._sent(response)
        if self._registry.watching:
            self._registry.watch(self.srv_name, response)
        respond(response)

    def destroy(self) -> None:
        """Take no more requests; those that wait are answered."""
        self._registry.services[self.srv_name].remove(self)


class DeferredService(LocalService):
    """A service whose callback is given the request and what takes the response, perhaps later."""

    def take(self, request: Any, respond: Respond, trusted: bool) -> None:
        """Hand a request over, a turn later, as rclpy's actions take theirs."""
        self._registry.executor.put(partial(self._hand_over, request, respond, trusted))

    def _hand_over(self, request: Any, respond: Respond, trusted: bool) -> None:
        self._registry.trusted = trusted
        self.callback(request, partial(self._answer, respond))


class LocalClient:
    """The end of a service that asks; what rclpy's Client is to its owner."""

    def __init__(self, registry: Registry, node: Any, srv_type: Any, srv_name: str) -> None:
        self._registry = registry
        self._trusted: bool = node.trusted
        self.srv_type, self.srv_name = srv_type, srv_name
        self.service_name = srv_name
        self._sent = handed_over(srv_type.Request, node.trusted)
        self._pending: set[Future] = set()

    def call_async(self, request: Any) -> Future:
        """Queue a request; the future returned takes the response.

        Raises:
            TypeError: The request is of another type.
        """
        if not isinstance(request, self.srv_type.Request):
            raise TypeError(f"Expected {self.srv_type.Request}, got {type(request)}")
        if self._sent is not None:
            request = self._sent(request)
        if self._registry.watching:
            self._registry.watch(self.srv_name, request)
        future = Future(executor=self._registry.executor)
        self._pending.add(future)
        for service in self._services():
            respond = partial(self._on_response, future)
            self._registry.executor.put(partial(service.take, request, respond, self._trusted))
        return future

    def _on_response(self, future: Future, response: Any) -> None:
        self._registry.executor.put(partial(self._finish, future, response))

    def _finish(self, future: Future, response: Any) -> None:
        if future in self._pending:
            self._pending.discard(future)
            future.set_result(response)

    def remove_pending_request(self, future: Future) -> None:
        """Take no response for a request any more."""
        self._pending.discard(future)

    def service_is_ready(self) -> bool:
        """Return whether somebody answers."""
        return bool(self._services())

    def _services(self) -> list[LocalService]:
        found = self._registry.services[self.srv_name]
        return [each for each in found if each.srv_type is self.srv_type]

    def wait_for_service(self, timeout_sec: float | None = None) -> bool:
        """Return whether somebody answers; nobody comes while a callback runs."""
        return self.service_is_ready()

    def destroy(self) -> None:
        """Take no response any more."""
        self._pending.clear()
