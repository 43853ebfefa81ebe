"""How a request to the simulator ended, as simulation_interfaces says it."""

from __future__ import annotations

from typing import Any

from simulation_interfaces.msg import Result

from arjuna_core.errors import ArjunaError
from arjuna_sim.files.library import ResourceError

OK = Result(result=Result.RESULT_OK)


def refusal(code: int, problem: str) -> Result:
    """Return a result that says what is wrong."""
    return Result(result=code, error_message=problem)


def resource_refusal(response_type: Any, error: ResourceError) -> Result:
    """Return the result for a resource that cannot be used, by a service's own codes.

    Args:
        response_type: The service's response, which has the codes.
        error: What is wrong with the resource.
    """
    name = error.fault.value
    holder = Result if name.startswith("RESULT_") else response_type
    return refusal(getattr(holder, name), str(error))


class RequestError(ArjunaError):
    """A request that is refused.

    Args:
        code: The result's code.
        problem: What is wrong and what is valid.

    Attributes:
        result: What the client gets.
    """

    def __init__(self, code: int, problem: str) -> None:
        self.result = refusal(code, problem)
        super().__init__(problem)
