"""`list`, `find`, `type` and `info` of topics, services and actions."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from functools import partial
from operator import methodcaller
from typing import Any

from bringup.ros2.client import (
    Client,
    Names,
    absolute,
    full_name,
    print_names,
    visible_types,
    with_types,
)
from bringup.ros2.errors import Ros2Error


def names_of(kind: str) -> Callable[[Any], Names]:
    """Return what lists the topics, services or actions that a node sees, with their types."""
    if kind != "action":
        return methodcaller(f"get_{kind}_names_and_types")
    from rclpy.action import get_action_names_and_types  # takes a fifth of a second

    def actions(node: Any) -> Names:
        return list(get_action_names_and_types(node))

    return actions


def _hidden(arguments: argparse.Namespace) -> bool:
    """Return whether hidden names count; those of actions always do."""
    return bool(vars(arguments).get(f"include_hidden_{arguments.command}s", True))


def _found(client: Client, arguments: argparse.Namespace) -> Names:
    client.discover()
    return visible_types(names_of(arguments.command)(client.node), _hidden(arguments))


def list_(arguments: argparse.Namespace) -> None:
    """List the names."""
    count = vars(arguments)[f"count_{arguments.command}s"]
    with Client(arguments) as client:
        pairs = _found(client, arguments)
        if not (vars(arguments).get("verbose") and pairs and not count):
            print_names(with_types(pairs, arguments.show_types), count)
            return
        for title, noun in (("Published", "publisher"), ("Subscribed", "subscriber")):
            print(_counted(title, noun, pairs, getattr(client.node, f"count_{noun}s")))


def _counted(title: str, noun: str, pairs: Names, count: Callable[[str], int]) -> str:
    text = f"{title} topics:\n"
    for name, types in pairs:
        if number := count(name):
            plural = "s" if number > 1 else ""
            text += f" * {name} [{', '.join(types)}] {number} {noun}{plural}\n"
    return text


def find(arguments: argparse.Namespace) -> None:
    """List the names of a type."""
    wanted = vars(arguments)[f"{arguments.command}_type"]
    with Client(arguments) as client:
        names = [name for name, types in _found(client, arguments) if wanted in types]
    print_names(names, vars(arguments)[f"count_{arguments.command}s"])


def type_(arguments: argparse.Namespace) -> int:
    """Print the types of a name; return 1 if nothing has it."""
    kind = arguments.command
    with Client(arguments) as client:
        name = absolute(vars(arguments)[f"{kind}_name"])
        types = client.find_types(name, names_of(kind), _hidden(arguments))
        print_names(types, count=False)
    return int(not types)


def _types(client: Client, arguments: argparse.Namespace, given: str, hidden: bool) -> Any:
    kind = arguments.command
    types = client.find_types(absolute(given), names_of(kind), hidden)
    if not types:
        raise Ros2Error(f"Unknown {kind} '{given}'")
    return types[0] if len(types) == 1 else types


def topic_info(arguments: argparse.Namespace) -> None:
    """Print a topic's type and its endpoints."""
    name, gap = absolute(arguments.topic_name), "\n" if arguments.verbose else ""
    with Client(arguments) as client:
        print(f"Type: {_types(client, arguments, arguments.topic_name, True)}", end=f"\n{gap}")
        node = client.node
        for title, count, endpoints in (
            ("Publisher", node.count_publishers, node.get_publishers_info_by_topic),
            ("Subscription", node.count_subscribers, node.get_subscriptions_info_by_topic),
        ):
            print(f"{title} count: {count(name)}", end=f"\n{gap}")
            for endpoint in endpoints(name) if arguments.verbose else ():
                print(endpoint, end="\n\n")


def service_info(arguments: argparse.Namespace) -> None:
    """Print a service's type and the numbers of its servers and clients."""
    name = absolute(arguments.service_name)
    with Client(arguments) as client:
        print(f"Type: {_types(client, arguments, arguments.service_name, _hidden(arguments))}")
        print(f"Clients count: {client.node.count_clients(name)}")
        print(f"Services count: {client.node.count_services(name)}")


def action_info(arguments: argparse.Namespace) -> None:
    """Print the nodes that serve an action and those that are its clients."""
    from rclpy import action

    name = full_name(arguments.action_name)
    with Client(arguments) as client:
        client.find_types(name, names_of("action"))
        ends = partial(_nodes_with, client, name)
        clients = ends(action.get_action_client_names_and_types_by_node)
        servers = ends(action.get_action_server_names_and_types_by_node)
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
