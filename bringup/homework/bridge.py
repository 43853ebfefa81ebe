"""The pipe between grader and program: lines of JSON, and topics whose messages go through it."""

from __future__ import annotations

import base64
import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, replace
from typing import Any

from rclpy.qos import QoSProfile

from arjuna_core.bags.topic import TopicQos
from arjuna_core.ros.context import class_of
from arjuna_core.ros.local.reading import reader
from arjuna_core.ros.qos import profile_of, qos_of

Message = dict[str, Any]
Topic = dict[str, Any]
"""A topic: its `name`, `type` and `qos`, the fields of TopicQos."""


def line_of(message: Message) -> bytes:
    """Return a message as a line."""
    return json.dumps(message).encode() + b"\n"


def topic_of(name: str, kind: str, profile: QoSProfile) -> Topic:
    """Return what the other end needs to know of a topic."""
    return {"name": name, "type": kind, "qos": asdict(qos_of(profile))}


class Bridge:
    """One end of the topics that go through the pipe.

    Args:
        node: Of the local transport, and not spun: what it hears waits until it is taken.
        out: What is received here and goes to the other end.
        into: What comes from there and is published here.
    """

    def __init__(self, node: Any, out: Iterable[Topic], into: Iterable[Topic]) -> None:
        self._received = [
            node.create_subscription(*_named(one), _nothing, _profile(one), raw=True) for one in out
        ]
        self._publishers = {
            one["name"]: (node.create_publisher(*_named(one), _profile(one)), reader(_kind(one)))
            for one in into
        }

    def take(self) -> list[list[str]]:
        """Return what was received since the last time: names, and bytes in base 64."""
        found = []
        for one in self._received:
            while (taken := one.take_message(one.msg_type, True)) is not None:
                found.append([one.topic_name, base64.b64encode(taken[0]).decode()])
        return found

    def give(self, messages: Sequence[Any]) -> dict[str, list[Any]]:
        """Publish what came from the other end; return it by topic.

        Raises:
            ValueError: It is none of the topics', or no message.
        """
        found: dict[str, list[Any]] = {}
        for name, text in messages:
            if name not in self._publishers:
                raise ValueError(f"'{name}' is no topic of this homework")
            publisher, message_of = self._publishers[name]
            message = message_of(base64.b64decode(text, validate=True))
            publisher.publish(message)
            found.setdefault(name, []).append(message)
        return found


def _kind(topic: Mapping[str, Any]) -> Any:
    return class_of(topic["type"])


def _named(topic: Mapping[str, Any]) -> tuple[Any, str]:
    return _kind(topic), topic["name"]


def _profile(topic: Mapping[str, Any]) -> QoSProfile:
    wanted = TopicQos(**topic["qos"])
    return profile_of(replace(wanted, depth=max(wanted.depth, 1)))


def _nothing(message: Any) -> None:
    """Take nothing: what waits is taken when time passes."""
