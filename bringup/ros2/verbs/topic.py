"""`ros2 topic list`, `info`, `type`, `find`."""

from __future__ import annotations

import argparse
from operator import methodcaller

from bringup.ros2.client import (
    Client,
    Names,
    absolute,
    print_names,
    print_types,
    visible_types,
    with_types,
)
from bringup.ros2.errors import Ros2Error

topics = methodcaller("get_topic_names_and_types")
"""Return the topics that a node sees."""


def list_topics(arguments: argparse.Namespace) -> None:
    """List the topics."""
    with Client(arguments) as client:
        client.discover()
        pairs = visible_types(topics(client.node), arguments.include_hidden_topics)
        if arguments.verbose and pairs and not arguments.count_topics:
            count = client.node.count_publishers
            print(_counted("Published", "publisher", pairs, [count(name) for name, _ in pairs]))
            count = client.node.count_subscribers
            print(_counted("Subscribed", "subscriber", pairs, [count(name) for name, _ in pairs]))
        else:
            print_names(with_types(pairs, arguments.show_types), arguments.count_topics)


def _counted(title: str, noun: str, pairs: Names, counts: list[int]) -> str:
    text = f"{title} topics:\n"
    for (name, types), count in zip(pairs, counts, strict=True):
        if count:
            text += f" * {name} [{', '.join(types)}] {count} {noun}{'s' if count > 1 else ''}\n"
    return text


def find(arguments: argparse.Namespace) -> None:
    """List the topics of a type."""
    with Client(arguments) as client:
        client.discover()
        pairs = visible_types(topics(client.node), arguments.include_hidden_topics)
    names = [name for name, types in pairs if arguments.topic_type in types]
    print_names(names, arguments.count_topics)


def type_of(arguments: argparse.Namespace) -> int:
    """Print a topic's types; 1 if there is no such topic."""
    hidden = arguments.include_hidden_topics
    return print_types(arguments, arguments.topic_name, topics, hidden)


def info(arguments: argparse.Namespace) -> None:
    """Print a topic's type and its endpoints.

    Raises:
        Ros2Error: There is no such topic.
    """
    name = absolute(arguments.topic_name)
    with Client(arguments) as client:
        types = client.find_types(name, topics)
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
