"""The velocity command's publisher: Twist, or TwistStamped."""

from __future__ import annotations

from geometry_msgs.msg import Twist, TwistStamped

from arjuna_core.ros import qos
from arjuna_core.ros.convert import header
from arjuna_core.ros.node import ManagedNode
from arjuna_core.twist import STILL, Velocity


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
        twist = Twist()
        twist.linear.x, twist.angular.z = float(velocity.v), float(velocity.w)
        if self._stamped:
            stamp = header(self._frame, self._node.now)
            self._publisher.publish(TwistStamped(header=stamp, twist=twist))
        else:
            self._publisher.publish(twist)

    def stop(self) -> None:
        """Publish zero."""
        self.publish(STILL)
