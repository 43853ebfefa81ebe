"""ROS topics as Foxglove's channels, byte for byte while somebody listens, and its clients' own."""

from __future__ import annotations

import struct
import time
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import Any

from rclpy.exceptions import InvalidTopicNameException
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile

from arjuna_core.bags.topic import request_for
from arjuna_core.ros import qos
from arjuna_core.ros.context import class_of
from arjuna_core.ros.qos import profile_of
from bringup.recording.listener import offers_of
from bringup.viewing.foxglove.offers import Offers, encoding_of, visible
from bringup.viewing.foxglove.server import ERROR, WARNING, Client

_LITTLE_ENDIAN_CDR = b"\x00\x01"


def _described(topic: str, type_name: str) -> dict[str, Any]:
    class_of(type_name)
    return {"topic": topic, **encoding_of(type_name)}


class Channels:
    """A channel for each topic of the graph."""

    def __init__(self, node: Node, clients: Sequence[Client]) -> None:
        self._node = node
        words = ("advertise", "channels", "channelIds")
        self._offers = Offers(node, clients, words, _described)
        self.greet = self._offers.greet
        self._listeners = defaultdict[int, set[tuple[Client, int]]](set)
        self._subscriptions: dict[int, Any] = {}

    def refresh(self) -> None:
        """Open channels for new topics, close those of topics that are gone."""
        found = visible(self._node.get_topic_names_and_types())
        for number in self._offers.refresh(
            {name: kind for name, kind in found.items() if self._node.count_publishers(name)}
        ):
            self._listeners.pop(number, None)
            self._end(number)

    def subscribe(self, client: Client, message: Any) -> None:
        """Pass topics' messages on; what is latched comes again, to the newcomer too."""
        for wanted in message["subscriptions"]:
            number = wanted["channelId"]
            channel = self._offers.find(number)
            if channel is None:
                client.send_status(ERROR, f"Unknown channel ID: {number}")
                continue
            self._listeners[number].add((client, int(wanted["id"])))
            profile = self._profile(channel["topic"])
            latched = profile.durability == DurabilityPolicy.TRANSIENT_LOCAL
            if latched or number not in self._subscriptions:
                self._end(number)
                self._subscriptions[number] = self._node.create_subscription(
                    *(class_of(channel["schemaName"]), channel["topic"]),
                    *(partial(self._pass_on, number), profile),
                    raw=True,
                )

    def _pass_on(self, channel: int, data: Any) -> None:
        now = time.time_ns()
        for client, number in self._listeners[channel]:
            stamp = now if client.clock is None else client.clock
            client.send_binary(1, "IQ", number, stamp, data=data)

    def unsubscribe(self, client: Client, message: Any) -> None:
        """Stop passing topics on, to all clients where the last listener leaves."""
        self._leave({(client, number) for number in message["subscriptionIds"]})

    def forget(self, client: Client) -> None:
        """Take note that a client is gone."""
        self._leave({key for keys in self._listeners.values() for key in keys if key[0] is client})

    def _leave(self, listeners: set[tuple[Client, int]]) -> None:
        for number in list(self._listeners):
            self._listeners[number] -= listeners
            if not self._listeners[number]:
                del self._listeners[number]
                self._end(number)

    def _end(self, number: int) -> None:
        subscription = self._subscriptions.pop(number, None)
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
        self._publishers: dict[tuple[Client, int], Any] = {}

    def advertise(self, client: Client, message: Any) -> None:
        """Make publishers for a client's channels, or say why that is not possible.

        Types are `package/msg/Name` or, as in ROS 1, `package/Name`.
        """
        for channel in message["channels"]:
            topic, key = channel["topic"], (client, channel["id"])
            try:
                if channel["encoding"] != "cdr":
                    raise LookupError(f"encoding '{channel['encoding']}' is not taken; valid: cdr")
                kind = class_of(_full(channel["schemaName"]))
                publisher = self._node.create_publisher(kind, topic, qos.DEFAULT)
            except (LookupError, InvalidTopicNameException) as error:
                problem = f"{topic}: {error}"
                self._node.get_logger().warning(problem)
                client.send_status(WARNING, problem)
            else:
                self._drop(key)
                self._publishers[key] = publisher

    def unadvertise(self, client: Client, message: Any) -> None:
        """Drop the publishers of channels."""
        for number in message["channelIds"]:
            self._drop((client, number))

    def forget(self, client: Client) -> None:
        """Take note that a client is gone."""
        for key in [key for key in self._publishers if key[0] is client]:
            self._drop(key)

    def _drop(self, key: tuple[Client, int]) -> None:
        publisher = self._publishers.pop(key, None)
        if publisher is not None:
            self._node.destroy_publisher(publisher)

    def publish(self, client: Client, data: bytes) -> None:
        """Publish a message, if its channel is open and it is in CDR."""
        (number,) = struct.unpack_from("<I", data)
        if (client, number) in self._publishers and data[4:6] == _LITTLE_ENDIAN_CDR:
            self._publishers[client, number].publish(data[4:])


def _full(type_name: str) -> str:
    package, _, name = type_name.rpartition("/")
    return type_name if "/" in package else f"{package}/msg/{name}"
