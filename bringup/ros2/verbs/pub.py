"""`ros2 topic pub`."""

from __future__ import annotations

import argparse
import sys
import time

from bringup.ros2.client import Client
from bringup.ros2.errors import Ros2Error
from bringup.ros2.qos import from_options
from bringup.ros2.types import interface_class
from bringup.ros2.values import fill, parse


def values_of(text: str, stdin: bool) -> dict[str, object]:
    """Return what was typed as YAML, or stands on the standard input."""
    return parse(sys.stdin.read() if stdin else text)


def pub(arguments: argparse.Namespace) -> None:
    """Publish a message once, some times, or until interrupted.

    Raises:
        Ros2Error: The type or a field does not exist, or no subscription matches in time.
    """
    message_type = interface_class(arguments.message_type, "msg")
    message = message_type()
    stamps = fill(message, values_of(arguments.values, arguments.stdin))
    times = 1 if arguments.once else arguments.times
    with Client(arguments, arguments.node_name) as client:
        clock = client.node.get_clock()
        publisher = client.node.create_publisher(
            message_type, arguments.topic_name, from_options(arguments)
        )
        _wait_for_subscriptions(client, publisher, arguments, times)
        print("publisher: beginning loop")
        count, due = 0, time.monotonic()
        while times == 0 or count < times:
            client.spin(lambda: False, max(due - time.monotonic(), 0.0))
            due += 1.0 / arguments.rate
            count += 1
            now = clock.now().to_msg()
            for stamp in stamps:
                stamp(now)
            if arguments.print and count % arguments.print == 0:
                print(f"publishing #{count}: {message!r}\n")
            publisher.publish(message)
        client.spin(lambda: False, max(arguments.keep_alive, 0.0))


def _wait_for_subscriptions(
    client: Client, publisher: object, arguments: argparse.Namespace, times: int
) -> None:
    wanted = arguments.wait_matching_subscriptions
    wanted = (1 if times else 0) if wanted is None else wanted
    count = publisher.get_subscription_count  # type: ignore[attr-defined]
    limit = arguments.max_wait_time_secs
    end = None if limit is None else time.monotonic() + limit
    while count() < wanted:
        print(f"Waiting for at least {wanted} matching subscription(s)...")
        client.spin(lambda: count() >= wanted, 1.0)
        if count() < wanted and end is not None and time.monotonic() >= end:
            raise Ros2Error(
                "Timed out waiting for subscribers: "
                f"Expected {wanted} subscribers but only got {count()} subscribers"
            )
