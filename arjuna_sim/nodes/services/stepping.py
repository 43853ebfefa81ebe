"""simulation_interfaces: steps of a paused simulation as an action."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from simulation_interfaces.action import SimulateSteps
from simulation_interfaces.msg import Result, SimulationState

from arjuna_core.ros.actions import GoalServer
from arjuna_sim.nodes.services.results import OK, refusal

if TYPE_CHECKING:
    from arjuna_sim.nodes.sim import SimNode

_STEPS_MAX = 1_000_000


def refuse_steps(node: SimNode, steps: int, most: int) -> Result | None:
    """Return why a number of steps cannot be simulated, or None."""
    if node.state != SimulationState.STATE_PAUSED:
        problem = "steps are for a paused simulation; pause it first"
        return refusal(Result.RESULT_INCORRECT_STATE, problem)
    if not 1 <= steps <= most:
        problem = f"steps is {steps}; valid: 1 to {most}"
        return refusal(Result.RESULT_OPERATION_FAILED, problem)
    return None


class StepAction(GoalServer):
    """The action simulate_steps: a tick at a time, with progress.

    Args:
        node: The node, being configured.
    """

    def __init__(self, node: SimNode) -> None:
        super().__init__(
            node, SimulateSteps, "simulate_steps", self._begin, on_cancel=self._on_cancel_steps
        )
        self._sim = node
        self._done = 0
        node.keep(self)

    def explained(self, reason: str) -> Any:
        """Return a result that says why a goal failed."""
        return SimulateSteps.Result(result=refusal(Result.RESULT_OPERATION_FAILED, reason))

    def _begin(self) -> None:
        if self.preempt_requested:
            self.abort_pending(self.explained("other steps are being simulated"))
            return
        self._done = 0
        goal: Any = self.goal
        refused = refuse_steps(self._sim, goal.steps, _STEPS_MAX)
        if refused is not None:
            self.abort(SimulateSteps.Result(result=refused))

    def count(self) -> None:
        """Take note of a tick."""
        goal = self.goal
        if goal is None:
            return
        self._done += 1
        left = goal.steps - self._done
        self.feedback(SimulateSteps.Feedback(completed_steps=self._done, remaining_steps=left))
        if left == 0:
            self.succeed(SimulateSteps.Result(result=OK))

    def _on_cancel_steps(self) -> None:
        if self.cancel_requested:
            self.cancel(self.explained(f"cancelled after {self._done} steps"))
