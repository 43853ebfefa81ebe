"""Parameters of all nodes, under the names that Foxglove knows them by: `/node.parameter`."""

from __future__ import annotations

import base64
import math
import time
from collections.abc import Callable, Iterable, Sequence
from typing import Any

from rcl_interfaces.msg import ParameterEvent, ParameterType
from rcl_interfaces.srv import GetParameters, ListParameters, SetParameters
from rclpy.node import Node
from rclpy.parameter import Parameter, parameter_value_to_python
from rclpy.qos import qos_profile_parameter_events

from bringup.viewing.foxglove.server import WARNING, Client
from bringup.viewing.robot.services import Services

_SUFFIX = "/list_parameters"
_TYPED = {
    ParameterType.PARAMETER_DOUBLE: "float64",
    ParameterType.PARAMETER_DOUBLE_ARRAY: "float64_array",
    ParameterType.PARAMETER_BYTE_ARRAY: "byte_array",
}
"""The protocol's names of the types that a value in JSON leaves open."""


class _Question:
    """A client's question for parameters, all where it names none, perhaps after setting them.

    Args:
        names: `/node.parameter`.
    """

    deadline = 3.0
    """For a node's answer [s]."""

    def __init__(self, client: Client, message: Any, names: list[str], values: Any = None) -> None:
        self.client, self.names, self.values = client, names, values or {}
        self.identity = {"id": message["id"]} if "id" in message else {}
        self.pending, self.found = 0, list[dict[str, Any]]()
        self.end = time.monotonic() + self.deadline


class Parameters:
    """Asks the nodes' own services, and hears of changes on `/parameter_events`."""

    def __init__(self, node: Node, services: Services) -> None:
        self._node, self._services = node, services
        self._questions: list[_Question] = []
        self._subscribed: dict[Client, set[str]] = {}
        self._events: Any = None

    def get(self, client: Client, message: Any) -> None:
        """Send parameters; the answer goes when all nodes have answered, or late."""
        self._ask(_Question(client, message, [str(name) for name in message["parameterNames"]]))

    def set(self, client: Client, message: Any) -> None:
        """Set parameters, then send what they are."""
        values = {str(item["name"]): _native(item) for item in message["parameters"]}
        if values:
            self._ask(_Question(client, message, list(values), values))

    def subscribe(self, client: Client, message: Any) -> None:
        """Send a client what changes of some parameters."""
        self._subscribed.setdefault(client, set()).update(message["parameterNames"])
        if self._events is None:
            self._events = self._node.create_subscription(
                *(ParameterEvent, "/parameter_events", self._on_event),
                qos_profile_parameter_events,
            )

    def unsubscribe(self, client: Client, message: Any) -> None:
        """Send a client changes of some parameters no more."""
        self._subscribed.get(client, set()).difference_update(message["parameterNames"])

    def forget(self, client: Client) -> None:
        """Take note that a client is gone."""
        self._subscribed.pop(client, None)

    def _on_event(self, event: ParameterEvent) -> None:
        changed = {
            f"{event.node}.{each.name}": each.value
            for each in (*event.new_parameters, *event.changed_parameters)
        }
        for client, names in self._subscribed.items():
            if found := [_described(n, v) for n, v in changed.items() if n in names]:
                client.send_message("parameterValues", parameters=found)

    def _ask(self, question: _Question) -> None:
        self._questions.append(question)
        if question.names:
            for node, names in _by_node(question.names).items():
                self._set_then_get(question, node, names)
        else:
            for service in self._services.of_type("rcl_interfaces/srv/ListParameters"):
                self._list_then_get(question, service.removesuffix(_SUFFIX))

    def tick(self) -> None:
        """Answer the questions that are complete or late."""
        now = time.monotonic()
        for question in [q for q in self._questions if q.pending == 0 or now > q.end]:
            self._questions.remove(question)
            question.client.send_message(
                "parameterValues", parameters=question.found, **question.identity
            )

    def _list_then_get(self, question: _Question, node: str) -> None:
        self._call(
            *(question, ListParameters, f"{node}{_SUFFIX}", ListParameters.Request()),
            lambda response: self._get(question, node, list(response.result.names)),
        )

    def _set_then_get(self, question: _Question, node: str, names: list[str]) -> None:
        full = {name: f"{node}.{name}" for name in names}
        given = {n: question.values[f] for n, f in full.items() if f in question.values}
        if not given:
            self._get(question, node, names)
            return
        messages = [
            Parameter(name, value=value).to_parameter_msg() for name, value in given.items()
        ]

        def answered(response: Any) -> None:
            for name, result in zip(given, response.results, strict=False):
                if not result.successful:
                    question.client.send_status(WARNING, f"{full[name]}: {result.reason}")
            self._get(question, node, names)

        self._call(
            *(question, SetParameters, f"{node}/set_parameters"),
            *(SetParameters.Request(parameters=messages), answered),
        )

    def _get(self, question: _Question, node: str, names: list[str]) -> None:
        def take(response: Any) -> None:
            for name, value in zip(names, response.values, strict=False):
                question.found.append(_described(f"{node}.{name}", value))

        request = GetParameters.Request(names=names)
        self._call(question, GetParameters, f"{node}/get_parameters", request, take)

    def _call(
        self, question: _Question, kind: Any, name: str, request: Any, then: Callable[[Any], None]
    ) -> None:
        def answered(response: Any) -> None:
            then(response)
            question.pending -= 1

        if self._services.ask(kind, name, request, answered, question.deadline):
            question.pending += 1


def _described(name: str, message: Any) -> dict[str, Any]:
    """Return a parameter as it is sent; JSON has no infinite numbers, and none is sent then."""
    value = parameter_value_to_python(message)
    kind = _TYPED.get(message.type)
    if kind == "byte_array":
        value = base64.b64encode(b"".join(value)).decode()
    elif isinstance(value, Sequence) and not isinstance(value, str):
        value = [_sent(each) for each in value]
    return {"name": name, "value": _sent(value)} | ({"type": kind} if kind else {})


def _sent(value: Any) -> Any:
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _native(item: Any) -> Any:
    """Return the value of a parameter as it came."""
    value, kind = item.get("value"), item.get("type")
    if kind == "byte_array":
        return [bytes([each]) for each in base64.b64decode(value)]
    if kind == "float64_array":
        return [float(each) for each in value]
    return float(value) if kind == "float64" else value


def _by_node(names: Iterable[str]) -> dict[str, list[str]]:
    grouped: dict[str, list[str]] = {}
    for name in names:
        node, _, parameter = name.partition(".")
        grouped.setdefault(node, []).append(parameter)
    return grouped
