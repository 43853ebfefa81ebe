"""Offers to clients: topics or services of the graph, each with its definitions."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from rclpy.node import Node

from bringup.recording.message_definitions import message_definition
from bringup.viewing.foxglove.server import Client


def visible(found: Sequence[tuple[str, Sequence[str]]]) -> dict[str, str]:
    """Return the types of names that are not hidden."""
    return {name: types[0] for name, types in found if types and "/_" not in name}


def encoding_of(type_name: str) -> dict[str, Any]:
    """Return what is sent of how messages of a type are written."""
    return {
        "encoding": "cdr",
        "schemaName": type_name,
        "schema": message_definition(type_name),
        "schemaEncoding": "ros2msg",
    }


@dataclass
class Offers:
    """Keeps clients informed of what is there.

    Attributes:
        words: The protocol's: to offer, what is offered, its numbers.
        describe: Returns what is sent of a name and its type; raises LookupError where the type is
            not installed.
        offered: What was sent, by name and type.
    """

    node: Node
    clients: Sequence[Client]
    words: tuple[str, str, str]
    describe: Callable[[str, str], dict[str, Any]]
    offered: dict[tuple[str, str], dict[str, Any]] = field(default_factory=dict)
    _unknown: set[str] = field(default_factory=set)
    _count: int = 0

    def greet(self, client: Client) -> None:
        """Send a new client all that is offered."""
        self._send([client], list(self.offered.values()))

    def find(self, number: Any) -> dict[str, Any] | None:
        """Return what is offered by a number."""
        return next((each for each in self.offered.values() if each["id"] == number), None)

    def refresh(self, found: Mapping[str, str]) -> list[int]:
        """Offer what is new of types by name, take the rest back and return its numbers."""
        wanted = set(found.items())
        gone = [self.offered.pop(key)["id"] for key in [*self.offered] if key not in wanted]
        new = [
            offer
            for key in sorted(wanted - self.offered.keys())
            if key[1] not in self._unknown and (offer := self._offer(*key))
        ]
        op, _, numbers = self.words
        for client in self.clients if gone else ():
            client.send_message(f"un{op}", **{numbers: gone})
        if new:
            self._send(self.clients, new)
        return gone

    def _offer(self, name: str, type_name: str) -> dict[str, Any] | None:
        try:
            fields = self.describe(name, type_name)
        except LookupError as error:
            self._unknown.add(type_name)
            self.node.get_logger().warning(f"{name} is not passed on: {error}")
            return None
        self._count += 1
        self.offered[name, type_name] = {"id": self._count, **fields}
        return self.offered[name, type_name]

    def _send(self, clients: Sequence[Client], offers: list[dict[str, Any]]) -> None:
        op, what, _ = self.words
        for client in clients:
            client.send_message(op, **{what: offers})
