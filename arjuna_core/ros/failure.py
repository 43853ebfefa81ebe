"""Answers of services and actions that say that something failed, and why."""

from __future__ import annotations

from typing import Any

from rcl_interfaces.msg import SetParametersResult

_TEXTS = ("error_message", "error_msg", "message", "status_message", "reason")
_INVALID_CODES = ("INVALID_PATH", "INVALID_INPUT", "INVALID_POSE")
_CODES = ("RESULT_OPERATION_FAILED", "RESULT_UNDEFINED_FAILURE", "RESULT_FAILED_TO_WRITE_FILE")


def invalid_code(result: Any, otherwise: int) -> int:
    """Return the code by which an action or a service says that its goal or request is invalid."""
    codes = (getattr(result, name) for name in _INVALID_CODES if hasattr(result, name))
    return int(next(codes, otherwise))


def failed(request: Any, response: Any, reason: str, invalid: bool = False) -> Any:
    """Return a fresh response that says that a request failed, and why where it has a field.

    A flag of success is false in a fresh response already. Each parameter that the request sets
    gets a result. `invalid` is for a request that was at fault.
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
        answer.cost = -1.0  # nav2's GetCost outside the costmap
    for name in _TEXTS:
        if fields.get(name) == "string":
            setattr(answer, name, reason)
    for name in ("result", "status"):
        if "/" in fields.get(name, ""):
            _explain(getattr(answer, name), reason)
