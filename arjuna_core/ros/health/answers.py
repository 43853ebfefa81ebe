"""Answers of services that could not do what they were asked, each in its type's own words."""

from __future__ import annotations

from typing import Any

from rcl_interfaces.msg import SetParametersResult

_TEXTS = ("error_message", "error_msg", "message", "status_message", "reason")
_INVALID_CODES = ("INVALID_PATH", "INVALID_INPUT", "INVALID_POSE")
_CODES = ("RESULT_OPERATION_FAILED", "RESULT_UNDEFINED_FAILURE", "RESULT_FAILED_TO_WRITE_FILE")
_NO_COST = -1.0  # nav2's GetCost, of a place that has none


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
        answer.cost = _NO_COST
    for name in _TEXTS:
        if fields.get(name) == "string":
            setattr(answer, name, reason)
    for name in ("result", "status"):
        if "/" in fields.get(name, ""):
            _explain(getattr(answer, name), reason)
