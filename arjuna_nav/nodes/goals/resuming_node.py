"""ResumingNode: a node whose goal may outlive its process."""

from __future__ import annotations

from arjuna_core.ros.goal_node import GoalNode
from arjuna_nav.nodes.goals.memory import GoalMemory


class ResumingNode(GoalNode):
    """Goes on with the goal under way after a crash or a jump of time, if `resume_file` is set.

    Attributes:
        memory: The goal under way; made in `configure`.
    """

    memory: GoalMemory

    def activate(self) -> None:
        """Look for a goal that was under way when the process ended."""
        self.memory.recall()

    def deactivate(self) -> None:
        """Stop and abort what is asked for; it is not gone on with."""
        super().deactivate()
        self.memory.forget()

    def on_time_jump(self) -> None:
        """Stop and abort, or go on with the goal under way if that is asked for."""
        if not self.config.resume_file:
            super().on_time_jump()
        elif self.active:
            self.go_on()

    def go_on(self) -> None:
        """Go on with the goal under way at another time."""
