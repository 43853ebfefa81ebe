"""simulation_interfaces: steps of a paused simulation as an action."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from simulation_interfaces.action import SimulateSteps
from simulation_interfaces.msg import Result, SimulationState

from arjuna_core.ros.goal_server import GoalServer
from arjuna_core.ros.node import ManagedNode
from arjuna_sim.nodes.services.results import OK, RequestError

_STEPS_MAX = 1_000_000  # five hours of simulated time; more is a slip of the client's


def check_steps(state: int, steps: int, most: int) -> None:
    """Refuse a number of steps that cannot be simulated in a SimulationState.

    Raises:
        RequestError: The simulation is not paused, or there are none or too many.
    """
    if state != SimulationState.STATE_PAUSED:
        problem = "steps are for a paused simulation; pause it first"
        raise RequestError(Result.RESULT_INCORRECT_STATE, problem)
    if not 1 <= steps <= most:
        problem = f"steps is {steps}; valid: 1 to {most}"
        raise RequestError(Result.RESULT_OPERATION_FAILED, problem)


class StepAction(GoalServer):
    """The action simulate_steps: a tick at a time, with progress.

    Args:
        node: The node, being configured.
        state: Returns the present SimulationState constant.
    """

    def __init__(self, node: ManagedNode, state: Callable[[], int]) -> None:
        name, on_cancel = "simulate_steps", self._on_cancel_steps
        super().__init__(node, SimulateSteps, name, self._begin, on_cancel=on_cancel)
        self._state = state
        self._done = 0
        node.keep(self)

    def explained(self, reason: str) -> Any:
        """Return a result that says why a goal failed."""
        error = RequestError(Result.RESULT_OPERATION_FAILED, reason)
        return SimulateSteps.Result(result=error.result)

    def _begin(self) -> None:
        if self.preempt_requested:
            self.abort_pending(self.explained("other steps are being simulated"))
            return
        self._done = 0
        goal: Any = self.goal
        try:
            check_steps(self._state(), goal.steps, _STEPS_MAX)
        except RequestError as error:
            self.abort(SimulateSteps.Result(result=error.result))

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
