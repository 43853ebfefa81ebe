"""Nodes whose callbacks all end in their process's guard, rclpy's own callbacks too."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

from rclpy.node import Node

from arjuna_core.checks.message import unread, untyped
from arjuna_core.ros import qos
from arjuna_core.ros.health import answers
from arjuna_core.ros.health.bounded import bound
from arjuna_core.ros.health.guard import Guard
from arjuna_core.ros.local.doors import Doors
from arjuna_core.ros.local.registry import Registry


class Guarded(Doors):
    """Guards each callback that a node is given; a mixin that stands before rclpy's Node.

    rclpy makes its own services and subscriptions (parameters, types, lifecycle) in `__init__`
    and by the same methods, so `guard` is set before that runs.

    Attributes:
        guard: The process's.
    """

    guard: Guard

    def trouble(self) -> str:
        """Return what keeps the node from its work now, for /diagnostics; empty where nothing."""
        return ""

    def guarded(
        self,
        source: str,
        callback: Callable[..., Any],
        otherwise: Callable[..., Any] = lambda reason, *arguments: None,
    ) -> Callable[..., Any]:
        """Return a callback whose exceptions end in the process's guard.

        Args:
            source: What calls it, for the log.
            callback: What may raise.
            otherwise: Called with the reason and the arguments where it did, for what to return.
        """
        return self.guard.guarded(self, source, callback, otherwise)

    def answering(self, name: str, callback: Callable[..., Any]) -> Callable[..., Any]:
        """Return a service's callback that answers also where it fails, or cannot be read."""

        @functools.wraps(callback)
        def run(ask: Any, answer: Any) -> Any:
            problem = unread(ask) or untyped(ask)
            if problem is None:
                return callback(ask, answer)
            self._refuse_unread(name, problem)
            return answers.failed(ask, answer, problem, invalid=True)

        return self.guarded(
            name, run, lambda reason, ask, answer: answers.failed(ask, answer, reason)
        )

    def _refuse_unread(self, source: str, problem: str) -> None:
        self.guard.refused(self, source, problem)

    def create_subscription(
        self, msg_type: Any, topic: str, callback: Any, *options: Any, **named: Any
    ) -> Any:
        """Create a subscription whose callback is guarded; what cannot be read does not come."""
        if self.transport is not None:
            guarded = self.guarded(topic, callback)
            return super().create_subscription(msg_type, topic, guarded, *options, **named)

        @functools.wraps(callback)
        def deliver(message: Any) -> Any:
            problem = unread(message)
            return callback(message) if problem is None else self._refuse_unread(topic, problem)

        bound([msg_type])
        guarded = self.guarded(topic, deliver)
        return super().create_subscription(msg_type, topic, guarded, *options, **named)

    def create_service(
        self, srv_type: Any, srv_name: str, callback: Any, *options: Any, **named: Any
    ) -> Any:
        """Create a service that answers also where its callback fails, and many at once."""
        named.setdefault("qos_profile", qos.SERVICES)
        if self.transport is None:
            bound([srv_type.Request])
        answering = self.answering(srv_name, callback)
        return super().create_service(srv_type, srv_name, answering, *options, **named)

    def create_timer(self, period: float, callback: Any, *options: Any, **named: Any) -> Any:
        """Create a timer whose callback is guarded."""
        guarded = self.guarded("timer", callback)
        return super().create_timer(period, guarded, *options, **named)


class GuardedNode(Guarded, Node):
    """A plain rclpy node whose callbacks are guarded.

    Args:
        guard: The process's.
        name: The node's name.
        transport: The process's; None for the middleware.
        options: As rclpy's Node takes them.
    """

    def __init__(
        self, guard: Guard, name: str, transport: Registry | None = None, **options: Any
    ) -> None:
        self.guard, self.transport = guard, transport
        super().__init__(name, **options)
