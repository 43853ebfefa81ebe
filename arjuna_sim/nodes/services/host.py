"""Requests to the simulator's node: what services need of it, and how a request ends."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any, Protocol

from simulation_interfaces.msg import Result, SimulationState

from arjuna_core.errors import ArjunaError
from arjuna_sim.files.library import Library, ResourceError
from arjuna_sim.nodes.fleet import Fleet
from arjuna_sim.simulation import Simulation

OK = Result(result=Result.RESULT_OK)


class RequestError(ArjunaError):
    """A request that is refused.

    Attributes:
        result: What the client gets.
    """

    def __init__(self, code: int, problem: str) -> None:
        super().__init__(problem)
        self.result = Result(result=code, error_message=str(self))


def resource_error(response_type: Any, error: ResourceError) -> RequestError:
    """Return the refusal of a resource that cannot be used, by a service's own codes."""
    name = error.fault.value
    holder = Result if name.startswith("RESULT_") else response_type
    return RequestError(getattr(holder, name), str(error))


def need_world(host: Host, code: int = Result.RESULT_INCORRECT_STATE) -> None:
    """Refuse a request by a code while no world is loaded."""
    if host.state == SimulationState.STATE_NO_WORLD:
        raise RequestError(code, "no world is loaded; load one first")


def answering(
    answer: Callable[[Any, Any], None], in_world: Host | None = None
) -> Callable[[Any, Any], Any]:
    """Return a service's callback: what the answer raises becomes the response's result.

    Args:
        in_world: Refuses all requests while no world is loaded, where it is given.
    """

    def callback(request: Any, response: Any) -> Any:
        response.result = OK
        try:
            if in_world is not None:
                need_world(in_world)
            answer(request, response)
        except RequestError as error:
            response.result = error.result
        return response

    return callback


def serve_all(
    host: Host,
    services: Iterable[tuple[Any, str, Callable[[Any, Any], None]]],
    in_world: Host | None = None,
) -> dict[str, Callable[[Any, Any], Any]]:
    """Create services of types and names; return their callbacks, `answering`'s, by name."""
    answers = {}
    for kind, name, answer in services:
        answers[name] = answering(answer, in_world)
        host.serve(kind, name, answers[name])
    return answers


class Host(Protocol):
    """A running simulation that clients control.

    Attributes:
        fleet: The robots that have nodes of their own.
        library: What clients may name.
        state: A SimulationState constant: whether simulated time runs.
        quitting: Whether a client asked the process to end.
    """

    simulator: Simulation
    fleet: Fleet
    library: Library
    state: int
    quitting: bool

    def get_logger(self) -> Any:
        """Return the log that a person reads."""

    def serve(self, service_type: Any, name: str, callback: Callable[[Any, Any], Any]) -> None:
        """Create a service that lives until cleanup."""

    def advance(self) -> None:
        """Advance one tick and publish what it brought."""

    def after_reset(self) -> None:
        """Count contacts from zero, and publish the time, which was set back."""

    def publish_time(self) -> None:
        """Publish the time, where it was set back."""
