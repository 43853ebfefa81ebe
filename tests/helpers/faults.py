"""Faults of topics, seeded, for tests and `bench faults`: what publishers say comes otherwise.

They sit in the publishers of the nodes of a process, so that all who listen meet the same fault.
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from arjuna_core.ros.local.reading import handed_over

Publish = Callable[[Any], None]


@dataclass(frozen=True)
class Fault:
    """A treatment of the messages of a topic.

    Attributes:
        drop: Share (0..1) that never comes; 1 is a dead device.
        duplicate: Share that comes twice.
        delay: How much later they come [s].
        jitter: How much later still, at random up to this [s]; it changes their order.
        frozen: Whether the first one comes again in place of each, with its old stamp.
        change: What else becomes of each; given a copy that it may change, and return.
    """

    drop: float = 0.0
    duplicate: float = 0.0
    delay: float = 0.0
    jitter: float = 0.0
    frozen: bool = False
    change: Callable[[Any], Any] | None = None


class Faults:
    """Puts faults on topics and takes them away again.

    Args:
        rng: Decides what becomes of each message.
        now: Returns the time [s].
    """

    def __init__(
        self, nodes: Iterable[Any], rng: np.random.Generator, now: Callable[[], float]
    ) -> None:
        self._nodes = list(nodes)
        self._rng = rng
        self._now = now
        self._healthy: list[tuple[Any, Publish]] = []
        self._late: list[tuple[float, int, Publish, Any]] = []

    def put(self, topic: str, fault: Fault) -> None:
        """Let a topic fail."""
        publishers = [p for node in self._nodes for p in node.publishers if p.topic_name == topic]
        if not publishers:
            topics = sorted({p.topic_name for node in self._nodes for p in node.publishers})
            raise ValueError(f"nobody publishes '{topic}'; valid: {', '.join(topics)}")
        for publisher in publishers:
            self._healthy.append((publisher, publisher.publish))
            publisher.trusted = False
            publisher.hand_over = handed_over(publisher.msg_type, trusted=False)
            publisher.publish = self._failing(publisher.publish, fault)

    def _failing(self, publish: Publish, fault: Fault) -> Publish:
        first: list[Any] = []

        def fail(message: Any) -> None:
            if fault.frozen:
                first.append(copy.deepcopy(message)) if not first else None
                message = first[0]
            if fault.change is not None:
                message = fault.change(copy.deepcopy(message))
            times = 1 + int(self._rng.random() < fault.duplicate)
            for _ in range(0 if self._rng.random() < fault.drop else times):
                wait = fault.delay + fault.jitter * float(self._rng.random())
                if wait <= 0.0:
                    publish(message)
                else:
                    due = self._now() + wait
                    self._late.append((due, len(self._late), publish, copy.deepcopy(message)))

        return fail

    def run_due(self) -> None:
        """Publish what is late and due; called after each tick."""
        due = sorted(item[:2] for item in self._late if item[0] <= self._now())
        late = {item[:2]: item for item in self._late}
        for key in due:
            _, _, publish, message = late[key]
            self._late.remove(late[key])
            publish(message)

    def clear(self) -> None:
        """Let all topics be as they were; what is late is lost."""
        for publisher, publish in reversed(self._healthy):
            publisher.publish = publish
        self._healthy.clear()
        self._late.clear()
