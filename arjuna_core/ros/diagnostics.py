"""The state of a process on /diagnostics once a second, a status for each node."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

from arjuna_core.ros import qos
from arjuna_core.ros.convert import header
from arjuna_core.ros.health.guard import Guard
from arjuna_core.timing import Periodic

_LEVELS = {"failed": DiagnosticStatus.ERROR, "refused": DiagnosticStatus.WARN}


class Diagnostics:
    """Publishes what a guard counted, where somebody listens.

    Args:
        node: The process's own node.
        guard: The process's.
        recent: Time that a status stays worse than OK after the last that went wrong [s].
    """

    def __init__(self, node: Any, guard: Guard, recent: float = 10.0) -> None:
        self._node, self._guard, self._recent = node, guard, recent
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
        """Return a node's status: as bad as the worst of the last seconds, with all counts."""
        name = node.get_fully_qualified_name()
        tallies = [(s, t) for (node, s), t in self._guard.tallies.items() if node == name]
        recent = [t for _, t in tallies if 0.0 <= now - t.at < self._recent]
        status = DiagnosticStatus(name=f"{name}: messages", hardware_id=self._node.get_name())
        status.level = max((_LEVELS[t.kind] for t in recent), default=DiagnosticStatus.OK)
        status.message = recent[-1].reason if recent else "all could be used"
        status.values = [
            KeyValue(key=f"{source} {t.kind}", value=f"{t.count}, the last: {t.reason}")
            for source, t in tallies
        ]
        trouble = node.trouble()
        if trouble:
            status.level, status.message = DiagnosticStatus.ERROR, trouble
        return status
