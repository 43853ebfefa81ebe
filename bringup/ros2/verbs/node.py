"""`ros2 node list`, `info`."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from typing import Any

from rclpy.action import (
    get_action_client_names_and_types_by_node,
    get_action_server_names_and_types_by_node,
)

from bringup.ros2.client import Client, absolute, visible_types
from bringup.ros2.errors import Ros2Error

_TWICE = (
    "WARNING: Be aware that there are nodes in the graph that share an exact name, "
    "which can have unintended side effects.\n"
)


def list_nodes(arguments: argparse.Namespace) -> int:
    """List the nodes."""
    with Client(arguments) as client:
        client.discover()
        names = client.nodes(arguments.all)
    if arguments.count_nodes:
        print(len(names))
        return 0
    if len(set(names)) < len(names):
        sys.stderr.write(_TWICE)
    for name in names:
        print(name)
    return 0


def info(arguments: argparse.Namespace) -> int:
    """Print what a node publishes, subscribes to, serves and calls.

    Raises:
        Ros2Error: There is no such node.
    """
    full, hidden = absolute(arguments.node_name), arguments.include_hidden
    with Client(arguments) as client:
        if not client.discover(lambda: full in client.nodes(hidden)):
            raise Ros2Error(f"Unable to find node '{arguments.node_name}'")
        client.discover()
        count = client.nodes(hidden).count(full)
        if count > 1:
            sys.stderr.write(
                f'There are {count} nodes in the graph with the exact name "{full}". '
                "You are seeing information about only one of them.\n"
            )
        print(full)
        for title, pairs in sections(client, full):
            print(f"  {title}:")
            for name, types in visible_types(pairs, hidden):
                print(f"    {name}: {', '.join(types)}")
            if not visible_types(pairs, hidden):
                print()  # as ros2cli
    return 0


def sections(client: Client, full: str) -> list[tuple[str, Sequence[tuple[str, Sequence[str]]]]]:
    """Return what a node has, under ros2cli's titles: names and types."""
    space, _, name = full.rpartition("/")
    node, space = client.node, space or "/"
    actions: list[tuple[str, Callable[..., Any]]] = [
        ("Action Servers", get_action_server_names_and_types_by_node),
        ("Action Clients", get_action_client_names_and_types_by_node),
    ]
    return [
        ("Subscribers", node.get_subscriber_names_and_types_by_node(name, space)),
        ("Publishers", node.get_publisher_names_and_types_by_node(name, space)),
        ("Service Servers", node.get_service_names_and_types_by_node(name, space)),
        ("Service Clients", node.get_client_names_and_types_by_node(name, space)),
        *((title, get(node, name, space)) for title, get in actions),
    ]
