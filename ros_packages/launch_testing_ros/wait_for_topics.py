"""Waiting until messages have come on topics."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Iterable
from typing import Any

import rclpy
from rclpy.context import Context
from rclpy.qos import QoSProfile, qos_profile_system_default

from launch_testing_ros.message_pump import MessagePump

MessagePattern = Callable[[Any], bool]


class WaitForTopics:
    """Listens to topics, in a context of its own.

    Args:
        topic_tuples: `(topic, type)`, or with a function that chooses messages.
        timeout: [s] for the first message of each.
        messages_received_buffer_length: How many messages of a topic are kept.
        trigger: Called once all listen, before it waits: with the node, and `callback_arguments`.
    """

    def __init__(
        self,
        topic_tuples: Iterable[tuple[Any, ...]],
        timeout: float = 5.0,
        messages_received_buffer_length: int = 10,
        trigger: Callable[..., Any] | None = None,
        node_namespace: str | None = None,
        qos_profile: QoSProfile = qos_profile_system_default,
        callback_arguments: Iterable[Any] = (),
    ) -> None:
        self._topics = [(one[0], one[1], one[2] if len(one) > 2 else None) for one in topic_tuples]
        self._timeout, self._trigger = timeout, trigger
        self._arguments = tuple(callback_arguments)
        self._changed = threading.Condition()
        self._received: dict[str, deque[Any]] = {
            topic: deque(maxlen=messages_received_buffer_length) for topic, _, _ in self._topics
        }
        self._context = Context()
        rclpy.init(context=self._context)
        self._node = rclpy.create_node(
            f"wait_for_topics_{id(self) % 10_000_000}",
            context=self._context,
            namespace=node_namespace,
        )
        for topic, kind, chosen in self._topics:
            self._node.create_subscription(kind, topic, self._taker(topic, chosen), qos_profile)
        self._pump = MessagePump(self._node, self._context)
        self._pump.start()

    def _taker(self, topic: str, chosen: MessagePattern | None) -> Callable[[Any], None]:
        def take(message: Any) -> None:
            if chosen is None or chosen(message):
                with self._changed:
                    self._received[topic].append(message)
                    self._changed.notify_all()

        return take

    def wait(self, *args: Any, **kwargs: Any) -> bool:
        """Return whether a message has come on each topic in time."""
        if self._trigger is not None:
            self._trigger(self._node, *self._arguments, *args, **kwargs)
        with self._changed:
            return self._changed.wait_for(lambda: not self.topics_not_received(), self._timeout)

    def topics_not_received(self) -> set[str]:
        return {topic for topic, messages in self._received.items() if not messages}

    def topics_received(self) -> set[str]:
        return self._received.keys() - self.topics_not_received()

    def received_messages(self, topic_name: str) -> list[Any]:
        """Return the last messages of a topic.

        Raises:
            KeyError: It is not listened to.
        """
        with self._changed:
            return list(self._received[topic_name])

    def shutdown(self) -> None:
        self._pump.stop()
        self._node.destroy_node()
        if self._context.ok():
            rclpy.shutdown(context=self._context)

    def __enter__(self) -> WaitForTopics:
        if not self.wait():
            self.shutdown()
            raise RuntimeError(f"no message on {sorted(self.topics_not_received())}")
        return self

    def __exit__(self, *problem: object) -> None:
        self.shutdown()
