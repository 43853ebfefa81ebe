"""`ros2 action send_goal`."""

from __future__ import annotations

import argparse
import contextlib
import math
from typing import Any

from action_msgs.msg import GoalStatus
from rclpy.action import ActionClient

from bringup.ros2.client import Client, full_name
from bringup.ros2.errors import Ros2Error
from bringup.ros2.types import interface_class
from bringup.ros2.values import fill, to_yaml
from bringup.ros2.verbs.send import values_of

_WRONG = "Failed to populate message fields: {!r}"


def send_goal(arguments: argparse.Namespace) -> None:
    """Send a goal and print how it ends; an interrupt cancels it."""
    action_type = interface_class(arguments.action_type, "action")
    goal = action_type.Goal()
    stamps = fill(goal, values_of(arguments.goal, arguments.stdin), _WRONG)
    with Client(arguments) as client, contextlib.ExitStack() as stack:
        action = ActionClient(client.node, action_type, full_name(arguments.action_name))
        stack.callback(action.destroy)
        print("Waiting for an action server to become available...")
        client.spin(action.server_is_ready)
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
