"""Velocity commands in and out: Twist, or TwistStamped."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from geometry_msgs.msg import Twist, TwistStamped
from rclpy.node import Node

from arjuna_core.ros import qos
from arjuna_core.ros.convert import header, seconds, velocity_from_twist
from arjuna_core.ros.health.rules import is_drive
from arjuna_core.ros.messages import maker
from arjuna_core.ros.node import ManagedNode
from arjuna_core.twist import STILL, Velocity

_twist = maker(Twist, "linear.x", "linear.y", "angular.z")
_STAMPED = "geometry_msgs/msg/TwistStamped"
_TYPES = {False: "geometry_msgs/msg/Twist", True: _STAMPED}


def listeners(node: Node, topic: str) -> list[str]:
    """Return the types that the subscriptions of a topic's drives take."""
    name = node.resolve_topic_name(topic)
    infos = node.get_subscriptions_info_by_topic(name)
    return [info.topic_type for info in infos if is_drive(_published(node, info))]


def _published(node: Node, info: Any) -> set[str]:
    """Return the types of what the node of a subscription publishes, as far as it is known."""
    try:
        found = node.get_publisher_names_and_types_by_node(info.node_name, info.node_namespace)
    except RuntimeError:  # its name is not known yet, or it has gone
        return set()
    return {kind for _, kinds in found for kind in kinds}


def subscribe_velocity(
    node: ManagedNode,
    topic: str,
    stamped: bool,
    callback: Callable[[Velocity], None],
    on_stamp: Callable[[float], None] = lambda stamp: None,
) -> VelocityInput:
    """Subscribe to commands, in a node's `configure`; one that is not finite is ignored.

    Args:
        stamped: Whether as TwistStamped at first; see `VelocityInput`.
        on_stamp: Called before `callback` with the command's stamp, or the time it came [s].
    """

    def take(message: Any) -> None:
        is_stamped = isinstance(message, TwistStamped)
        velocity = velocity_from_twist(message.twist if is_stamped else message)
        if velocity.is_finite:
            on_stamp(seconds(message.header.stamp) if is_stamped else node.now)
            callback(velocity)
        else:
            node.get_logger().error(
                f"{topic} ignored: {velocity.x:g} and {velocity.y:g} m/s, "
                f"{velocity.yaw_rate:g} rad/s"
            )

    return VelocityInput(node, topic, stamped, take)


class VelocityInput:
    """Listens to commands as Twist or TwistStamped: as what alone is published on their topic.

    Args:
        node: Of a managed node, made in its `configure`.
        topic: Of the commands.
        stamped: Whether it listens to TwistStamped at first.
        take: Called with each message, of either type.
        profile: The subscription's quality of service.
    """

    def __init__(
        self,
        node: ManagedNode,
        topic: str,
        stamped: bool,
        take: Callable[[Any], None],
        profile: Any = qos.LATEST,
    ) -> None:
        self._node, self._topic, self._stamped = node, topic, stamped
        self._take, self._profile = take, profile
        self._warned = False
        self._subscription: Any = self._listen()
        node.every(0.25, self._check_type)  # [s] between two looks at who publishes

    def rename(self, topic: str) -> None:
        """Listen to another topic."""
        if self._subscription is not None:
            self._node.unsubscribe(self._subscription)
        self._topic = topic
        self._subscription = self._listen()

    def _listen(self) -> Any:
        kind = TwistStamped if self._stamped else Twist
        return self._node.subscribe(kind, self._topic, self._take, self._profile)

    def _check_type(self) -> None:
        """Listen to the other type where that alone is published; warn once where both are.

        A participant knows a topic by one type: the old subscription ends a check before the new.
        """
        if self._subscription is None:
            self._subscription = self._listen()
            return
        node, listened, other = self._node, _TYPES[self._stamped], _TYPES[not self._stamped]
        name = node.full_topic(self._topic)
        senders = {one.topic_type: one.node_name for one in node.get_publishers_info_by_topic(name)}
        if other not in senders:
            return
        if listened not in senders:
            node.unsubscribe(self._subscription)
            self._stamped, self._subscription = not self._stamped, None
            node.get_logger().info(f"{self._topic}: '{senders[other]}' sends {other}: it is taken")
        elif not self._warned:
            self._warned = True
            node.get_logger().warning(
                f"'{senders[other]}' publishes {self._topic} as {other}, but {listened}, which"
                f" '{senders[listened]}' publishes, is listened to"
            )


class VelocityOutput:
    """Publishes velocities.

    Args:
        node: Of a managed node, made in its `configure`.
        stamped: Whether as TwistStamped; None for the type that the topic's subscriptions take.
    """

    def __init__(
        self, node: Node, stamped: bool | None, frame: str = "base_link", topic: str = "cmd_vel"
    ) -> None:
        self._node, self._frame = node, frame
        types = listeners(node, topic) if stamped is None else []
        self._stamped = stamped or (bool(types) and set(types) == {_STAMPED})
        kind = TwistStamped if self._stamped else Twist
        managed = isinstance(node, ManagedNode)
        make, profile = (
            (node.publisher, qos.LATEST) if managed else (node.create_publisher, qos.DEFAULT)
        )
        self._publisher = make(kind, topic, profile)

    def publish(self, velocity: Velocity, stamp: float | None = None) -> None:
        """Publish one velocity, stamped with a time [s], now if None is given."""
        twist = _twist(float(velocity.x), float(velocity.y), float(velocity.yaw_rate))
        if self._stamped:
            if stamp is None:
                stamp = self._node.get_clock().now().nanoseconds / 1e9
            twist = TwistStamped(header=header(self._frame, stamp), twist=twist)
        self._publisher.publish(twist)

    def stop(self) -> None:
        """Publish zero."""
        self.publish(STILL)

    def has_listener(self) -> bool:
        """Return whether somebody listens."""
        return bool(self._publisher.get_subscription_count())
