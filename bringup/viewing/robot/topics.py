"""The messages of the displays that are shown, as they come."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any, NamedTuple

from rclpy.exceptions import InvalidTopicNameException
from rclpy.expand_topic_name import expand_topic_name
from rclpy.node import Node
from rclpy.serialization import deserialize_message
from rclpy.validate_full_topic_name import validate_full_topic_name
from rclpy.validate_topic_name import validate_topic_name

from arjuna_core.bags.topic import TopicQos, request_for
from arjuna_core.ros.context import class_of
from arjuna_core.ros.qos import profile_of
from bringup.recording.listener import offers_of
from bringup.viewing.displays.base import Display, Wanted
from bringup.viewing.robot.services import Services

_MOST = 200
"""The most messages that wait for a display that may miss none."""


class _Source(NamedTuple):
    """Origin of messages: the parts of a subscription."""

    topic: str
    type_name: str
    qos: TopicQos


class Feed:
    """Keeps the newest message of each topic that is shown, serialized until it is taken."""

    def __init__(self, node: Node, services: Services) -> None:
        self._node, self._services = node, services
        self._open: dict[tuple[str, int], tuple[_Source, Any]] = {}
        self._arrived: dict[tuple[str, int], deque[Any]] = {}
        self._asked: set[str] = set()
        self._refused: set[str] = set()
        self._displays: Mapping[str, Display] = {}

    def listen(self, displays: Mapping[str, Display]) -> None:
        """Subscribe to the topics of displays by their keys, and to no others."""
        self._displays = displays
        types = dict(self._node.get_topic_names_and_types())
        wanted: dict[tuple[str, int], tuple[_Source, int]] = {}
        for key, display in displays.items():
            for number, each in enumerate(display.wanted()):
                if not self.is_name(each.topic):
                    continue
                if "/srv/" in each.types[0]:
                    self._ask(key, number, each)
                    continue
                source = self._source(each, display, types)
                wanted[key, number] = source, _MOST if each.every else 1
        for place, (source, subscription) in list(self._open.items()):
            if place not in wanted or wanted[place][0] != source:
                self._node.destroy_subscription(subscription)
                del self._open[place]
                self._arrived.pop(place, None)
        self._asked &= displays.keys()
        for place in wanted.keys() - self._open.keys():
            self._subscribe(place, *wanted[place])

    def is_name(self, topic: str) -> bool:
        """Return whether a topic can be called so; it is said once where none can."""
        try:
            validate_topic_name(topic)
            validate_full_topic_name(expand_topic_name(topic, "viewer", "/"))
        except InvalidTopicNameException as error:
            if topic not in self._refused:
                self._refused.add(topic)
                problem = " ".join(str(error).split("\n")[0].split())
                self._node.get_logger().warning(f"'{topic}' is no name of a topic: {problem}")
            return False
        return True

    def forget(self, display: str) -> None:
        """Close a display's subscriptions; the next `listen` opens them again."""
        for place in [place for place in self._open if place[0] == display]:
            self._node.destroy_subscription(self._open.pop(place)[1])
            self._arrived.pop(place, None)
        self._asked.discard(display)

    def _subscribe(self, place: tuple[str, int], source: _Source, most: int) -> None:
        try:
            kind = class_of(source.type_name)
        except LookupError as error:
            self._node.get_logger().warning(f"{source.topic}: {error}", once=True)
            return
        arrived: deque[Any] = deque(maxlen=most)
        self._arrived[place] = arrived
        subscription = self._node.create_subscription(
            kind, source.topic, lambda data: arrived.append(data), profile_of(source.qos), raw=True
        )
        self._open[place] = source, subscription

    def _source(self, wanted: Wanted, display: Display, types: Mapping[str, list[str]]) -> _Source:
        """Return a topic's name, type and the QoS that its publishers offer.

        Where nobody publishes it, it is perhaps another topic of its types.
        """
        topic = wanted.topic
        if display.anywhere and not self._node.count_publishers(topic):
            for other, kinds in types.items():
                if set(wanted.types) & set(kinds) and self._node.count_publishers(other):
                    topic = other
                    break
        published = types.get(self._node.resolve_topic_name(topic), [])
        type_name = next((one for one in wanted.types if one in published), wanted.types[0])
        offers, depth = offers_of(self._node, topic), 100 if wanted.every else 10
        usual = TopicQos(display.latched, display.latched)
        request = replace(request_for(offers) if offers else usual, depth=depth)
        return _Source(topic, type_name, request)

    def _ask(self, key: str, number: int, wanted: Wanted) -> None:
        """Ask a service once, if somebody serves it."""
        if key in self._asked:
            return
        kind = class_of(wanted.types[0])
        arrived = self._arrived.setdefault((key, number), deque(maxlen=1))
        if self._services.ask(kind, wanted.topic, kind.Request(), arrived.append):
            self._asked.add(key)

    def take(self) -> Iterator[tuple[str, Any]]:
        """Yield the messages since the last call with their displays' keys."""
        for (key, number), arrived in self._arrived.items():
            while arrived and key in self._displays:
                data = arrived.popleft()
                if isinstance(data, bytes) and not self._displays[key].raw:
                    data = deserialize_message(data, class_of(self._open[key, number][0].type_name))
                yield key, data
