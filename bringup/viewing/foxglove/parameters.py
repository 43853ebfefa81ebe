"""Parameters of all nodes, under the names that Foxglove knows them by: `/node.parameter`."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from rcl_interfaces.srv import GetParameters, ListParameters, SetParameters
from rclpy.parameter import Parameter, parameter_value_to_python

from bringup.viewing.foxglove.listener import ParametersWanted
from bringup.viewing.robot.services import Services

_DEADLINE = 3.0
_SUFFIX = "/list_parameters"


class _Job:
    """A question under way: how many nodes have yet to answer.

    Args:
        wanted: The question.
        now: When it came [s, monotonic].
    """

    def __init__(self, wanted: ParametersWanted, now: float) -> None:
        self.wanted = wanted
        self.open = 0
        self.end = now + _DEADLINE
        self.values: dict[str, Any] = {}


class Parameters:
    """Asks the nodes' own services.

    Args:
        services: The bridge's service clients.
    """

    def __init__(self, services: Services) -> None:
        self._services = services
        self._jobs: list[_Job] = []

    def ask(self, wanted: ParametersWanted) -> None:
        """Set and get parameters; the answer comes when all nodes have answered, or late."""
        job = _Job(wanted, time.monotonic())
        self._jobs.append(job)
        if wanted.names:
            for node, names in _by_node(wanted.names).items():
                self._set_then_get(job, node, names)
        else:
            for service in self._services.of_type("rcl_interfaces/srv/ListParameters"):
                self._list_then_get(job, service.removesuffix(_SUFFIX))

    def tick(self) -> None:
        """Answer the questions that are complete or late."""
        now = time.monotonic()
        for job in [job for job in self._jobs if job.open == 0 or now > job.end]:
            self._jobs.remove(job)
            job.wanted.answer.set_result(job.values)

    def _list_then_get(self, job: _Job, node: str) -> None:
        self._call(
            *(job, ListParameters, f"{node}{_SUFFIX}", ListParameters.Request()),
            lambda response: self._get(job, node, list(response.result.names)),
        )

    def _set_then_get(self, job: _Job, node: str, names: list[str]) -> None:
        given = {
            n: job.wanted.values[f"{node}.{n}"] for n in names if f"{node}.{n}" in job.wanted.values
        }
        if not given:
            self._get(job, node, names)
            return
        messages = [
            Parameter(name, value=value).to_parameter_msg() for name, value in given.items()
        ]
        self._call(
            *(job, SetParameters, f"{node}/set_parameters"),
            SetParameters.Request(parameters=messages),
            lambda response: self._get(job, node, names),
        )

    def _get(self, job: _Job, node: str, names: list[str]) -> None:
        def take(response: Any) -> None:
            for name, value in zip(names, response.values, strict=False):
                job.values[f"{node}.{name}"] = parameter_value_to_python(value)

        request = GetParameters.Request(names=names)
        self._call(job, GetParameters, f"{node}/get_parameters", request, take)

    def _call(
        self, job: _Job, kind: Any, name: str, request: Any, then: Callable[[Any], None]
    ) -> None:
        def answered(response: Any) -> None:
            then(response)
            job.open -= 1

        if self._services.ask(kind, name, request, answered, _DEADLINE):
            job.open += 1


def _by_node(names: tuple[str, ...]) -> dict[str, list[str]]:
    """Group `/node.parameter` by node."""
    grouped: dict[str, list[str]] = {}
    for name in names:
        node, _, parameter = name.partition(".")
        grouped.setdefault(node, []).append(parameter)
    return grouped
