"""Messages of one topic, changed, on another: what a test does to what a node hears."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.node import Node


class DataRepublisher:
    """Publishes the messages of a topic on another one, as a function gives them back."""

    def __init__(
        self,
        node: Node,
        listen_topic: str,
        publish_topic: str,
        msg_type: Any,
        transform_fn: Callable[[Any], Any],
    ) -> None:
        """Begin.

        Args:
            node: Whoever spins it.
            transform_fn: Returns the message to publish, or None to drop it.
        """
        self._node, self._transform = node, transform_fn
        self._received = 0
        self._republished: list[Any] = []
        self._publisher = node.create_publisher(msg_type, publish_topic, 10)
        self._subscription = node.create_subscription(msg_type, listen_topic, self._take, 10)

    def shutdown(self) -> None:
        """End."""
        self._node.destroy_subscription(self._subscription)
        self._node.destroy_publisher(self._publisher)

    def get_num_received(self) -> int:
        return self._received

    def get_num_republished(self) -> int:
        return len(self._republished)

    def get_republished(self) -> list[Any]:
        """Return the messages of the topic that were not dropped, as they came."""
        return self._republished

    def _take(self, message: Any) -> None:
        self._received += 1
        changed = self._transform(message)
        if changed:
            self._republished.append(message)
            self._publisher.publish(changed)
