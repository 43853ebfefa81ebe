"""`ros2 topic list`, `info`, `type`, `find`."""

from __future__ import annotations

import argparse
from collections.abc import Sequence

from bringup.ros2.client import Client, absolute, print_names_and_types, visible_types
from bringup.ros2.errors import Ros2Error


def list_topics(arguments: argparse.Namespace) -> int:
    """List the topics."""
    with Client(arguments) as client:
        client.discover()
        pairs = visible_types(
            client.node.get_topic_names_and_types(), arguments.include_hidden_topics
        )
        if arguments.count_topics:
            print(len(pairs))
        elif arguments.verbose and pairs:
            count = client.node.count_publishers
            print(_counted("Published", "publisher", pairs, [count(name) for name, _ in pairs]))
            count = client.node.count_subscribers
            print(_counted("Subscribed", "subscriber", pairs, [count(name) for name, _ in pairs]))
        else:
            print_names_and_types(pairs, arguments.show_types)
    return 0


def _counted(
    title: str, noun: str, pairs: Sequence[tuple[str, Sequence[str]]], counts: list[int]
) -> str:
    text = f"{title} topics:\n"
    for (name, types), count in zip(pairs, counts, strict=True):
        if count:
            text += f" * {name} [{', '.join(types)}] {count} {noun}{'s' if count > 1 else ''}\n"
    return text


def find(arguments: argparse.Namespace) -> int:
    """List the topics of a type."""
    with Client(arguments) as client:
        client.discover()
        pairs = visible_types(
            client.node.get_topic_names_and_types(), arguments.include_hidden_topics
        )
    names = [name for name, types in pairs if arguments.topic_type in types]
    print(len(names) if arguments.count_topics else "\n".join(names), end="\n" if names else "")
    return 0


def type_of(arguments: argparse.Namespace) -> int:
    """Print a topic's types; 1 if there is no such topic."""
    name = absolute(arguments.topic_name)
    with Client(arguments) as client:
        if not client.discover(lambda: bool(types_of(client, name))):
            return 1
        print("\n".join(types_of(client, name)))
    return 0


def types_of(client: Client, topic: str) -> Sequence[str]:
    """Return the types of a topic, none if nobody has it."""
    types: Sequence[str] = dict(client.node.get_topic_names_and_types()).get(topic, [])
    return types


def info(arguments: argparse.Namespace) -> int:
    """Print a topic's type and its endpoints.

    Raises:
        Ros2Error: There is no such topic.
    """
    name = absolute(arguments.topic_name)
    with Client(arguments) as client:
        client.discover(lambda: bool(types_of(client, name)))
        client.discover()  # the rest of its endpoints
        types = types_of(client, name)
        if not types:
            raise Ros2Error(f"Unknown topic '{arguments.topic_name}'")
        gap = "\n" if arguments.verbose else ""
        print(f"Type: {types[0] if len(types) == 1 else types}", end=f"\n{gap}")
        node = client.node
        print(f"Publisher count: {node.count_publishers(name)}", end=f"\n{gap}")
        if arguments.verbose:
            for endpoint in node.get_publishers_info_by_topic(name):
                print(endpoint, end="\n\n")
        print(f"Subscription count: {node.count_subscribers(name)}", end=f"\n{gap}")
        if arguments.verbose:
            for endpoint in node.get_subscriptions_info_by_topic(name):
                print(endpoint, end="\n\n")
    return 0
