"""Watch over lifecycle nodes of a user's own: by their bonds, or by their answers."""

from __future__ import annotations

import time
import uuid
from collections.abc import Mapping
from typing import Any

from bond.msg import Status
from lifecycle_msgs.srv import GetState
from rclpy.node import Node
from rclpy.qos import QoSProfile


class Bonds:
    """The signs of life of nodes: heartbeats of a bond, or answers of `get_state`.

    A heartbeat is answered, so that the node's own end of the bond stays whole.

    Source: bondcpp and nav2_util, LifecycleNode::createBond, whose bonds are named as the node.
    """

    def __init__(self, node: Node, states: Mapping[str, Any]) -> None:
        self._states = dict(states)
        self._names = {name.rpartition("/")[2]: name for name in states}
        self._alive_at = dict.fromkeys(states, 0.0)
        self._asked: dict[str, Any] = {}
        self._bonded: set[str] = set()
        self._instance = str(uuid.uuid4())
        self._publisher: Any = None
        if states:
            profile = QoSProfile(depth=100)
            self._publisher = node.create_publisher(Status, "/bond", profile)
            node.create_subscription(Status, "/bond", self._on_heartbeat, profile)

    def begin(self, now: float) -> None:
        """Count all as alive at a time of the steady clock [s]."""
        self._alive_at = dict.fromkeys(self._states, now)

    def _on_heartbeat(self, message: Any) -> None:
        name = self._names.get(message.id)
        if name is not None and message.instance_id != self._instance and message.active:
            self._alive_at[name] = time.monotonic()
            self._bonded.add(name)
            reply = Status(id=message.id, instance_id=self._instance, active=True)
            reply.header.stamp = message.header.stamp
            reply.heartbeat_timeout = message.heartbeat_timeout
            reply.heartbeat_period = message.heartbeat_period
            self._publisher.publish(reply)

    def look(self, now: float) -> None:
        """Ask each node for its state, and note whose answer has come; called several times."""
        for name, client in self._states.items():
            asked = self._asked.get(name)
            if asked is not None and asked.done():
                self._alive_at[name], asked = now, None
            if not client.service_is_ready():
                asked = None
            elif asked is None:
                asked = client.call_async(GetState.Request())
            self._asked[name] = asked

    def silent(self, now: float, timeout: float, busy: float) -> list[str]:
        """Return whose last sign of life is older than a timeout [s].

        A node without a heartbeat that is still in the graph may be busy so long [s]: it answers
        between its callbacks alone.
        """

        def patience(name: str) -> float:
            answers = name not in self._bonded and self._states[name].service_is_ready()
            return max(timeout, busy) if answers else timeout

        return [name for name, at in self._alive_at.items() if now - at > patience(name)]
