"""`ros2 lifecycle nodes`, `get`, `set`, `list`."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable
from typing import Any

from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState, GetAvailableTransitions, GetState

from bringup.ros2.client import Client, print_names, say_failed
from bringup.ros2.errors import Ros2Error

_GET_STATE = "lifecycle_msgs/srv/GetState"
_UP = (
    Transition(id=Transition.TRANSITION_CONFIGURE, label="configure"),
    Transition(id=Transition.TRANSITION_ACTIVATE, label="activate"),
)
"""What a node that came up by itself takes as done; by their labels others refuse it unharmed."""


def nodes(arguments: argparse.Namespace) -> None:
    """List the nodes with a lifecycle."""
    with Client(arguments) as client:
        client.discover()
        names = _managed(client, arguments.all)
    print_names(names, arguments.count_nodes)


def _managed(client: Client, hidden: bool) -> list[str]:
    served = dict(client.node.get_service_names_and_types())
    return [
        name
        for name in sorted(set(client.nodes(hidden)))
        if _GET_STATE in served.get(f"{name}/get_state", [])
    ]


def _find(client: Client, arguments: argparse.Namespace) -> str:
    node = client.find_node(arguments.node_name, arguments.include_hidden_nodes)
    if not client.discover(lambda: node in _managed(client, hidden=True)):
        raise Ros2Error("Node not found")
    return node


def get(arguments: argparse.Namespace) -> None:
    """Print the state of a node, or of all nodes with a lifecycle."""
    with Client(arguments) as client:
        if arguments.node_name:
            names = [_find(client, arguments)]
        else:
            client.discover()
            names = _managed(client, arguments.include_hidden_nodes)
        for name in names:
            try:
                answer = client.call(GetState, f"{name}/get_state", GetState.Request())
            except Ros2Error as error:
                if arguments.node_name:
                    raise
                say_failed(name, error)
                continue
            state = answer.current_state
            prefix = "" if arguments.node_name else f"{name}: "
            print(f"{prefix}{state.label} [{state.id}]")


def list_(arguments: argparse.Namespace) -> None:
    """Print the transitions that a node can make now, or all it has."""
    service = "get_transition_graph" if arguments.all else "get_available_transitions"
    with Client(arguments) as client:
        for item in _transitions(client, _find(client, arguments), service):
            print(f"- {item.transition.label} [{item.transition.id}]")
            print(f"\tStart: {item.start_state.label}")
            print(f"\tGoal: {item.goal_state.label}")


def _transitions(client: Client, node: str, service: str) -> list[Any]:
    request = GetAvailableTransitions.Request()
    answer = client.call(GetAvailableTransitions, f"{node}/{service}", request)
    return list(answer.available_transitions)


def _chosen(transitions: Iterable[Any], wanted: str) -> Any:
    """Return the transition of a label or number, None without one."""
    return next((item for item in transitions if wanted in (item.label, str(item.id))), None)


def set_(arguments: argparse.Namespace) -> None:
    """Make a node go through a transition, named by label or number."""
    with Client(arguments) as client:
        node = _find(client, arguments)
        offered = [
            item.transition for item in _transitions(client, node, "get_available_transitions")
        ]
        chosen = _chosen(offered, arguments.transition)
        asked, success = chosen or _chosen(_UP, arguments.transition), False
        if asked:
            request = ChangeState.Request(transition=asked)
            # a node may read a large map while it is configured
            answer = client.call(ChangeState, f"{node}/change_state", request, timeout=60.0)
            success = answer.success
        if not chosen and not success:
            lines = [f"- {item.label} [{item.id}]" for item in offered]
            title = "Unknown transition requested, available ones are:"
            raise Ros2Error("\n".join([title, *lines]))
    if success:
        print("Transitioning successful")
    else:
        sys.stderr.write("Transitioning failed\n")
