"""GoalNode: a managed node that serves actions."""

from __future__ import annotations

from arjuna_core.ros.goal_server import GoalServer
from arjuna_core.ros.node import ManagedNode


class GoalNode(ManagedNode):
    """Stops and aborts every goal where the node is deactivated or time is set back."""

    def halt(self) -> None:
        """Stop what the goals set in motion; they are aborted next."""

    def deactivate(self) -> None:
        """Stop and abort what is asked for."""
        self._abort("the node was deactivated")

    def on_time_jump(self) -> None:
        """Stop and abort: what was asked for belongs to another time."""
        if self.active:
            self._abort("time was set back")

    def on_failure(self, reason: str) -> None:
        """Stop and abort: what the goals were to do cannot be done."""
        if self.active:
            self._abort(f"the node failed: {reason}")

    def _abort(self, reason: str) -> None:
        self.halt()
        for server in self.kept(GoalServer):
            server.abort_all(reason)
