"""GoalNode: a managed node that serves actions."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from arjuna_core.config import param
from arjuna_core.ros.goal_server import GoalServer
from arjuna_core.ros.node import ManagedNode


def result_timeout(default: float) -> Any:
    """Declare Nav2's parameter `action_server_result_timeout` with a default [s]."""
    what = "How long a result is kept for a client that has not asked for it yet."
    return param(default, what, unit="s", minimum=0.0, read_only=True)


class GoalNode(ManagedNode):
    """Stops and aborts every goal where the node is deactivated or time is set back."""

    def offer(
        self, action: Any, name: str, on_goal: Callable[[], None], **options: Any
    ) -> GoalServer:
        """Serve an action; results are kept as the parameter `action_server_result_timeout` says.

        Args:
            action: The action.
            name: Its name.
            on_goal: Called after a goal became current or pending.
            options: More arguments of GoalServer.
        """
        options["result_timeout"] = getattr(self.config, "action_server_result_timeout", 10.0)
        server: GoalServer = self.keep(GoalServer(self, action, name, on_goal, **options))
        return server

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
