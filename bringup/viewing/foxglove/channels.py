"""ROS topics as Foxglove's channels, byte for byte while somebody listens, and its clients' own."""

from __future__ import annotations

import time
from collections import Counter
from dataclasses import replace
from typing import Any

import foxglove
from rclpy.exceptions import InvalidTopicNameException
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile

from arjuna_core.bags.topic import request_for
from arjuna_core.ros import qos
from arjuna_core.ros.context import class_of
from arjuna_core.ros.qos import profile_of
from bringup.recording.listener import offers_of
from bringup.recording.message_definitions import message_definition

_LITTLE_ENDIAN_CDR = b"\x00\x01"


class Channels:
    """A channel for each topic of the graph."""

    def __init__(self, node: Node, context: foxglove.Context) -> None:
        self._node = node
        self._context = context
        self._channels: dict[str, tuple[foxglove.Channel, str]] = {}
        self._listeners: Counter[str] = Counter()
        self._subscriptions: dict[str, Any] = {}
        self._unknown: set[str] = set()

    @property
    def idle(self) -> bool:
        """True while nobody listens."""
        return not self._subscriptions

    def refresh(self) -> None:
        """Open channels for new topics, close those of topics that are gone."""
        found = {
            name: types[0]
            for name, types in self._node.get_topic_names_and_types()
            if types and "/_" not in name and self._node.count_publishers(name)
        }
        for topic in [
            name for name, (_, kind) in self._channels.items() if found.get(name) != kind
        ]:
            self._close(topic)
        for topic, type_name in found.items():
            if topic not in self._channels and type_name not in self._unknown:
                self._open(topic, type_name)

    def _open(self, topic: str, type_name: str) -> None:
        try:
            class_of(type_name)
            text = message_definition(type_name)
        except LookupError as error:
            self._unknown.add(type_name)
            self._node.get_logger().warning(f"{topic} is not passed on: {error}")
            return
        schema = foxglove.Schema(name=type_name, encoding="ros2msg", data=text.encode())
        channel = foxglove.Channel(
            topic, schema=schema, message_encoding="cdr", context=self._context
        )
        self._channels[topic] = (channel, type_name)

    def _close(self, topic: str) -> None:
        self._listeners.pop(topic, None)
        self._unsubscribe(topic)
        self._channels.pop(topic)[0].close()

    def subscribe(self, topic: str) -> None:
        """Pass a topic's messages on; what is latched comes again, to the newcomer too."""
        if topic not in self._channels:
            return
        self._listeners[topic] += 1
        profile = self._profile(topic)
        latched = profile.durability == DurabilityPolicy.TRANSIENT_LOCAL
        if topic in self._subscriptions and not latched:
            return
        self._unsubscribe(topic)
        channel, type_name = self._channels[topic]

        def pass_on(data: Any) -> None:
            channel.log(data, log_time=time.time_ns())

        self._subscriptions[topic] = self._node.create_subscription(
            class_of(type_name), topic, pass_on, profile, raw=True
        )

    def unsubscribe(self, topic: str) -> None:
        """Stop passing a topic on, when its last listener leaves."""
        self._listeners[topic] -= 1
        if self._listeners[topic] <= 0:
            del self._listeners[topic]
            self._unsubscribe(topic)

    def _unsubscribe(self, topic: str) -> None:
        subscription = self._subscriptions.pop(topic, None)
        if subscription is not None:
            self._node.destroy_subscription(subscription)

    def _profile(self, topic: str) -> QoSProfile:
        offers = offers_of(self._node, topic)
        depth = max([10, *(offer.depth for offer in offers)])
        return profile_of(replace(request_for(offers), depth=depth))


class Publications:
    """A publisher for each channel that a client advertised."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self._publishers: dict[tuple[int, int], Any] = {}

    def advertise(
        self, key: tuple[int, int], topic: str, type_name: str, encoding: str
    ) -> str | None:
        """Make a publisher for a client's channel; return why that is not possible, if so.

        Args:
            type_name: `package/msg/Name` or, as in ROS 1, `package/Name`.
        """
        if encoding != "cdr":
            return f"{topic}: encoding '{encoding}' is not taken; valid: cdr"
        try:
            publisher = self._node.create_publisher(class_of(_full(type_name)), topic, qos.DEFAULT)
        except (LookupError, InvalidTopicNameException) as error:
            return f"{topic}: {error}"
        self._publishers[key] = publisher
        return None

    def unadvertise(self, key: tuple[int, int]) -> None:
        """Drop a channel's publisher."""
        publisher = self._publishers.pop(key, None)
        if publisher is not None:
            self._node.destroy_publisher(publisher)

    def publish(self, key: tuple[int, int], data: bytes) -> None:
        """Publish a message, if its channel is open and it is in CDR."""
        if key in self._publishers and data[:2] == _LITTLE_ENDIAN_CDR:
            self._publishers[key].publish(data)


def _full(type_name: str) -> str:
    package, _, name = type_name.rpartition("/")
    return type_name if "/" in package else f"{package}/msg/{name}"
