"""`ros2 topic pub`, `ros2 service call`, `ros2 action send_goal`."""

from __future__ import annotations

import argparse
import contextlib
import itertools
import math
import sys
import time
from collections.abc import Callable
from typing import Any

from action_msgs.msg import GoalStatus
from rclpy.action import ActionClient
from rclpy.duration import Duration

from bringup.ros2.client import Client, full_name
from bringup.ros2.errors import Ros2Error
from bringup.ros2.qos import from_options
from bringup.ros2.types import interface_class
from bringup.ros2.values import fill, parse, to_yaml

_QUIET = 0.6
"""How long no further subscription is met until all are [s]; ros2cli looks each 0.1 s."""
_MEETING = Duration(seconds=1.0)
"""How long a subscription that is met is waited for until it has the last message."""


def _values(arguments: argparse.Namespace) -> Any:
    """Return what was typed as YAML, or stands on the standard input."""
    return parse(sys.stdin.read() if arguments.stdin else arguments.values)


def pub(arguments: argparse.Namespace) -> None:
    """Publish a message once, some times, or until interrupted."""
    message_type = interface_class(arguments.message_type, "msg")
    message = message_type()
    values = _values(arguments)
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
            client.pause(max(due - time.monotonic(), 0.0))
            due += 1.0 / arguments.rate
            count += 1
            now = clock.now().to_msg()
            for stamp in stamps:
                stamp(now)
            if arguments.print and count % arguments.print == 0:
                print(f"publishing #{count}: {message!r}\n")
            publisher.publish(message)
        # Who has not met this publisher yet, though it is met, gets the message when it has.
        publisher.wait_for_all_acked(_MEETING)
        client.pause(max(arguments.keep_alive, 0.0))


def _wait_for_subscriptions(
    client: Client, publisher: object, arguments: argparse.Namespace, times: int
) -> None:
    wanted = arguments.wait_matching_subscriptions
    wanted = (1 if times else 0) if wanted is None else wanted
    count = publisher.get_subscription_count  # type: ignore[attr-defined]
    limit, period = arguments.max_wait_time_secs, 0.1
    for tick in itertools.count():
        if count() >= wanted:
            if wanted:
                _meet_others(client, count)
            return
        if tick % 10 == 0:
            print(f"Waiting for at least {wanted} matching subscription(s)...")
        if limit is not None and tick * period >= limit:
            raise Ros2Error(
                "Timed out waiting for subscribers: "
                f"Expected {wanted} subscribers but only got {count()} subscribers"
            )
        client.run_until(lambda: count() >= wanted, period, required=False)


def _meet_others(client: Client, count: Callable[[], int]) -> None:
    """Wait until no further subscription is met: a topic may have several, as /goal_pose has."""
    known = count()
    if client.run_until(lambda: count() > known, _QUIET, required=False):
        _meet_others(client, count)


def call(arguments: argparse.Namespace) -> None:
    """Call a service once, or at a rate until interrupted."""
    if arguments.rate is not None and not arguments.rate > 0.0:
        raise Ros2Error("rate must be greater than zero")
    service_type = interface_class(arguments.service_type, "srv")
    request = service_type.Request()
    fill(request, _values(arguments))
    with Client(arguments) as client:
        service = client.node.create_client(service_type, arguments.service_name)
        if not client.run_until(service.service_is_ready, 0.1, required=False):
            print("waiting for service to become available...")
            client.run_until(service.service_is_ready)
        while True:
            print(f"requester: making request: {request!r}\n")
            sent = time.monotonic()
            response = client.result(service.call_async(request))
            print(f"response:\n{response!r}\n")
            if arguments.rate is None:
                return
            client.pause(max(sent + 1.0 / arguments.rate - time.monotonic(), 0.0))


_WRONG = "Failed to populate message fields: {!r}"


def send_goal(arguments: argparse.Namespace) -> None:
    """Send a goal and print how it ends; an interrupt cancels it."""
    action_type = interface_class(arguments.action_type, "action")
    goal = action_type.Goal()
    stamps = fill(goal, parse(sys.stdin.read() if arguments.stdin else arguments.goal), _WRONG)
    with Client(arguments) as client, contextlib.ExitStack() as stack:
        action = ActionClient(client.node, action_type, full_name(arguments.action_name))
        stack.callback(action.destroy)
        print("Waiting for an action server to become available...")
        client.run_until(action.server_is_ready)
        for stamp in stamps:
            stamp(client.node.get_clock().now().to_msg())
        print(f"Sending goal:\n     {to_yaml(goal)}")
        feedback = _Feedback()
        taken = feedback.take if arguments.feedback else None
        handle = client.send_goal(action, goal, taken, math.inf)
        if not handle.accepted:
            print("Goal was rejected.")
            return
        print(f"Goal accepted with ID: {bytes(handle.goal_id.uuid).hex()}\n")
        feedback.start()
        try:
            outcome = client.result(handle.get_result_async())
        except KeyboardInterrupt:
            _cancel(client, handle)
            raise
        print(f"Result:\n    {to_yaml(outcome.result)}")
        print(f"Goal finished with status: {status_name(outcome.status)}")


class _Feedback:
    """Prints feedback; what comes before the goal is said to be accepted waits until then."""

    def __init__(self) -> None:
        self._waiting: list[Any] | None = []

    def take(self, message: Any) -> None:
        """Print a feedback message, or keep it."""
        if self._waiting is not None:
            self._waiting.append(message)
            return
        print(f"Feedback:\n    {to_yaml(message.feedback)}")

    def start(self) -> None:
        """Print what was kept, and from now on what comes."""
        waiting, self._waiting = self._waiting or [], None
        for message in waiting:
            self.take(message)


def _cancel(client: Client, handle: Any) -> None:
    print("Canceling goal...")
    answer = client.cancel(handle)
    if not answer.goals_canceling:
        raise Ros2Error("Failed to cancel goal")
    print("Goal canceled.")


def status_name(status: int) -> str:
    """Return the word for a goal's status."""
    names = ("UNKNOWN", "ACCEPTED", "EXECUTING", "CANCELING", "SUCCEEDED", "CANCELED", "ABORTED")
    return next(
        (name for name in names if getattr(GoalStatus, f"STATUS_{name}") == status), names[0]
    )
