"""The sliders of a `joint_state_publisher_gui`: positions that a person chooses."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rclpy.node import Node
from sensor_msgs.msg import JointState

from arjuna_core.ros import qos

TOPIC = "joint_state_publisher_gui/positions"
"""On which the program hears of them."""


class JointSliders:
    """Publishes positions of joints where a program waits for them."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self._out: Any = None

    def look(self) -> bool:
        """Return whether a program listens, and advertise the topic then."""
        topic = self._node.resolve_topic_name(TOPIC)
        wanted = bool(self._node.count_subscribers(topic))
        if wanted and self._out is None:
            self._out = self._node.create_publisher(JointState, TOPIC, qos.DEFAULT)
        return wanted

    def put(self, positions: Mapping[str, float]) -> None:
        """Publish joints' positions [rad or m]."""
        self._out.publish(JointState(name=list(positions), position=list(positions.values())))
