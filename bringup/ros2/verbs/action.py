"""`ros2 action list`, `info`, `type`, `find`, `send_goal`."""

from __future__ import annotations

import argparse
import contextlib
import math
from collections.abc import Callable
from typing import Any

from action_msgs.msg import GoalStatus
from rclpy.action import (
    ActionClient,
    get_action_client_names_and_types_by_node,
    get_action_names_and_types,
    get_action_server_names_and_types_by_node,
)

from bringup.ros2.client import (
    Client,
    Names,
    full_name,
    print_names,
    print_types,
    with_types,
)
from bringup.ros2.errors import Ros2Error
from bringup.ros2.filling import fill
from bringup.ros2.types import interface_class
from bringup.ros2.values import to_yaml
from bringup.ros2.verbs.pub import values_of

_WRONG = "Failed to populate message fields: {!r}"


def list_actions(arguments: argparse.Namespace) -> None:
    """List the actions."""
    print_names(with_types(_actions(arguments), arguments.show_types), arguments.count_actions)


def find(arguments: argparse.Namespace) -> None:
    """List the actions of a type."""
    names = [name for name, types in _actions(arguments) if arguments.action_type in types]
    print_names(names, arguments.count_actions)


def _actions(arguments: argparse.Namespace) -> Names:
    with Client(arguments) as client:
        client.discover()
        return list(get_action_names_and_types(client.node))


def type_of(arguments: argparse.Namespace) -> int:
    """Print an action's types; 1 if there is no such action."""
    return print_types(arguments, arguments.action_name, get_action_names_and_types)


def info(arguments: argparse.Namespace) -> None:
    """Print which nodes serve an action and which are its clients."""
    name = full_name(arguments.action_name)
    with Client(arguments) as client:
        client.find_types(name, get_action_names_and_types)
        clients = _nodes_with(client, name, get_action_client_names_and_types_by_node)
        servers = _nodes_with(client, name, get_action_server_names_and_types_by_node)
    print(f"Action: {arguments.action_name}")
    for title, pairs in (("clients", clients), ("servers", servers)):
        print(f"Action {title}: {len(pairs)}")
        for line in [] if arguments.count else with_types(pairs, arguments.show_types):
            print(f"    {line}")


def _nodes_with(client: Client, action: str, get: Callable[..., Any]) -> Names:
    found = []
    for full in client.nodes(hidden=True):
        space, _, name = full.rpartition("/")
        types = dict(get(client.node, name, space or "/")).get(action)
        if types:
            found.append((full, types))
    return found


def send_goal(arguments: argparse.Namespace) -> None:
    """Send a goal and print how it ends; an interrupt cancels it.

    Raises:
        Ros2Error: The type or a field does not exist.
    """
    action_type = interface_class(arguments.action_type, "action")
    goal = action_type.Goal()
    stamps = fill(goal, values_of(arguments.goal, arguments.stdin), _WRONG)
    with Client(arguments) as client, contextlib.ExitStack() as opened:
        action = ActionClient(client.node, action_type, full_name(arguments.action_name))
        opened.callback(action.destroy)
        print("Waiting for an action server to become available...")
        client.spin(action.server_is_ready)
        for stamp in stamps:
            stamp(client.node.get_clock().now().to_msg())
        print(f"Sending goal:\n     {to_yaml(goal)}")
        feedback = _Feedback()
        taken = feedback.take if arguments.feedback else None
        handle = client.send_goal(action, goal, taken, math.inf)
        if not handle.accepted:
            print("Goal was rejected.")
            return
        print(f"Goal accepted with ID: {bytes(handle.goal_id.uuid).hex()}\n")
        feedback.start()
        try:
            outcome = client.result(handle.get_result_async())
        except KeyboardInterrupt:
            _cancel(client, handle)
            raise
        print(f"Result:\n    {to_yaml(outcome.result)}")
        print(f"Goal finished with status: {status_name(outcome.status)}")


class _Feedback:
    """Prints feedback; what comes before the goal is said to be accepted waits until then."""

    def __init__(self) -> None:
        self._waiting: list[Any] | None = []

    def take(self, message: Any) -> None:
        """Print a feedback message, or keep it."""
        if self._waiting is not None:
            self._waiting.append(message)
            return
        print(f"Feedback:\n    {to_yaml(message.feedback)}")

    def start(self) -> None:
        """Print what was kept, and from now on what comes."""
        waiting, self._waiting = self._waiting or [], None
        for message in waiting:
            self.take(message)


def _cancel(client: Client, handle: Any) -> None:
    print("Canceling goal...")
    answer = client.cancel(handle)
    if not answer.goals_canceling:
        raise Ros2Error("Failed to cancel goal")
    print("Goal canceled.")


def status_name(status: int) -> str:
    """Return the word for a goal's status."""
    names = ("UNKNOWN", "ACCEPTED", "EXECUTING", "CANCELING", "SUCCEEDED", "CANCELED", "ABORTED")
    return next(
        (name for name in names if getattr(GoalStatus, f"STATUS_{name}") == status), names[0]
    )
