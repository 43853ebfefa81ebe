"""The nodes of the graph, and what each of them offers and uses."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, NamedTuple

from bringup.ros2.client import absolute


class NodeName(NamedTuple):
    """A node's name, its namespace, and both."""

    name: str
    namespace: str
    full_name: str


class TopicInfo(NamedTuple):
    """A name of the graph and its types."""

    name: str
    types: Sequence[str]


def get_absolute_node_name(node_name: str) -> str | None:
    """Return a name with its leading slash, None for an empty one."""
    return absolute(node_name) if node_name else None


def parse_node_name(node_name: str) -> NodeName:
    full = absolute(node_name)
    namespace, _, name = full.rpartition("/")
    return NodeName(name, namespace or "/", full)


def has_duplicates(values: Sequence[Any]) -> bool:
    return len(set(values)) < len(values)


def get_node_names(*, node: Any, include_hidden_nodes: bool = False) -> list[NodeName]:
    pairs = node.get_node_names_and_namespaces()
    names = [parse_node_name(f"{space.rstrip('/')}/{name}") for name, space in pairs]
    return [each for each in names if include_hidden_nodes or not each.name.startswith("_")]


def _info(
    kind: str, *, node: Any, remote_node_name: str, include_hidden: bool = False
) -> list[TopicInfo]:
    remote = parse_node_name(remote_node_name)
    pairs = _ask(node, kind)(remote.name, remote.namespace)
    shown = (pair for pair in pairs if include_hidden or "/_" not in pair[0])
    return [TopicInfo(*pair) for pair in shown]


def _ask(node: Any, kind: str) -> Callable[[str, str], Any]:
    if not kind.startswith("action_"):
        ask: Callable[[str, str], Any] = getattr(node, f"get_{kind}_names_and_types_by_node")
        return ask
    import rclpy.action

    of_actions = getattr(rclpy.action, f"get_{kind}_names_and_types_by_node")
    return partial(of_actions, getattr(node, "node", node))


get_publisher_info = partial(_info, "publisher")
"""Return the topics that a node publishes."""
get_subscriber_info = partial(_info, "subscriber")
"""Return the topics that a node listens to."""
get_service_server_info = partial(_info, "service")
"""Return the services that a node offers."""
get_service_client_info = partial(_info, "client")
"""Return the services that a node calls."""
get_action_server_info = partial(_info, "action_server")
"""Return the actions that a node offers."""
get_action_client_info = partial(_info, "action_client")
"""Return the actions that a node asks for."""
