"""The time that a graph must stand still, by what is seen to lack in it."""

from __future__ import annotations

import socket
from types import SimpleNamespace
from typing import Any

import pytest

from bringup.ros2 import discovery
from bringup.ros2.discovery import (
    SILENT,
    STABLE,
    WHOLE,
    Graph,
    count_participants,
    participants,
    time_to_settle,
)

pytestmark = pytest.mark.ros
ME, OTHER, THIRD = bytes([1]) * 12, bytes([2]) * 12, bytes([3]) * 12
SERVICE = [("rq/add/getRequest", ["..."]), ("rr/add/getReply", ["..."])]
NODES = [("me", "/"), ("one", "/"), ("two", "/")]


class Seen:
    """A node that knows some participants; `named` are those whose nodes it knows."""

    context = SimpleNamespace(get_domain_id=lambda: 5)

    def __init__(self, participants: list[bytes], named: dict[bytes, str]) -> None:
        self._ends = {
            "ros_discovery_info": [(guid, "_NODE_NAME_UNKNOWN_") for guid in participants],
            "rt/rosout": list(named.items()),
        }

    def get_name(self) -> str:
        return "me"

    def get_publishers_info_by_topic(self, topic: str, no_mangle: bool) -> list[Any]:
        return [
            SimpleNamespace(endpoint_gid=[*guid, 0, 0, 0, 1], node_name=name)
            for guid, name in self._ends[topic]
        ]


@pytest.fixture(autouse=True)
def three_participants(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    monkeypatch.setattr(discovery, "participants", lambda domain: 3)


ALL = [ME, OTHER, THIRD]
NAMED = {ME: "me", OTHER: "one", THIRD: "two"}


@pytest.mark.parametrize(
    ("seen", "nodes", "topics", "expected"),
    [
        (Seen(ALL, NAMED), NODES, SERVICE, WHOLE),
        (Seen(ALL[:2], NAMED), NODES, SERVICE, SILENT),  # a port that nobody answers for
        (Seen(ALL, NAMED), NODES[:2], SERVICE, SILENT),
        (Seen(ALL, {ME: "me", OTHER: "one"}), NODES, SERVICE, STABLE),  # no end of the third's
        (Seen(ALL, {**NAMED, THIRD: "_NODE_NAME_UNKNOWN_"}), NODES, SERVICE, SILENT),
        (Seen(ALL, NAMED), NODES, SERVICE[:1], STABLE),
        (Seen(ALL, NAMED), NODES, SERVICE[1:], STABLE),
    ],
)
def test_what_lacks_is_waited_for(
    seen: Seen, nodes: list[tuple[str, str]], topics: list[tuple[str, list[str]]], expected: float
) -> None:
    assert time_to_settle(seen, Graph(nodes, topics)) == expected


@pytest.mark.parametrize(("nodes", "expected"), [(NODES[:1], SILENT), (NODES, STABLE)])
def test_on_a_network_nobody_is_counted(
    nodes: list[tuple[str, str]], expected: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET")
    assert time_to_settle(Seen(ALL, NAMED), Graph(nodes, SERVICE)) == expected


HEAD = "  sl  local_address rem_address   st tx_queue rx_queue\n"


def table(*ports: int) -> str:
    rows = [f"  {i}: 00000000:{port:04X} 00000000:0000 07" for i, port in enumerate(ports)]
    return HEAD + "\n".join(rows)


@pytest.mark.parametrize(
    ("domain", "ports", "expected"),
    [
        (0, (), 0),
        (0, (7410,), 1),
        (0, (7410, 7412, 7414), 3),
        (0, (7410, 7410), 1),  # on two addresses
        (0, (7400, 7401, 7411, 7413), 0),  # multicast, and data of users
        (0, (7660, 53), 0),  # of the next domain, and no DDS at all
        (46, (7400 + 250 * 46 + 10,), 1),
    ],
)
def test_only_discovery_ports_of_the_domain_count(
    domain: int, ports: tuple[int, ...], expected: int
) -> None:
    assert count_participants(domain, table(*ports)) == expected


def test_a_bound_port_is_seen() -> None:
    domain = 211  # above what ROS uses on Linux
    before = participants(domain)
    if before is None:
        pytest.skip("no /proc/net/udp here")
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as bound:
        bound.bind(("127.0.0.1", 7400 + 250 * domain + 10))
        assert participants(domain) == before + 1
