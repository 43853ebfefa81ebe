"""The lifecycle of nodes of the local transport: what rclpy makes of the middleware alone."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from lifecycle_msgs.msg import State, TransitionEvent
from lifecycle_msgs.srv import ChangeState, GetAvailableStates, GetAvailableTransitions, GetState

LIFECYCLE_SERVICES = {
    "change_state": ChangeState,
    "get_state": GetState,
    "get_available_states": GetAvailableStates,
    "get_available_transitions": GetAvailableTransitions,
    "get_transition_graph": GetAvailableTransitions,
}
"""The services of a lifecycle node, by name."""


class AnnouncedStates:
    """A state machine of rclpy's whose transitions are published by the local transport."""

    def __init__(self, node: Any, machine: Any) -> None:
        self._machine = machine
        self._out = node.create_publisher(TransitionEvent, "~/transition_event", 10)

    def __getattr__(self, name: str) -> Any:
        """Return what the state machine has."""
        return getattr(self._machine, name)

    def trigger_transition_by_id(self, number: int, publish: bool) -> None:
        """Make a transition."""
        self._announce(self._machine.trigger_transition_by_id, number)

    def trigger_transition_by_label(self, label: str, publish: bool) -> None:
        """Make a transition."""
        self._announce(self._machine.trigger_transition_by_label, label)

    def _announce(self, trigger: Callable[[Any, bool], None], which: Any) -> None:
        states = [self._machine.current_state]
        trigger(which, False)
        states.append(self._machine.current_state)
        start, goal = (State(id=number, label=label) for number, label in states)
        self._out.publish(TransitionEvent(start_state=start, goal_state=goal))
