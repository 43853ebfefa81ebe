"""Topics received as raw bytes: found as they appear, subscribed to as their publishers offer."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

from rclpy.node import Node
from rclpy.qos import QoSProfile

from arjuna_core.bags.topic import TopicInfo, TopicQos, request_for
from arjuna_core.ros.context import class_of
from arjuna_core.ros.qos import profile_of, qos_of
from bringup.recording.message_definitions import message_definition, type_hash

BARE_NODE: dict[str, Any] = {"start_parameter_services": False, "enable_rosout": False}
"""Options of the recorder's and the player's node."""


class LossCounter:
    """Counts what is missing on one topic.

    A publisher numbers its messages; the publisher of one is unknown, so with several publishers
    a message belongs to the one whose number it continues.

    Attributes:
        lost: How many messages were published and did not arrive.
    """

    def __init__(self) -> None:
        self.lost = 0
        self._last: list[int] = []

    def take(self, number: int, publishers: int) -> None:
        """Note a message by its publisher's number of it, and the topic's count of publishers."""
        for index, last in enumerate(self._last):
            if number == last + 1:
                self._last[index] = number
                return
        before = [last for last in self._last if last < number]
        if len(self._last) < publishers or not before:
            self._last.append(number)  # a publisher that is new, or that began again
            del self._last[: -max(publishers, 1)]
            return
        self.lost += number - max(before) - 1
        self._last[self._last.index(max(before))] = number


class Received(NamedTuple):
    """A message that arrived.

    Attributes:
        received: When it arrived, by the system's clock [ns].
        published: When it was published, by the publisher's [ns].
    """

    topic: TopicInfo
    received: int
    published: int
    data: bytes


@dataclass
class _Subscription:
    topic: TopicInfo
    message_type: Any
    subscription: Any
    request: TopicQos
    publishers: int
    losses: LossCounter = field(default_factory=LossCounter)


class TopicListener:
    """Raw subscriptions, emptied by `take`: to ask each costs 0.4 us, an executor's turn 50 us.

    The middleware gives each message's time of arrival and its publisher's sequence number, which
    no callback of rclpy gives for raw messages.

    Args:
        overrides: Profiles of topics to use whatever their publishers offer; the queue is as long
            as everywhere at least.
    """

    def __init__(
        self,
        node: Node,
        note: Callable[[str], None] = lambda line: None,
        overrides: Mapping[str, QoSProfile] | None = None,
    ) -> None:
        self._node = node
        self._note = note
        self._overrides = overrides or {}
        self._topics: dict[str, _Subscription] = {}
        self._refused: set[str] = set()

    @property
    def topics(self) -> list[TopicInfo]:
        """The topics listened to."""
        return [each.topic for each in self._topics.values()]

    @property
    def lost(self) -> dict[str, int]:
        """The number of messages that were published and never arrived, of topics with any."""
        return {
            name: each.losses.lost for name, each in self._topics.items() if each.losses.lost > 0
        }

    def listen(self, name: str, type_name: str, offers: tuple[TopicQos, ...]) -> bool:
        """Listen to a topic, published yet or not; return whether its type is here (noted once)."""
        try:
            topic = TopicInfo(
                name, type_name, message_definition(type_name), type_hash(type_name), offers
            )
            message_type = class_of(type_name)
        except (LookupError, OSError, ValueError):
            self._refused.add(name)
            self._note(f"{name} is left out: its type {type_name} is not installed")
            return False
        request = request_for(offers)
        subscription = self._subscribe(message_type, name, request)
        self._topics[name] = _Subscription(topic, message_type, subscription, request, len(offers))
        return True

    def discover(
        self, takes: Callable[[str, str], bool], unpublished: bool = False, leaves: bool = True
    ) -> list[str]:
        """Listen to the chosen topics that somebody publishes on by now; return the new ones.

        A topic whose new publishers offer less than was asked for is subscribed to again.

        Args:
            unpublished: Whether those without a publisher are listened to, too.
            leaves: Whether those without a subscriber are.
        """
        found = []
        for name, types in self._node.get_topic_names_and_types():
            if name in self._refused or not takes(name, types[0]):
                continue
            count = self._node.count_publishers(name)
            entry = self._topics.get(name)
            if entry is None and (count or unpublished):
                if not leaves and not self._node.count_subscribers(name):
                    continue
                if self.listen(name, types[0], offers_of(self._node, name)):
                    found.append(name)
            elif entry is not None and count != entry.publishers:
                self._adapt(entry, count)
        return found

    def _adapt(self, entry: _Subscription, count: int) -> None:
        entry.publishers = count
        request = request_for(offers_of(self._node, entry.topic.name))
        before = entry.request
        if entry.topic.name in self._overrides:
            return
        weaker = before.reliable > request.reliable or before.latched > request.latched
        if count and weaker:
            self._node.destroy_subscription(entry.subscription)
            entry.request = request
            name = entry.topic.name
            entry.subscription = self._subscribe(entry.message_type, name, request)

    def _subscribe(self, message_type: Any, name: str, request: TopicQos, depth: int = 1000) -> Any:
        """Subscribe with a queue of the messages that may wait between two calls of `take`."""
        profile = self._overrides.get(name) or profile_of(replace(request, depth=depth))
        profile.depth = max(profile.depth, depth)
        return self._node.create_subscription(
            message_type, name, lambda data: None, profile, raw=True
        )

    def take(self) -> list[Received]:
        """Return what has arrived since the last call, in the order in which it came."""
        found = []
        for entry in self._topics.values():
            handle, kind = entry.subscription.handle, entry.message_type
            if not getattr(handle, "waiting", True):  # of the local transport
                continue
            with handle:
                while (taken := handle.take_message(kind, True)) is not None:
                    data, info = taken
                    entry.losses.take(info["publication_sequence_number"], entry.publishers)
                    received, published = info["received_timestamp"], info["source_timestamp"]
                    found.append(Received(entry.topic, received, published, data))
        found.sort(key=lambda each: each.received)
        return found


def offers_of(node: Node, topic: str) -> tuple[TopicQos, ...]:
    """Return the QoS of a topic's publishers."""
    return tuple(qos_of(each.qos_profile) for each in node.get_publishers_info_by_topic(topic))
