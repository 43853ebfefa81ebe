"""The publishers of recorded topics, and the options of playing."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.qos import ReliabilityPolicy
from rclpy.serialization import deserialize_message
from rosgraph_msgs.msg import Clock

from arjuna_core.bags.topic import BagMessage, TopicInfo, TopicQos, offer_for
from arjuna_core.ros import qos
from arjuna_core.ros.context import class_of
from arjuna_core.ros.qos import profile_of
from arjuna_core.timing import NANOSECONDS
from bringup.recording.playback import PlayOptions
from bringup.recording.selection import EVENTS, is_service

CLOCK = "/clock"
REQUESTS = {"service_introspection": 1, "client_introspection": 0}
"""The event of a request as the service noted it, and as the client did: ServiceEventInfo's."""


class Player:
    """A node's publishers for a recording's topics; notes say which cannot be played."""

    def __init__(
        self,
        node: Node,
        topics: Iterable[TopicInfo],
        options: PlayOptions | None = None,
        note: Callable[[str], None] = lambda line: None,
    ) -> None:
        self._node = node
        self._options = options = options or PlayOptions()
        self._note = note
        self._publishers: dict[str, Any] = {}
        self._clients: dict[str, Any] = {}
        self._events: dict[str, Any] = {}
        for topic in topics:
            self._advertise(topic)
        makes = options.makes_clock
        self._clock = node.create_publisher(Clock, CLOCK, qos.LATEST) if makes else None
        self.published = 0

    def _advertise(self, topic: TopicInfo, static_publishers: int = 100) -> None:
        """Advertise a topic; that of /tf_static latches a message of each of many publishers.

        It does so where the recording has no QoS too, as one converted from ROS 1: tf2's listeners
        hear no other.
        """
        options, name = self._options, topic.name
        if topic.encoding != "cdr":
            self._note(f"{name} is left out: it is encoded as '{topic.encoding}', not as cdr")
            return
        asks = options.requests is not None and is_service(name, topic.type_name)
        try:
            message_type = class_of(topic.type_name)
            service = class_of(topic.type_name.removesuffix("_Event")) if asks else None
        except LookupError:
            self._note(f"{name} is left out: its type {topic.type_name} is not installed")
            return
        if asks:
            self._events[name] = message_type
            self._clients[name] = self._node.create_client(service, name.removesuffix(EVENTS))
            return
        is_static = name.endswith("tf_static")
        offers = topic.offers or ([TopicQos(latched=True)] if is_static else [])
        offer = offer_for(offers, static_publishers if is_static else 1)
        profile = options.overrides.get(name) or profile_of(offer)
        self._publishers[name] = self._node.create_publisher(
            message_type, options.remap.get(name, name), profile
        )

    def publish(self, message: BagMessage) -> bool:
        """Publish a message or ask a service; return whether its topic can be played."""
        name = message.topic.name
        if name in self._clients and not self._ask(name, bytes(message.data)):
            return False
        publisher = self._publishers.get(name)
        if publisher is None and name not in self._clients:
            return False
        triggers = self._options.clock_topics
        if triggers is None or name in triggers:
            self.publish_clock(message.time)
        if publisher is not None:
            publisher.publish(bytes(message.data))
        self.published += 1
        return True

    def _ask(self, name: str, data: bytes) -> bool:
        """Send the request of an event to its service; return whether there was one to send."""
        client, event = self._clients[name], deserialize_message(data, self._events[name])
        if event.info.event_type != self._options.requests:
            return False
        service = name.removesuffix(EVENTS)
        if not client.service_is_ready():
            self._note(f"no request is sent to {service}: the service is not there")
        elif not event.request:
            self._note(f"no request is sent to {service}: its introspection was metadata only")
        else:
            client.remove_pending_request(client.call_async(event.request[0]))
            return True
        return False

    def publish_clock(self, time: int) -> None:
        """Publish a time [ns] on `/clock`, where that was asked for."""
        if self._clock is not None:
            message = Clock()
            message.clock.sec, message.clock.nanosec = divmod(time, NANOSECONDS)
            self._clock.publish(message)

    def wait_for_acknowledgement(self, timeout: float) -> None:
        """Wait until those who listen have all messages of reliable topics, 0 for ever [s]."""
        limit = Duration(seconds=timeout) if timeout else Duration(seconds=-1)
        for name, publisher in self._publishers.items():
            if publisher.qos_profile.reliability == ReliabilityPolicy.BEST_EFFORT:
                self._note(f"{name} is best effort: nobody acknowledges its messages")
            elif not publisher.wait_for_all_acked(limit):
                self._note(f"{name}: not all messages were acknowledged within {timeout} s")
