"""Velocity commands in and out: Twist, or TwistStamped."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from geometry_msgs.msg import Twist, TwistStamped, Vector3

from arjuna_core.ros import qos
from arjuna_core.ros.convert import header
from arjuna_core.ros.node import ManagedNode
from arjuna_core.twist import STILL, Velocity


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
        velocity = Velocity(twist.linear.x, yaw_rate=twist.angular.z)
        if math.isfinite(velocity.x) and math.isfinite(velocity.yaw_rate):
            callback(velocity)
        else:
            node.get_logger().error(
                f"{topic} ignored: {velocity.x:g} m/s, {velocity.yaw_rate:g} rad/s"
            )

    node.subscribe(TwistStamped if stamped else Twist, topic, take, qos.LATEST)


class VelocityOutput:
    """Publishes velocities.

    Args:
        node: The node; made in its `configure`.
        stamped: Whether the type is TwistStamped.
        frame: Frame of a stamped twist.
        topic: The topic.
    """

    def __init__(
        self,
        node: ManagedNode,
        stamped: bool,
        frame: str = "base_link",
        topic: str = "cmd_vel",
    ) -> None:
        self._node = node
        self._stamped = stamped
        self._frame = frame
        self._publisher = node.publisher(TwistStamped if stamped else Twist, topic, qos.LATEST)

    def publish(self, velocity: Velocity) -> None:
        """Publish one velocity."""
        linear, angular = Vector3(x=float(velocity.x)), Vector3(z=float(velocity.yaw_rate))
        twist = Twist(linear=linear, angular=angular)
        if self._stamped:
            stamp = header(self._frame, self._node.now)
            self._publisher.publish(TwistStamped(header=stamp, twist=twist))
        else:
            self._publisher.publish(twist)

    def stop(self) -> None:
        """Publish zero."""
        self.publish(STILL)
