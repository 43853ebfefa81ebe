"""Counts the messages of topics as they come, undecoded."""

from __future__ import annotations

from rclpy.qos import QoSProfile, ReliabilityPolicy

from bringup.client.session import Session
from bringup.ros2.types import interface_class

_ANY = QoSProfile(depth=100, reliability=ReliabilityPolicy.BEST_EFFORT)


class Counter:
    """Counts from the last restart on."""

    def __init__(self, session: Session) -> None:
        self._session = session
        self._counts: dict[str, int] = {}

    def listen(self, topic: str) -> None:
        """Count a topic too, if somebody publishes on it and it is not counted yet."""
        client = self._session.client
        publishers = client.get_publishers_info_by_topic(topic)
        if topic in self._counts or not publishers:
            return

        def count(message: bytes) -> None:
            self._counts[topic] += 1

        self._counts[topic] = 0
        kind = interface_class(publishers[0].topic_type)
        client.create_subscription(kind, topic, count, _ANY, raw=True)

    def restart(self) -> None:
        """Start at zero again."""
        self._counts = dict.fromkeys(self._counts, 0)

    def counts(self) -> dict[str, int]:
        """Return the number of messages on each topic that is counted."""
        return dict(self._counts)
