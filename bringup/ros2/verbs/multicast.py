"""`ros2 multicast send`, `receive`: whether datagrams get from one machine to another."""

from __future__ import annotations

import argparse
import socket

_GROUP, _PORT = "225.0.0.1", 49150  # ros2multicast's


def send(arguments: argparse.Namespace) -> None:
    """Send one datagram."""
    print("Sending one UDP multicast datagram...")
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as out:
        out.sendto(b"Hello World!", (_GROUP, _PORT))


def receive(arguments: argparse.Namespace) -> None:
    """Wait for one datagram and print it; Ctrl-C ends that."""
    print("Waiting for UDP multicast datagram...")
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as heard:
        heard.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        heard.bind((_GROUP, _PORT))  # no datagram but the group's
        group = socket.inet_aton(_GROUP) + bytes(4)  # on any interface
        heard.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, group)
        data, (host, port) = heard.recvfrom(4096)
    print(f"Received from {host}:{port}: '{data.decode('utf-8', 'replace')}'")
