"""The time until a node knows the whole graph, which DDS sends in parts, over a second."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

from bringup.client.session import POLL, Session

WHOLE = 0.15  # a graph in which nothing is seen to lack must stand still for so long [s]
STABLE = 0.6  # one of which that cannot be told
SILENT = 6.5  # one some of whose participants were not heard of: two announcements of 3 s each
# DDSI-RTPS 2.5, section 9.6.2: port = 7400 + 250 domain + 10 + 2 participant (discovery, unicast)
_BASE, _DOMAIN_GAIN, _OFFSET, _PARTICIPANT_GAIN = 7400, 250, 10, 2
_TABLE = Path("/proc/net/udp")
_UNNAMED = "_NODE_NAME_UNKNOWN_"
_REQUEST, _REPLY = ("rq/", "Request"), ("rr/", "Reply")


class Graph(NamedTuple):
    """The graph of a node at one time: nodes (name, namespace), DDS topics (name, types)."""

    nodes: list[tuple[str, str]]
    topics: list[tuple[str, list[str]]]


def discover(
    session: Session,
    found: Callable[[], bool] | None = None,
    duration: float | None = None,
    missing: float = 1.0,
    limit: float = 8.0,
) -> bool:
    """Wait until the graph is known, or until something is found in it.

    Args:
        found: Looks for what is asked for; it ends the wait early.
        duration: How long to wait, whatever is known [s]; None for as long as it takes.
        missing: How long a graph must stand still before something counts as not there [s].
        limit: How long a graph that continues to change is watched [s].

    Returns:
        Whether it was found; False if nothing was looked for.
    """
    start = changed = session.now
    seen: Graph | None = None
    polls = 0  # a machine so busy that few fit into the time needs longer
    while found is None or not found():
        now, graph = session.now, look(session.client)
        polls += 1
        if graph != seen:
            seen, changed, polls = graph, now, 0
        quiet = max(time_to_settle(session.client, graph), 0.0 if found is None else missing)
        settled = now > changed + quiet and polls > 0.8 * quiet / POLL
        if now > start + (limit if duration is None else float(duration)) or (
            settled and duration is None
        ):
            return False
        session.spin_once()
    return True


def look(node: Any) -> Graph:
    """Return the graph that a node sees; services are topics of it."""
    return Graph(
        node.get_node_names_and_namespaces(), node.get_topic_names_and_types(no_demangle=True)
    )


def time_to_settle(node: Any, graph: Graph) -> float:
    """Return how long a graph must stand still until it is taken as known [s]."""
    expected = _expected(node)
    if expected is None:  # on a network nobody knows how many there are
        return STABLE if any(name != node.get_name() for name, _ in graph.nodes) else SILENT
    participants = _participants(node, "ros_discovery_info")
    # a participant is seen before it has told its nodes, and has one at least
    if min(len(participants), len(graph.nodes)) < expected:
        return SILENT
    named = _participants(node, "rt/rosout")
    if _UNNAMED in named.values():  # its topics were told, and its nodes will be
        return SILENT
    named_all = set(participants) <= set(named)
    return WHOLE if named_all and not _halves(graph) else STABLE


def any_dead(node: Any) -> bool:
    """Return whether a participant that a node knows may have died: it holds no port here."""
    expected = _expected(node)
    return expected is None or len(_participants(node, "ros_discovery_info")) > expected


def _expected(node: Any) -> int | None:
    """Return how many participants there are, None where that cannot be counted."""
    if os.environ.get("ROS_AUTOMATIC_DISCOVERY_RANGE") != "LOCALHOST":
        return None
    return participants(node.context.get_domain_id())


def _participants(node: Any, topic: str) -> dict[bytes, str]:
    """Return who publishes a topic: a node's name of each participant, unnamed if one is."""
    found: dict[bytes, str] = {}
    for end in node.get_publishers_info_by_topic(topic, no_mangle=True):
        guid = bytes(end.endpoint_gid[:12])  # DDSI-RTPS 2.5, section 9.3.1: the participant's part
        found[guid] = end.node_name if found.get(guid) != _UNNAMED else _UNNAMED
    return found


def _halves(graph: Graph) -> set[str]:
    """Return the services of which requests are known and replies are not, or the reverse."""
    names = [name for name, _ in graph.topics]
    requests, replies = (
        {n.removeprefix(start).removesuffix(end) for n in names if n.startswith(start)}
        for start, end in (_REQUEST, _REPLY)
    )
    return requests ^ replies


def participants(domain: int) -> int | None:
    """Return the number of participants of a domain, this process's too; None if unknown."""
    if not _TABLE.is_file():
        return None
    return count_participants(domain, _TABLE.read_text(encoding="ascii"))


def count_participants(domain: int, table: str) -> int:
    """Return the number of participants with ports in a table of sockets, as /proc/net/udp's."""
    first = _BASE + _DOMAIN_GAIN * domain + _OFFSET
    end = first + _DOMAIN_GAIN - _OFFSET  # there the next domain's ports begin
    expected = range(first, end, _PARTICIPANT_GAIN)
    addresses = (line.split()[1] for line in table.splitlines()[1:])
    return len({int(address.split(":")[1], 16) for address in addresses} & set(expected))
