"""The nodes that publish, listen and serve, as Foxglove's graph of topics shows them."""

from __future__ import annotations

import contextlib
from collections import defaultdict
from typing import Any

from rclpy.node import Node, NodeNameNonExistentError

from arjuna_core.ros.context import full_name
from bringup.viewing.foxglove.server import Client

_IDS = {
    "publishedTopics": "publisherIds",
    "subscribedTopics": "subscriberIds",
    "advertisedServices": "providerIds",
}


class ConnectionGraph:
    """Sends clients what has changed of the graph since they last heard of it."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self._known: dict[Client, dict[str, dict[str, list[str]]]] = {}

    def subscribe(self, client: Client, message: Any) -> None:
        """Send a client the graph and its changes from now on."""
        self._known[client] = {kind: {} for kind in _IDS}

    def forget(self, client: Client, message: Any = None) -> None:
        """Send a client nothing any more."""
        self._known.pop(client, None)

    def refresh(self) -> None:
        """Send what has changed."""
        now = self._look() if self._known else {}
        for client, before in self._known.items():
            self._known[client] = now
            changed = {
                kind: [
                    {"name": name, ids: nodes}
                    for name, nodes in now[kind].items()
                    if before[kind].get(name) != nodes
                ]
                for kind, ids in _IDS.items()
            }
            topics, services = (
                sorted(before[kind].keys() - now[kind].keys())
                for kind in ("publishedTopics", "advertisedServices")
            )
            update = {**changed, "removedTopics": topics, "removedServices": services}
            if any(update.values()):
                client.send_message("connectionGraphUpdate", **update)

    def _look(self) -> dict[str, dict[str, list[str]]]:
        node, services = self._node, defaultdict[str, list[str]](list)
        for name, space in sorted(set(node.get_node_names_and_namespaces())):
            with contextlib.suppress(NodeNameNonExistentError):  # it has just gone
                for service, _ in node.get_service_names_and_types_by_node(name, space):
                    services[service].append(full_name(name, space))
        topics = [topic for topic, _ in node.get_topic_names_and_types()]
        return {
            "publishedTopics": {t: _nodes(node.get_publishers_info_by_topic(t)) for t in topics},
            "subscribedTopics": {
                t: _nodes(node.get_subscriptions_info_by_topic(t)) for t in topics
            },
            "advertisedServices": dict(services),
        }


def _nodes(ends: Any) -> list[str]:
    return sorted({full_name(end.node_name, end.node_namespace) for end in ends})
