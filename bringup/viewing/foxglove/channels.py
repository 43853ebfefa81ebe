"""ROS topics as Foxglove's channels: passed on byte for byte, and only while somebody listens."""

from __future__ import annotations

import importlib
import re
import time
from collections import Counter
from typing import Any

import foxglove
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from bringup.recording.message_definitions import message_definition

_TYPE = re.compile(r"([a-z][a-z0-9_]*)/msg/([A-Z][A-Za-z0-9]*)")


def message_type(type_name: str) -> Any:
    """Return the class of a message's type, `package/msg/Name`.

    Raises:
        LookupError: It is not installed.
    """
    parts = _TYPE.fullmatch(type_name)
    if parts is None:
        raise LookupError(f"'{type_name}' is no message type; valid: package/msg/Name")
    try:
        return getattr(importlib.import_module(f"{parts[1]}.msg"), parts[2])
    except (ImportError, AttributeError) as error:
        raise LookupError(f"type '{type_name}' is not installed") from error


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
            message_type(type_name)
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
            message_type(type_name), topic, pass_on, profile, raw=True
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
        """Return the best quality of service that every publisher of a topic offers."""
        offers = [item.qos_profile for item in self._node.get_publishers_info_by_topic(topic)]
        reliable = all(o.reliability == ReliabilityPolicy.RELIABLE for o in offers)
        latched = all(o.durability == DurabilityPolicy.TRANSIENT_LOCAL for o in offers)
        return QoSProfile(
            depth=max([10, *(offer.depth for offer in offers)]),
            reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
            durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
        )
