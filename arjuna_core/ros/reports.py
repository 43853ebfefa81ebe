"""Reports of what went wrong: in answers of services and actions, and on /diagnostics."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rcl_interfaces.msg import SetParametersResult

from arjuna_core.ros import qos
from arjuna_core.ros.convert import header
from arjuna_core.ros.health.guard import Guard
from arjuna_core.timing import Periodic

_LEVELS = {"failed": DiagnosticStatus.ERROR, "refused": DiagnosticStatus.WARN}
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


class Diagnostics:
    """Publishes what a guard counted, where somebody listens."""

    def __init__(self, node: Any, guard: Guard) -> None:
        self._node, self._guard = node, guard
        self._publisher = node.create_publisher(DiagnosticArray, "diagnostics", qos.DEFAULT)
        self._period = Periodic(1.0)

    def run_due(self, now: float, nodes: Iterable[Any], remarks: Iterable[str] = ()) -> None:
        """Publish what is due at a time [s]: a status for each node, and the remarks."""
        if self._period.due(now) and self._publisher.get_subscription_count():
            array = DiagnosticArray(header=header("", now))
            array.status = [self._status(node, now) for node in nodes]
            name = self._node.get_name()
            about = {"name": f"{name}: parameters", "hardware_id": name}
            array.status += [
                DiagnosticStatus(level=DiagnosticStatus.WARN, message=remark, **about)
                for remark in remarks
            ]
            self._publisher.publish(array)

    def _status(self, node: Any, now: float) -> DiagnosticStatus:
        """Return a node's status: as bad as the worst of the last 10 s, with all counts."""
        name = node.get_fully_qualified_name()
        tallies = [(s, t) for (node, s), t in self._guard.tallies.items() if node == name]
        recent = [t for _, t in tallies if 0.0 <= now - t.at < 10.0]
        status = DiagnosticStatus(name=f"{name}: messages", hardware_id=self._node.get_name())
        status.level = max((_LEVELS[t.kind] for t in recent), default=DiagnosticStatus.OK)
        status.message = recent[-1].reason if recent else "all could be used"
        status.values = [
            KeyValue(key=f"{source} {t.kind}", value=f"{t.count}, the last: {t.reason}")
            for source, t in tallies
        ]
        # A node without a lifecycle has no trouble; another one's is of what `configure` made.
        if trouble := node.trouble() if getattr(node, "configured", False) else "":
            status.level, status.message = DiagnosticStatus.ERROR, trouble
        return status
