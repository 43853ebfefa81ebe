"""Events of lifecycles."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from launch.event_handler import Event


class ChangeState(Event):
    """A node is to change its state, by a number of lifecycle_msgs/Transition."""

    name = "launch_ros.events.lifecycle.ChangeState"

    def __init__(
        self, *, lifecycle_node_matcher: Callable[[Any], bool], transition_id: int
    ) -> None:
        self.lifecycle_node_matcher, self.transition_id = lifecycle_node_matcher, transition_id


class StateTransition(Event):
    """A node has changed its state."""

    name = "launch_ros.events.lifecycle.StateTransition"

    def __init__(self, *, action: Any, start_state: str, goal_state: str) -> None:
        self.action, self.start_state, self.goal_state = action, start_state, goal_state


def matches_node_name(*, node_name: str) -> Callable[[Any], bool]:
    return lambda action: action.node_name == f"/{node_name.lstrip('/')}"
