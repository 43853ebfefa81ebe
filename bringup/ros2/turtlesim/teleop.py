"""`ros2 run turtlesim turtle_teleop_key`: a turtle is moved by the arrow keys."""

from __future__ import annotations

import math
from typing import Any

from geometry_msgs.msg import Twist
from rclpy.action import ActionClient
from turtlesim.action import RotateAbsolute

from bringup.client.keys import QUIT
from bringup.client.session import ClientError
from bringup.ros2.client import Client
from bringup.terminal import DOWN, LEFT, RIGHT, UP, Keys, show

_PAGE = """Reading from keyboard
---------------------------
Use arrow keys to move the turtle.
Use g|b|v|c|d|e|r|t keys to rotate to absolute orientations. 'f' to cancel a rotation.
'q' to quit."""
_ARROWS = {UP: (1.0, 0.0), DOWN: (-1.0, 0.0), LEFT: (0.0, 1.0), RIGHT: (0.0, -1.0)}
"""Ahead and turning to the left, in shares of the scales."""
_HEADINGS = {
    key: eighth * math.pi / 4.0
    for key, eighth in zip("gtredcvb", (0, 1, 2, 3, 4, -3, -2, -1), strict=True)
}  # as they lie around f on a keyboard


class _Teleop:
    """Commands by keys."""

    def __init__(self, client: Client) -> None:
        self._node = node = client.node
        for name in ("scale_linear", "scale_angular"):
            node.declare_parameter(name, 2.0)
        self._commands = node.create_publisher(Twist, "turtle1/cmd_vel", 1)
        self._turns = ActionClient(node, RotateAbsolute, "turtle1/rotate_absolute")
        self._goal: Any = None

    def press(self, key: str) -> None:
        """Do what a key stands for; others do nothing."""
        if key in _ARROWS:
            linear, angular = (
                share * self._node.get_parameter(name).value
                for share, name in zip(_ARROWS[key], ("scale_linear", "scale_angular"), strict=True)
            )
            twist = Twist()
            twist.linear.x, twist.angular.z = linear, angular
            self._commands.publish(twist)
        elif key in _HEADINGS:
            goal = RotateAbsolute.Goal(theta=_HEADINGS[key])
            self._turns.send_goal_async(goal).add_done_callback(self._accepted)
        elif key == "f" and self._goal is not None:
            self._goal.cancel_goal_async()

    def _accepted(self, answer: Any) -> None:
        self._goal = answer.result() if answer.result().accepted else None


def main(words: list[str]) -> None:
    """Move a turtle until `q`.

    Raises:
        ClientError: There is no terminal.
    """
    keys = Keys()
    if not keys.live:
        raise ClientError("turtle_teleop_key reads keys: it needs a terminal as its input")
    with Client(name="teleop_turtle") as client, keys:
        teleop = _Teleop(client)
        show(_PAGE)
        key = ""
        while key not in ("q", *QUIT):
            client.run_until(keys.waits)
            key = keys.wait(0.0)
            teleop.press(key)
