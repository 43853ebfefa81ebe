"""Participants counted by their ports."""

from __future__ import annotations

import socket

import pytest

from bringup.ros2.participants import count, on_this_machine

HEAD = "  sl  local_address rem_address   st tx_queue rx_queue\n"


def table(*ports: int) -> str:
    rows = [f"  {i}: 00000000:{port:04X} 00000000:0000 07" for i, port in enumerate(ports)]
    return HEAD + "\n".join(rows)


@pytest.mark.parametrize(
    ("ports", "expected"),
    [
        ((), 0),
        ((7410,), 1),
        ((7410, 7412, 7414), 3),
        ((7410, 7410), 1),  # on two addresses
        ((7400, 7401, 7411, 7413), 0),  # multicast, and data of users
        ((7660, 53), 0),  # of the next domain, and no DDS at all
    ],
)
def test_only_discovery_ports_of_the_domain_count(ports: tuple[int, ...], expected: int) -> None:
    assert count(0, table(*ports)) == expected


def test_domains_lie_250_ports_apart() -> None:
    assert count(46, table(7400 + 250 * 46 + 10)) == 1


def test_a_bound_port_is_seen() -> None:
    domain = 211  # above what ROS uses on Linux
    before = on_this_machine(domain)
    if before is None:
        pytest.skip("no /proc/net/udp here")
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as bound:
        bound.bind(("127.0.0.1", 7400 + 250 * domain + 10))
        assert on_this_machine(domain) == before + 1
