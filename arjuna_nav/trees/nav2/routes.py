"""Nav2's actions that navigate: along a graph's routes, and to goals of their own.

Source: nav2_behavior_tree, plugins/action.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from arjuna_nav.trees.asking import SERVER_PORTS, Asking
from arjuna_nav.trees.exchange import Answer
from arjuna_nav.trees.node import Status
from arjuna_nav.trees.ports import NUMBER, PATH, POSE, POSES, TEXT, TRUTH, WHOLE, Port


class ComputeRoute(Asking):
    """Looks for a route; its nodes are written as poses."""

    KIND, SERVER = "ComputeRoute", "compute_route"
    PORTS: ClassVar[dict[str, Port]] = {
        **SERVER_PORTS,
        "start_id": Port(WHOLE, None),
        "goal_id": Port(WHOLE, None),
        "start": Port(POSE, None),
        "goal": Port(POSE, None),
        "use_start": Port(TRUTH, False),
        "use_poses": Port(TRUTH, False),
        "route": Port(POSES, None, output=True),
        "path": Port(PATH, None, output=True),
        "planning_time": Port(NUMBER, 0.0, output=True),
    }
    FIELDS: ClassVar[Mapping[str, str]] = {
        name: name for name in ("start_id", "goal_id", "start", "goal", "use_start", "use_poses")
    }

    def while_running(self) -> None:
        """Ask anew where the goal has changed."""
        if self.request() != self._asked:
            self.ask()


class ComputeAndTrackRoute(ComputeRoute):
    """Looks for a route and tells how far along it the robot is, until it has come to its end."""

    KIND, SERVER = "ComputeAndTrackRoute", "compute_and_track_route"
    FEEDBACK = True
    PORTS: ClassVar[dict[str, Port]] = {
        **{name: port for name, port in ComputeRoute.PORTS.items() if name != "planning_time"},
        "last_node_id": Port(WHOLE, 0, output=True),
        "next_node_id": Port(WHOLE, 0, output=True),
        "current_edge_id": Port(WHOLE, 0, output=True),
        "rerouted": Port(TRUTH, False, output=True),
        "execution_time": Port(NUMBER, 0.0, output=True),
    }

    def take(self, answer: Answer) -> Status:
        """Write how long it took."""
        self.put("execution_time", answer.values.get("execution_duration"))
        return super().take(answer)


class NavigateToPose(Asking):
    """Lets another navigator go to a pose."""

    KIND, SERVER = "NavigateToPose", "navigate_to_pose"
    PORTS: ClassVar[dict[str, Port]] = {
        **SERVER_PORTS,
        "goal": Port(POSE),
        "behavior_tree": Port(TEXT, ""),
    }
    FIELDS: ClassVar[Mapping[str, str]] = {"goal": "pose", "behavior_tree": "behavior_tree"}


class NavigateThroughPoses(Asking):
    """Lets another navigator go through poses."""

    KIND, SERVER = "NavigateThroughPoses", "navigate_through_poses"
    PORTS: ClassVar[dict[str, Port]] = {
        **SERVER_PORTS,
        "goals": Port(POSES),
        "behavior_tree": Port(TEXT, ""),
    }
    FIELDS: ClassVar[Mapping[str, str]] = {"goals": "poses", "behavior_tree": "behavior_tree"}
