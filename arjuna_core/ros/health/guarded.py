"""Nodes whose callbacks all end in their process's guard, rclpy's own callbacks too."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from typing import Any

from rclpy.node import Node

from arjuna_core.ros import qos
from arjuna_core.ros.health.checks import problem_of
from arjuna_core.ros.health.guard import Guard
from arjuna_core.ros.health.rules import LISTED
from arjuna_core.ros.local.doors import Doors
from arjuna_core.ros.local.reading import reader
from arjuna_core.ros.local.transport import Registry
from arjuna_core.ros.messages import is_of_lists
from arjuna_core.ros.reports import failed


class Guarded(Doors):
    """A mixin before rclpy's Node whose process's guard runs each callback that the node is given.

    rclpy makes its own services and subscriptions (parameters, types, lifecycle) in `__init__`
    and by the same methods, so `guard` is set before that runs.
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
        """Return a callback whose exceptions end in the process's guard; see `Guard.guarded`."""
        return self.guard.guarded(self, source, callback, otherwise)

    def problem_of(self, source: str, message: Any) -> str | None:
        """Return why a request or goal cannot be used, and count it; None if it can."""
        trusted = self.transport is not None and self.transport.trusted
        problem = None if trusted else problem_of(message, self.guard.now())
        if problem is not None:
            self.guard.refused(self, source, problem)
        return problem

    def answering(self, name: str, callback: Callable[..., Any]) -> Callable[..., Any]:
        """Return a service's callback that answers also where it fails, or cannot use what came."""

        @functools.wraps(callback)
        def run(ask: Any, answer: Any) -> Any:
            problem = self.problem_of(name, ask)
            return failed(ask, answer, problem, invalid=True) if problem else callback(ask, answer)

        return self.guarded(name, run, lambda reason, ask, answer: failed(ask, answer, reason))

    def create_subscription(
        self, msg_type: Any, topic: str, callback: Any, *options: Any, **named: Any
    ) -> Any:
        """Create a subscription; long messages of lists, an object an item, are not even read."""
        if self.transport is not None or named.get("raw"):
            deliver = self.guarded(topic, callback)
            return super().create_subscription(msg_type, topic, deliver, *options, **named)
        most, message_of = LISTED if is_of_lists(msg_type) else math.inf, reader(msg_type)

        def read(data: bytes) -> None:
            problem = f"{len(data)} bytes of lists; at most {LISTED} are valid"
            if len(data) <= most:
                try:
                    message = message_of(data)
                except ValueError as error:
                    problem = str(error)
                else:
                    callback(message)
                    return
            self.guard.refused(self, topic, problem)

        deliver = self.guarded(topic, read)
        return super().create_subscription(
            msg_type, topic, deliver, *options, **{**named, "raw": True}
        )

    def create_service(
        self, srv_type: Any, srv_name: str, callback: Any, *options: Any, **named: Any
    ) -> Any:
        """Create a service that answers also where its callback fails, and many at once."""
        named.setdefault("qos_profile", qos.SERVICES)
        answer = self.answering(srv_name, callback)
        return super().create_service(srv_type, srv_name, answer, *options, **named)

    def create_timer(self, period: float, callback: Any, *options: Any, **named: Any) -> Any:
        """Create a timer."""
        return super().create_timer(period, self.guarded("timer", callback), *options, **named)


class GuardedNode(Guarded, Node):
    """A plain rclpy node whose callbacks are guarded; options are those of rclpy's Node."""

    def __init__(
        self, guard: Guard, name: str, transport: Registry | None = None, **options: Any
    ) -> None:
        self.guard, self.transport = guard, transport
        super().__init__(name, **{"enable_rosout": transport is None, **options})
