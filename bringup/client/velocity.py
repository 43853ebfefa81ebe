"""Velocity commands of a client: Twist or TwistStamped, whichever the robot listens for."""

from __future__ import annotations

from typing import Any

from geometry_msgs.msg import Twist, TwistStamped

from arjuna_core.ros import qos
from bringup.client.session import Session

_REMEDY = "is 'python -m bringup sim' running?"
_STAMPED = "geometry_msgs/msg/TwistStamped"


class VelocityPublisher:
    """Publishes velocities, and a stop when closed.

    Args:
        session: The connection to the robot.
        topic: Where the robot listens.
        stamped: Whether as TwistStamped; None for what the robot's subscription says.
    """

    def __init__(
        self, session: Session, topic: str = "cmd_vel", stamped: bool | None = None
    ) -> None:
        self._session = session
        self._topic = topic
        self._stamped = stamped
        self._publisher: Any = None

    def wait(self, timeout: float) -> None:
        """Wait for a robot that listens.

        Raises:
            ArjunaError: None does in time [s].
        """
        listeners = self._listeners
        what = f"a robot that listens on '{self._topic}'"
        self._session.wait_for(lambda: bool(listeners()), timeout, what, _REMEDY)
        stamped = self._stamped
        if stamped is None:
            stamped = all(info.topic_type == _STAMPED for info in listeners())
        self._stamped = stamped
        self._publisher = self._session.client.create_publisher(
            TwistStamped if stamped else Twist, self._topic, qos.DEFAULT
        )
        matched = self._publisher.get_subscription_count
        self._session.wait_for(lambda: matched() > 0, timeout, what, _REMEDY)

    def _listeners(self) -> list[Any]:
        client = self._session.client
        name = client.resolve_topic_name(self._topic)
        return list(client.get_subscriptions_info_by_topic(name))

    def send(self, v: float, w: float) -> None:
        """Ask for a forward speed [m/s] and a turn rate [rad/s]."""
        twist = Twist()
        twist.linear.x, twist.angular.z = float(v), float(w)
        if self._stamped:
            stamped = TwistStamped(twist=twist)
            stamped.header.stamp = self._session.client.get_clock().now().to_msg()
            self._publisher.publish(stamped)
        else:
            self._publisher.publish(twist)

    def stop(self) -> None:
        """Stand still; the command reaches the robot before the client leaves."""
        if self._publisher is not None:
            for _ in range(3):
                self.send(0.0, 0.0)
                self._session.pause(0.05)
