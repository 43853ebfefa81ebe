"""Topics: what clients listen to, and what they publish."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

from rclpy.node import Node
from rclpy.qos import QoSProfile

from arjuna_core.bags.topic import request_for
from arjuna_core.ros import qos
from arjuna_core.ros.qos import profile_of
from bringup.recording.listener import offers_of
from bringup.ros2.errors import Ros2Error
from bringup.ros2.rosbridge.values import filled, to_json
from bringup.ros2.types import interface_class
from bringup.viewing.foxglove.server import Client


def absolute(name: str) -> str:
    """Return a name as the graph has it."""
    return f"/{name.lstrip('/')}"


def type_of(node: Node, topic: str, given: Any) -> Any:
    """Return the class of a topic's messages, by a client's word or as the graph has it.

    Raises:
        Ros2Error: It is not known, or not installed.
    """
    known = dict(node.get_topic_names_and_types()).get(topic, [])
    if not given and not known:
        raise Ros2Error(f"Cannot infer topic type for topic {topic} as it is not yet advertised")
    return interface_class(given or known[0], "msg")


@dataclass
class _Listener:
    """A client that listens to a topic, by its own name of it."""

    name: str
    period: float
    due: float = 0.0


@dataclass
class _Heard:
    """A topic that is listened to."""

    kind: Any
    profile: QoSProfile
    subscription: Any
    listeners: dict[tuple[Client, Any], _Listener] = field(default_factory=dict)


class Subscriptions:
    """Passes topics' messages on to clients."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self._topics: dict[str, _Heard] = {}

    def subscribe(self, client: Client, message: Any) -> None:
        """Begin; what is latched comes to whoever is new."""
        name = str(message["topic"])
        topic = absolute(name)
        kind = type_of(self._node, topic, message.get("type"))
        period = float(message.get("throttle_rate") or 0) / 1000.0
        listeners = {(client, message.get("id")): _Listener(name, period)}
        if topic in self._topics:
            listeners = {**self._topics[topic].listeners, **listeners}
        self._open(topic, kind, listeners)

    def _open(self, topic: str, kind: Any, listeners: dict[Any, _Listener]) -> None:
        self._end(topic)
        profile = self._profile(topic)
        callback = partial(self._pass_on, topic)
        made = self._node.create_subscription(kind, topic, callback, profile)
        self._topics[topic] = _Heard(kind, profile, made, listeners)

    def _profile(self, topic: str) -> QoSProfile:
        """Return what every publisher matches; where there is none yet, what any will."""
        offers = offers_of(self._node, topic)
        depth = max([10, *(offer.depth for offer in offers)])
        wanted = request_for(offers) if offers else replace(request_for(()), reliable=False)
        return profile_of(replace(wanted, depth=depth))

    def refresh(self) -> None:
        """Listen again where publishers have come that offer something else."""
        for topic, heard in list(self._topics.items()):
            if offers_of(self._node, topic) and self._profile(topic) != heard.profile:
                self._open(topic, heard.kind, heard.listeners)

    def _pass_on(self, topic: str, message: Any) -> None:
        if topic not in self._topics:  # it came before the last listener left
            return
        now, text = time.monotonic(), json.dumps(to_json(message))
        for (client, _), listener in self._topics[topic].listeners.items():
            if now >= listener.due:
                listener.due = now + listener.period
                head = f'{{"op": "publish", "topic": {json.dumps(listener.name)}, "msg": '
                client.send(f"{head}{text}}}", droppable=True)

    def unsubscribe(self, client: Client, message: Any) -> None:
        """End what a client listens to by an id, or all of a topic that it listens to."""
        topic, number = absolute(str(message["topic"])), message.get("id")
        self._leave(topic, lambda key: key[0] is client and number in (None, key[1]))

    def forget(self, client: Client) -> None:
        """Take note that a client is gone."""
        for topic in list(self._topics):
            self._leave(topic, lambda key: key[0] is client)

    def _leave(self, topic: str, leaves: Callable[[tuple[Client, Any]], bool]) -> None:
        if topic in self._topics:
            listeners = self._topics[topic].listeners
            for key in [key for key in listeners if leaves(key)]:
                del listeners[key]
            if not listeners:
                self._end(topic)

    def _end(self, topic: str) -> None:
        heard = self._topics.pop(topic, None)
        if heard is not None:
            self._node.destroy_subscription(heard.subscription)


@dataclass
class _Publisher:
    """A client's publisher, and what it keeps until it has met a subscription."""

    kind: Any
    handle: Any
    meets_by: float
    kept: list[Any] = field(default_factory=list)

    def flush(self) -> None:
        """Publish what is kept, once somebody is there or nobody came in time."""
        if self.kept and (self.handle.get_subscription_count() or time.monotonic() > self.meets_by):
            for message in self.kept:
                self.handle.publish(message)
            self.kept.clear()


class Publications:
    """Publishes what clients send."""

    def __init__(self, node: Node, now: Callable[[], Any]) -> None:
        self._node, self._now = node, now
        self._publishers: dict[tuple[Client, str], _Publisher] = {}

    def advertise(self, client: Client, message: Any) -> None:
        """Make a publisher."""
        topic = absolute(str(message["topic"]))
        kind = type_of(self._node, topic, message.get("type"))
        self._drop((client, topic))
        depth = int(message.get("queue_size") or 100)  # rosbridge's own
        profile = qos.LATCHED if message.get("latch") else QoSProfile(depth=depth)
        handle = self._node.create_publisher(kind, topic, profile)
        meets_by = time.monotonic() + 1.0  # [s] in which it meets who is there
        self._publishers[client, topic] = _Publisher(kind, handle, meets_by)

    def publish(self, client: Client, message: Any) -> None:
        """Publish a message; what was not advertised is where its type is known."""
        key = client, absolute(str(message["topic"]))
        if key not in self._publishers:
            self.advertise(client, message)
        made = self._publishers[key]
        made.kept.append(filled(made.kind(), message.get("msg") or {}, self._now))
        made.flush()

    def flush(self) -> None:
        """Publish what waited for a subscription."""
        for made in self._publishers.values():
            made.flush()

    def unadvertise(self, client: Client, message: Any) -> None:
        """Drop a publisher."""
        self._drop((client, absolute(str(message["topic"]))))

    def forget(self, client: Client) -> None:
        """Take note that a client is gone."""
        for key in [key for key in self._publishers if key[0] is client]:
            self._drop(key)

    def _drop(self, key: tuple[Client, str]) -> None:
        made = self._publishers.pop(key, None)
        if made is not None:
            self._node.destroy_publisher(made.handle)
