"""`ros2 topic hz`, `bw`, `delay`."""

from __future__ import annotations

import argparse
import time
from collections import deque
from typing import Any

import numpy as np
from rclpy.qos import qos_profile_sensor_data

from bringup.ros2.client import Client, full_name
from bringup.ros2.errors import Ros2Error
from bringup.ros2.statistics import Intervals, bandwidth_text, spread_text
from bringup.ros2.verbs.echo import condition, topic_class


def hz(arguments: argparse.Namespace) -> None:
    """Print the rate at which messages come, until interrupted."""
    wanted = condition(arguments.filter)
    intervals = Intervals(arguments.window)
    new: list[float] = []
    with Client(arguments) as client:
        clock = client.node.get_clock()

        def receive(message: Any) -> None:
            now = time.time() if arguments.wall_time else clock.now().nanoseconds / 1e9
            if now > 0.0 and wanted(message):
                intervals.add(now)
                new.append(now)

        _subscribe(client, arguments, receive, raw=arguments.filter is None)
        while True:
            client.pause(1.0)
            if intervals.values and new:
                print(intervals.text())
            new.clear()


def bw(arguments: argparse.Namespace) -> None:
    """Print how many bytes a second come, until interrupted."""
    sizes: deque[int] = deque(maxlen=arguments.window)
    times: deque[float] = deque(maxlen=arguments.window)

    def receive(data: bytes) -> None:
        sizes.append(len(data))
        times.append(time.monotonic())

    with Client(arguments) as client:
        _subscribe(client, arguments, receive, raw=True)
        print(f"Subscribed to [{arguments.topic_name}]")
        while True:
            client.pause(1.0)
            if len(sizes) > 1:
                print(bandwidth_text(sizes, time.monotonic() - times[0]))


def delay(arguments: argparse.Namespace) -> None:
    """Print how old messages are when they come, until interrupted."""
    delays: deque[float] = deque(maxlen=arguments.window)
    new: list[float] = []
    with Client(arguments) as client:
        clock = client.node.get_clock()

        def receive(message: Any) -> None:
            stamp = message.header.stamp
            age = (clock.now().nanoseconds - stamp.sec * 1_000_000_000 - stamp.nanosec) / 1e9
            delays.append(age)
            new.append(age)

        message_type = _subscribe(client, arguments, receive, raw=False)
        if "header" not in message_type.get_fields_and_field_types():
            raise Ros2Error("msg does not have header")
        while True:
            client.pause(1.0)
            if new:
                print(f"average delay: {np.mean(delays):.3f}\n{spread_text(delays)}")
            elif delays:
                print("no new messages")
            new.clear()


def _subscribe(client: Client, arguments: argparse.Namespace, receive: Any, raw: bool) -> Any:
    topic = full_name(arguments.topic_name)
    if not client.discover(lambda: client.node.count_publishers(topic) > 0):
        print(f"WARNING: topic [{arguments.topic_name}] does not appear to be published yet")
        client.run_until(lambda: client.node.count_publishers(topic) > 0)
    client.discover()
    message_type = topic_class(client, arguments.topic_name)
    client.node.create_subscription(message_type, topic, receive, qos_profile_sensor_data, raw=raw)
    return message_type
