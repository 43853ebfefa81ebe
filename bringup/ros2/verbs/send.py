"""`ros2 topic pub`, `ros2 service call`."""

from __future__ import annotations

import argparse
import itertools
import sys
import time
from typing import Any

from bringup.ros2.client import Client
from bringup.ros2.errors import Ros2Error
from bringup.ros2.qos import from_options
from bringup.ros2.types import interface_class
from bringup.ros2.values import fill, parse


def values_of(text: str, stdin: bool) -> Any:
    """Return what was typed as YAML, or stands on the standard input."""
    return parse(sys.stdin.read() if stdin else text)


def pub(arguments: argparse.Namespace) -> None:
    """Publish a message once, some times, or until interrupted."""
    message_type = interface_class(arguments.message_type, "msg")
    message = message_type()
    values = values_of(arguments.values, arguments.stdin)
    if not isinstance(values, dict):
        raise Ros2Error("The passed value needs to be a dictionary in YAML format")
    stamps = fill(message, values)
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
    limit, period = arguments.max_wait_time_secs, 0.1
    for tick in itertools.count():
        if count() >= wanted:
            return
        if tick % 10 == 0:
            print(f"Waiting for at least {wanted} matching subscription(s)...")
        if limit is not None and tick * period >= limit:
            raise Ros2Error(
                "Timed out waiting for subscribers: "
                f"Expected {wanted} subscribers but only got {count()} subscribers"
            )
        client.spin(lambda: count() >= wanted, period)


def call(arguments: argparse.Namespace) -> None:
    """Call a service once, or at a rate until interrupted."""
    if arguments.rate is not None and not arguments.rate > 0.0:
        raise Ros2Error("rate must be greater than zero")
    service_type = interface_class(arguments.service_type, "srv")
    request = service_type.Request()
    fill(request, values_of(arguments.values, arguments.stdin))
    with Client(arguments) as client:
        service = client.node.create_client(service_type, arguments.service_name)
        if not client.spin(service.service_is_ready, 0.1):
            print("waiting for service to become available...")
            client.spin(service.service_is_ready)
        while True:
            print(f"requester: making request: {request!r}\n")
            sent = time.monotonic()
            response = client.result(service.call_async(request))
            print(f"response:\n{response!r}\n")
            if arguments.rate is None:
                return
            client.spin(lambda: False, max(sent + 1.0 / arguments.rate - time.monotonic(), 0.0))
