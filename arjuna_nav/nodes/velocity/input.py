"""Velocity commands that come in: Twist, or TwistStamped."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from geometry_msgs.msg import Twist, TwistStamped

from arjuna_core.ros import qos
from arjuna_core.ros.node import ManagedNode
from arjuna_core.twist import Velocity


def subscribe_velocity(
    node: ManagedNode, topic: str, stamped: bool, callback: Callable[[Velocity], None]
) -> None:
    """Subscribe to commands; one that is no number is ignored and said so.

    Args:
        node: The node; in its `configure`.
        topic: The topic.
        stamped: Whether the type is TwistStamped.
        callback: Called with each command.
    """

    def take(message: Any) -> None:
        twist = message.twist if stamped else message
        velocity = Velocity(twist.linear.x, twist.angular.z)
        if math.isfinite(velocity.v) and math.isfinite(velocity.w):
            callback(velocity)
        else:
            node.get_logger().error(f"{topic} ignored: {velocity.v:g} m/s, {velocity.w:g} rad/s")

    node.subscribe(TwistStamped if stamped else Twist, topic, take, qos.LATEST)
