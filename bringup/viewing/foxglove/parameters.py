"""Parameters of all nodes, under the names that Foxglove knows them by: `/node.parameter`."""

from __future__ import annotations

import time
from collections.abc import Callable
from concurrent.futures import Future
from typing import Any

from rcl_interfaces.srv import GetParameters, ListParameters, SetParameters
from rclpy.parameter import Parameter, parameter_value_to_python

from bringup.viewing.robot.services import Services

_SUFFIX = "/list_parameters"


class Question:
    """A client's question for parameters, all where it names none, perhaps after setting them.

    Args:
        names: `/node.parameter`.
        values: Values to set before, by name.

    Attributes:
        answer: Takes the values, by name.
    """

    deadline = 3.0
    """For a node's answer [s]."""

    def __init__(self, names: tuple[str, ...], values: dict[str, Any] | None = None) -> None:
        self.names, self.values = names, values or {}
        self.answer: Future[dict[str, Any]] = Future()
        self.pending, self.found = 0, dict[str, Any]()
        self.end = time.monotonic() + self.deadline


class Parameters:
    """Asks the nodes' own services."""

    def __init__(self, services: Services) -> None:
        self._services = services
        self._questions: list[Question] = []

    def ask(self, question: Question) -> None:
        """Set and get parameters; the answer comes when all nodes have answered, or late."""
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
            question.answer.set_result(question.found)

    def _list_then_get(self, question: Question, node: str) -> None:
        self._call(
            *(question, ListParameters, f"{node}{_SUFFIX}", ListParameters.Request()),
            lambda response: self._get(question, node, list(response.result.names)),
        )

    def _set_then_get(self, question: Question, node: str, names: list[str]) -> None:
        full = {name: f"{node}.{name}" for name in names}
        given = {n: question.values[f] for n, f in full.items() if f in question.values}
        if not given:
            self._get(question, node, names)
            return
        messages = [
            Parameter(name, value=value).to_parameter_msg() for name, value in given.items()
        ]
        self._call(
            *(question, SetParameters, f"{node}/set_parameters"),
            SetParameters.Request(parameters=messages),
            lambda response: self._get(question, node, names),
        )

    def _get(self, question: Question, node: str, names: list[str]) -> None:
        def take(response: Any) -> None:
            for name, value in zip(names, response.values, strict=False):
                question.found[f"{node}.{name}"] = parameter_value_to_python(value)

        request = GetParameters.Request(names=names)
        self._call(question, GetParameters, f"{node}/get_parameters", request, take)

    def _call(
        self, question: Question, kind: Any, name: str, request: Any, then: Callable[[Any], None]
    ) -> None:
        def answered(response: Any) -> None:
            then(response)
            question.pending -= 1

        if self._services.ask(kind, name, request, answered, question.deadline):
            question.pending += 1


def _by_node(names: tuple[str, ...]) -> dict[str, list[str]]:
    grouped: dict[str, list[str]] = {}
    for name in names:
        node, _, parameter = name.partition(".")
        grouped.setdefault(node, []).append(parameter)
    return grouped
