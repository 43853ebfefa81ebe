"""Publications of Foxglove's clients, such as goals and velocities, as they serialized them."""

from __future__ import annotations

from typing import Any

from rclpy.exceptions import InvalidTopicNameException
from rclpy.node import Node

from arjuna_core.ros import qos
from bringup.viewing.foxglove.channels import message_type

_LITTLE_ENDIAN_CDR = b"\x00\x01"


class Publications:
    """A publisher for each channel that a client advertised."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self._publishers: dict[tuple[int, int], Any] = {}

    def advertise(
        self, key: tuple[int, int], topic: str, type_name: str, encoding: str
    ) -> str | None:
        """Make a publisher for a client's channel; return why that is not possible, if so.

        Args:
            type_name: `package/msg/Name` or, as in ROS 1, `package/Name`.
        """
        if encoding != "cdr":
            return f"{topic}: encoding '{encoding}' is not taken; valid: cdr"
        try:
            publisher = self._node.create_publisher(
                message_type(_full(type_name)), topic, qos.DEFAULT
            )
        except (LookupError, InvalidTopicNameException) as error:
            return f"{topic}: {error}"
        self._publishers[key] = publisher
        return None

    def unadvertise(self, key: tuple[int, int]) -> None:
        """Drop a channel's publisher."""
        publisher = self._publishers.pop(key, None)
        if publisher is not None:
            self._node.destroy_publisher(publisher)

    def publish(self, key: tuple[int, int], data: bytes) -> None:
        """Publish a message, if its channel is open and it is in CDR."""
        if key in self._publishers and data[:2] == _LITTLE_ENDIAN_CDR:
            self._publishers[key].publish(data)


def _full(type_name: str) -> str:
    """Return a type as ROS 2 writes it, of `package/Name` too."""
    package, _, name = type_name.rpartition("/")
    return type_name if "/" in package else f"{package}/msg/{name}"
