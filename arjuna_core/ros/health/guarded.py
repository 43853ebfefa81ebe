"""Nodes whose callbacks all end in their process's guard, rclpy's own callbacks too."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

from rcl_interfaces.msg import SetParametersResult
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node
from rclpy.serialization import deserialize_message

from arjuna_core.checks.limits import LISTED
from arjuna_core.checks.message import call_problem
from arjuna_core.ros import qos
from arjuna_core.ros.health.guard import Guard
from arjuna_core.ros.local.doors import Doors
from arjuna_core.ros.local.transport import Registry
from arjuna_core.ros.messages import is_of_lists

RMWError = rclpy_implementation.RMWError
_TEXTS = ("error_message", "error_msg", "message", "status_message", "reason")
_INVALID_CODES = ("INVALID_PATH", "INVALID_INPUT", "INVALID_POSE")
_CODES = ("RESULT_OPERATION_FAILED", "RESULT_UNDEFINED_FAILURE", "RESULT_FAILED_TO_WRITE_FILE")


def invalid_code(result: Any, otherwise: int) -> int:
    """Return the code by which an action or a service says that what it was given is invalid."""
    codes = (getattr(result, name) for name in _INVALID_CODES if hasattr(result, name))
    return int(next(codes, otherwise))


def failed(request: Any, response: Any, reason: str, invalid: bool = False) -> Any:
    """Return a fresh response that says that a request failed, and why where it has a field.

    A flag of success is false in a fresh response already.

    Args:
        request: What was asked; where it sets parameters, each gets a result.
        response: The response as far as it was filled in; its type counts.
        reason: One line.
        invalid: Whether the request was at fault.
    """
    answer = type(response)()
    _explain(answer, reason)
    within: Any = getattr(answer, "result", None)
    if invalid and hasattr(within, "result"):
        within.result = invalid_code(answer, within.result)
    if hasattr(answer, "results") and hasattr(request, "parameters"):
        refusal = SetParametersResult(successful=False, reason=reason)
        answer.results = [refusal for _ in request.parameters]
    return answer


def _explain(answer: Any, reason: str) -> None:
    """Fill in a failure's code and text, here and in the result within."""
    fields = answer.get_fields_and_field_types()
    if fields.get("result") == "uint8":
        answer.result = next(getattr(answer, code) for code in _CODES if hasattr(answer, code))
    if fields.get("cost") == "float":
        # nav2's GetCost answers -1 outside the costmap.
        answer.cost = -1.0
    for name in _TEXTS:
        if fields.get(name) == "string":
            setattr(answer, name, reason)
    for name in ("result", "status"):
        if "/" in fields.get(name, ""):
            _explain(getattr(answer, name), reason)


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
        """Return a callback whose exceptions end in the process's guard; see `Guard.guarded`."""
        return self.guard.guarded(self, source, callback, otherwise)

    def answering(self, name: str, callback: Callable[..., Any]) -> Callable[..., Any]:
        """Return a service's callback that answers also where it fails, or cannot be read."""

        @functools.wraps(callback)
        def run(ask: Any, answer: Any) -> Any:
            problem = call_problem(ask)
            if problem is None:
                return callback(ask, answer)
            self.guard.refused(self, name, problem)
            return failed(ask, answer, problem, invalid=True)

        return self.guarded(name, run, lambda reason, ask, answer: failed(ask, answer, reason))

    def create_subscription(
        self, msg_type: Any, topic: str, callback: Any, *options: Any, **named: Any
    ) -> Any:
        """Create a subscription whose callback is guarded.

        Messages of lists alone, of which rclpy makes an object for each item, are not read where
        they are too long.
        """
        bounded = self.transport is None and not named.get("raw") and is_of_lists(msg_type)

        def read(data: bytes) -> None:
            if len(data) > LISTED:
                problem = f"{len(data)} bytes of lists; at most {LISTED} are valid"
                self.guard.refused(self, topic, problem)
                return
            try:
                message = deserialize_message(data, msg_type)
            except RMWError:
                problem = f"{len(data)} bytes that are no {msg_type.__name__}"
                self.guard.refused(self, topic, problem)
                return
            callback(message)

        named["raw"] = bounded or named.get("raw", False)
        deliver = self.guarded(topic, read if bounded else callback)
        return super().create_subscription(msg_type, topic, deliver, *options, **named)

    def create_service(
        self, srv_type: Any, srv_name: str, callback: Any, *options: Any, **named: Any
    ) -> Any:
        """Create a service that answers also where its callback fails, and many at once."""
        named.setdefault("qos_profile", qos.SERVICES)
        answering = self.answering(srv_name, callback)
        return super().create_service(srv_type, srv_name, answering, *options, **named)

    def create_timer(self, period: float, callback: Any, *options: Any, **named: Any) -> Any:
        """Create a timer whose callback is guarded."""
        guarded = self.guarded("timer", callback)
        return super().create_timer(period, guarded, *options, **named)


class GuardedNode(Guarded, Node):
    """A plain rclpy node whose callbacks are guarded; options are those of rclpy's Node."""

    def __init__(
        self, guard: Guard, name: str, transport: Registry | None = None, **options: Any
    ) -> None:
        self.guard, self.transport = guard, transport
        super().__init__(name, **{"enable_rosout": transport is None, **options})
