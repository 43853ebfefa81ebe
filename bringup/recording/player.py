"""Recordings played: the recorded bytes, on the recorded topics, with the recorded QoS."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

from rclpy.context import Context
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rosgraph_msgs.msg import Clock

from arjuna_core.bags.topic import BagMessage, TopicInfo, offer_for
from arjuna_core.ros import qos
from bringup.recording.listener import message_class

_NANO = 1_000_000_000
_STATIC = 100  # transforms whose publishers one latched topic stands for


class Player:
    """Publishers for the topics of a recording.

    Args:
        context: The context to publish in.
        topics: The topics to play.
        remap: New names of topics.
        clock: Whether it publishes `/clock` too.
        note: Takes a line about a topic that cannot be played.

    Attributes:
        published: How many messages have been published.
    """

    def __init__(
        self,
        context: Context,
        topics: Iterable[TopicInfo],
        remap: Mapping[str, str],
        clock: bool = False,
        note: Callable[[str], None] = lambda line: None,
    ) -> None:
        self._node = Node(
            "player", context=context, start_parameter_services=False, enable_rosout=False
        )
        self._publishers: dict[str, Any] = {}
        for topic in topics:
            self._publish(topic, remap.get(topic.name, topic.name), note)
        self._clock = self._node.create_publisher(Clock, "/clock", qos.LATEST) if clock else None
        self.published = 0

    def _publish(self, topic: TopicInfo, name: str, note: Callable[[str], None]) -> None:
        if topic.encoding != "cdr":
            note(f"{topic.name} is left out: it is encoded as '{topic.encoding}', not as cdr")
            return
        try:
            message_type = message_class(topic.type_name)
        except (ImportError, AttributeError, ValueError):
            note(f"{topic.name} is left out: its type {topic.type_name} is not installed")
            return
        publisher = self._node.create_publisher(message_type, name, _profile(topic))
        self._publishers[topic.name] = publisher

    def publish(self, message: BagMessage) -> None:
        """Publish a message, unless its topic cannot be played."""
        publisher = self._publishers.get(message.topic.name)
        if publisher is not None:
            publisher.publish(bytes(message.data))
            self.published += 1

    def publish_clock(self, time: int) -> None:
        """Publish a time [ns] on `/clock`, where that was asked for."""
        if self._clock is not None:
            message = Clock()
            message.clock.sec, message.clock.nanosec = divmod(time, _NANO)
            self._clock.publish(message)

    def close(self) -> None:
        """Leave the graph."""
        self._node.destroy_node()


def _profile(topic: TopicInfo) -> QoSProfile:
    several = _STATIC if topic.name.endswith("tf_static") else 1
    offer = offer_for(topic.offers, several)
    return QoSProfile(
        depth=offer.depth,
        reliability=(
            ReliabilityPolicy.RELIABLE if offer.reliable else ReliabilityPolicy.BEST_EFFORT
        ),
        durability=(
            DurabilityPolicy.TRANSIENT_LOCAL if offer.latched else DurabilityPolicy.VOLATILE
        ),
    )
