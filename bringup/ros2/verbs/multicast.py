"""`ros2 multicast send`, `receive`, `ros2 doctor hello`: whether machines hear one another."""

from __future__ import annotations

import argparse
import contextlib
import os
import socket
import sys
import time
from collections import Counter
from typing import Any

from std_msgs.msg import String

from bringup.parameters.options import positive
from bringup.ros2.client import Client

_GROUP, _PORT = "225.0.0.1", 49150  # ros2multicast's, and ros2doctor's
_RANGE = "ROS_AUTOMATIC_DISCOVERY_RANGE"


def send(arguments: argparse.Namespace) -> None:
    """Send one datagram."""
    print("Sending one UDP multicast datagram...")
    _send("Hello World!", None)


def _send(text: str, ttl: int | None) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as out:
        if ttl is not None:
            out.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, ttl)
        out.sendto(text.encode(), (_GROUP, _PORT))


def receive(arguments: argparse.Namespace) -> None:
    """Wait for one datagram and print it; Ctrl-C ends that."""
    print("Waiting for UDP multicast datagram...")
    with _heard() as heard:
        data, (host, port) = heard.recvfrom(4096)
    print(f"Received from {host}:{port}: '{data.decode('utf-8', 'replace')}'")


def _heard() -> socket.socket:
    """Return a socket that gets the group's datagrams, and no others."""
    heard = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    heard.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    heard.bind((_GROUP, _PORT))
    group = socket.inet_aton(_GROUP) + bytes(4)  # on any interface
    heard.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, group)
    return heard


def hello(words: list[str]) -> None:
    """Greet other machines by a topic and by multicast, and say who greets, until Ctrl-C."""
    given = _of_hello(words)
    own, messages, datagrams = socket.gethostname(), Counter[str](), Counter[str]()
    text = f"hello, it's me {own}"

    def note(greeting: str, heard: Counter[str]) -> None:
        host = greeting.split()[-1] if greeting.strip() else own
        heard.update([host] if host != own else [])

    if os.environ.get(_RANGE) == "LOCALHOST":
        sys.stderr.write(f"topics of this machine alone are seen; {_RANGE}=SUBNET: of others too\n")
    end = contextlib.suppress(KeyboardInterrupt)
    with end, Client(name=f"hello_{os.getpid()}") as client, _heard() as heard:
        heard.setblocking(False)
        publisher = client.node.create_publisher(String, given.topic, 10)
        taken = lambda message: note(message.data, messages)  # noqa: E731
        client.node.create_subscription(String, given.topic, taken, 10)
        while True:
            sent, ends = 0, time.monotonic() + given.print_period
            while time.monotonic() < ends:
                publisher.publish(String(data=text))
                _send(text, given.ttl)
                sent += 1
                client.pause(given.emit_period)
                with contextlib.suppress(BlockingIOError):
                    while True:
                        note(heard.recv(4096).decode("utf-8", "replace"), datagrams)
            _print_summary(given, sent, messages, datagrams)
            messages.clear()
            datagrams.clear()


def _of_hello(words: list[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser("ros2 doctor hello", description=hello.__doc__)
    parser.add_argument("--topic", nargs="?", default="/canyouhearme", help="(/canyouhearme)")
    for name, usual, of in (("emit", 0.1, "two greetings"), ("print", 1.0, "two summaries")):
        text = f"seconds between {of} ({usual:g})"
        parser.add_argument(
            f"--{name}-period", metavar="N", type=positive, default=usual, help=text
        )
    parser.add_argument("--ttl", type=int, choices=range(1, 256), metavar="N", help="of datagrams")
    return parser.parse_args(words)


def _print_summary(given: Any, sent: int, messages: Counter[str], datagrams: Counter[str]) -> None:
    """Print ros2doctor's table."""
    print(f"MULTIMACHINE COMMUNICATION SUMMARY\nTopic: {given.topic}, Published Msg Count: {sent}")
    for title, heard in (("Subscribed from:", messages), ("Received from:", datagrams)):
        if heard is datagrams:
            print(f"Multicast Group/Port: {_GROUP}/{_PORT}, Sent Msg Count: {sent}")
        print(title)
        rows = [("Hostname", f"Msg Count /{given.print_period}s"), *heard.items()]
        print("\n".join(f"{'':<15} {host:<20} {count:<10}" for host, count in rows))
    print("-" * 60)
