"""`ros2 node list`, `info`."""

from __future__ import annotations

import argparse
import sys

from rclpy.action import (
    get_action_client_names_and_types_by_node,
    get_action_server_names_and_types_by_node,
)

from bringup.ros2.client import Client, Names, absolute, print_names, visible_types
from bringup.ros2.errors import Ros2Error

_TWICE = (
    "WARNING: Be aware that there are nodes in the graph that share an exact name, "
    "which can have unintended side effects.\n"
)


def list_(arguments: argparse.Namespace) -> None:
    """List the nodes."""
    with Client(arguments) as client:
        client.discover()
        names = client.nodes(arguments.all)
    if len(set(names)) < len(names) and not arguments.count_nodes:
        sys.stderr.write(_TWICE)
    print_names(names, arguments.count_nodes)


def info(arguments: argparse.Namespace) -> None:
    """Print what a node publishes, subscribes to, serves and calls."""
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


def sections(client: Client, full: str) -> list[tuple[str, Names]]:
    """Return what a node has, under ros2cli's titles: names and types."""
    space, _, name = full.rpartition("/")
    node, space = client.node, space or "/"
    return [
        ("Subscribers", node.get_subscriber_names_and_types_by_node(name, space)),
        ("Publishers", node.get_publisher_names_and_types_by_node(name, space)),
        ("Service Servers", node.get_service_names_and_types_by_node(name, space)),
        ("Service Clients", node.get_client_names_and_types_by_node(name, space)),
        ("Action Servers", get_action_server_names_and_types_by_node(node, name, space)),
        ("Action Clients", get_action_client_names_and_types_by_node(node, name, space)),
    ]
