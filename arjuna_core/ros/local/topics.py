"""Topics of one process: publishers hand their messages to subscriptions as they are."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import Any

from rclpy.exceptions import InvalidHandle
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message

from arjuna_core.ros.health.checks import problem_of
from arjuna_core.ros.local.cdr import to_cdr
from arjuna_core.ros.local.reading import handed_over
from arjuna_core.ros.local.transport import Registry


class LocalSubscription:
    """The end of a topic where messages arrive; what rclpy's Subscription is to its owner.

    Of more than its QoS's depth the oldest are lost. A raw one, of a node that no executor runs,
    is emptied by `take_message`.

    Attributes:
        waiting: Messages, why they cannot be used, and whether a node of ours made them; or bytes,
            and their numbers.
    """

    def __init__(
        self,
        registry: Registry,
        node: Any,
        msg_type: Any,
        topic_name: str,
        callback: Callable[[Any], Any],
        qos_profile: QoSProfile,
        raw: bool,
    ) -> None:
        self._registry = registry
        self.node = node
        self.msg_type, self.topic_name, self.qos_profile = msg_type, topic_name, qos_profile
        self.callback, self.raw = callback, raw
        self.waiting: deque[tuple[Any, ...]] = deque(maxlen=_depth(qos_profile))
        self.topic = topic_name
        self.handle = self
        self.event_handlers: tuple[Any, ...] = ()
        registry.subscriptions[topic_name].append(self)
        for publisher in registry.publishers[topic_name]:
            publisher.meet(self)

    def deliver(self) -> None:
        """Call back with the message that came first, if one waits."""
        if self.waiting:
            registry = self._registry
            message, registry.problem, registry.trusted = self.waiting.popleft()
            self.callback(message)

    def take_message(self, kind: Any, raw: bool) -> Any:
        """Return the bytes that wait and their numbers, as rclpy's handle does; None if none."""
        return self.waiting.popleft() if self.waiting else None

    def __enter__(self) -> LocalSubscription:
        """Return the handle, which nobody destroys meanwhile."""
        return self

    def __exit__(self, *problem: object) -> None:
        """Do nothing."""

    def get_publisher_count(self) -> int:
        """Return how many publishers send to it."""
        return sum(self in each.readers for each in self._registry.publishers[self.topic_name])

    def destroy(self) -> None:
        """Listen no more; what waits is not delivered."""
        self.waiting.clear()
        self._registry.subscriptions[self.topic_name].remove(self)
        for publisher in self._registry.publishers[self.topic_name]:
            if self in publisher.readers:
                publisher.readers.remove(self)


class LocalPublisher:
    """The end of a topic where messages enter; what rclpy's Publisher is to its owner.

    Those who listen share each message, which nobody changes: of a trusted publisher the message
    itself, of others a copy.

    Attributes:
        readers: The subscriptions that it sends to.
        trusted: Whether its messages need no check, for a node of ours makes them.
        hand_over: Returns of a message the one that its readers share; None where it is that one.
    """

    def __init__(
        self, registry: Registry, node: Any, msg_type: Any, topic_name: str, qos_profile: QoSProfile
    ) -> None:
        self._registry = registry
        self.node = node
        self.msg_type, self.topic_name, self.qos_profile = msg_type, topic_name, qos_profile
        self.topic = topic_name
        self.readers: list[LocalSubscription] = []
        self.trusted: bool = node.trusted
        self.hand_over = handed_over(msg_type, node.trusted)
        self._latched = qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL
        self._kept: deque[Any] = deque(maxlen=_depth(qos_profile))
        self._count = 0
        self.event_handlers: tuple[Any, ...] = ()
        self._destroyed = False
        registry.publishers[topic_name].append(self)
        for reader in registry.subscriptions[topic_name]:
            self.meet(reader)

    def publish(self, message: Any) -> None:
        """Hand a message to every subscription, in the order in which they came.

        Raises:
            TypeError: It is of another type.
            InvalidHandle: The publisher is destroyed.
        """
        if type(message) is not self.msg_type or self._destroyed:
            message = self._admitted(message)
        self._count += 1
        if not (self.readers or self._latched):
            return
        trusted, registry = self.trusted, self._registry
        if self.hand_over is not None:
            message = self.hand_over(message)
        if registry.watching:
            registry.watch(self.topic_name, message)
        judged = message, None if trusted else problem_of(message, registry.now), trusted
        if self._latched:
            self._kept.append(judged)
        self._send(judged, self.readers, self._count)

    def _admitted(self, message: Any) -> Any:
        """Return the message that is to be published, which may be given as its bytes."""
        if isinstance(message, bytes):
            message = deserialize_message(message, self.msg_type)
        if not isinstance(message, self.msg_type):
            raise TypeError(f"Expected {self.msg_type}, got {type(message)}")
        if self._destroyed:
            raise InvalidHandle(f"the publisher of '{self.topic_name}' is destroyed")
        return message

    def _send(self, judged: Any, readers: list[LocalSubscription], count: int) -> None:
        executor, taken = self._registry.executor, None
        put, nodes = executor.put, executor.nodes
        for reader in readers:
            if not reader.raw:
                reader.waiting.append(judged)
            else:
                taken = taken or (to_cdr(judged[0]), self._registry.message_info(count))
                reader.waiting.append(taken)
            if reader.node in nodes:
                put(reader.deliver)

    def meet(self, reader: LocalSubscription) -> None:
        """Send to a subscription from now on, if what it asks is offered, and what was kept."""
        if reader.msg_type is self.msg_type and _suits(self.qos_profile, reader.qos_profile):
            self.readers.append(reader)
            if reader.qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL:
                for number, judged in enumerate(self._kept, self._count - len(self._kept) + 1):
                    self._send(judged, [reader], number)

    def get_subscription_count(self) -> int:
        """Return how many subscriptions it sends to."""
        return len(self.readers)

    def destroy(self) -> None:
        """Send no more."""
        self._destroyed = True
        self.readers.clear()
        self._registry.publishers[self.topic_name].remove(self)


def _depth(profile: QoSProfile) -> int | None:
    return None if profile.history == HistoryPolicy.KEEP_ALL else max(int(profile.depth), 1)


def _suits(offer: QoSProfile, request: QoSProfile) -> bool:
    """Return whether a subscription may ask for what a publisher offers, as DDS sees it."""
    unreliable = (
        offer.reliability == ReliabilityPolicy.BEST_EFFORT
        and request.reliability == ReliabilityPolicy.RELIABLE
    )
    forgetful = (
        offer.durability == DurabilityPolicy.VOLATILE
        and request.durability == DurabilityPolicy.TRANSIENT_LOCAL
    )
    return not (unreliable or forgetful)
