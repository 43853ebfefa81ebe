"""Who publishes, listens and answers in one process, by name."""

from __future__ import annotations

import itertools
import os
from collections import defaultdict, deque
from collections.abc import Iterator
from typing import Any

import numpy as np
from unique_identifier_msgs.msg import UUID

from arjuna_core.errors import ArjunaError
from arjuna_core.ros.local.cdr import to_cdr
from arjuna_core.ros.local.executor import LocalExecutor

_WATCH = "ARJUNA_WATCH_MESSAGES"
_WATCHED = 500
"""Messages that are looked at again, so that one that is used again by its publisher is found."""


class ChangedMessageError(ArjunaError):
    """A message was changed after it was published."""


class Registry:
    """The topics and services of the nodes of one isolated process.

    Messages are delivered in the order in which they were published, to the subscriptions of a
    topic in the order in which these were made; the answer of a service is queued like a message.

    With the environment's ARJUNA_WATCH_MESSAGES set, a message that anyone changes after it was
    published is an error, raised some messages later.

    Args:
        executor: Runs what is delivered.

    Attributes:
        executor: The same.
        publishers: Each topic's, by its name, in the order in which they were made.
        subscriptions: Each topic's.
        services: Each service's.
        timers: Those of all nodes.
        problem: Why the message that is delivered now cannot be used; None if it can.
        trusted: Whether a node of ours made what is handled now, a message or a request.
        watching: Whether messages are looked at again.
        now: The process's time [s].
    """

    def __init__(self, executor: LocalExecutor) -> None:
        self.executor = executor
        self.publishers: defaultdict[str, list[Any]] = defaultdict(list)
        self.subscriptions: defaultdict[str, list[Any]] = defaultdict(list)
        self.services: defaultdict[str, list[Any]] = defaultdict(list)
        self.timers: list[Any] = []
        self._numbers, self._goals = itertools.count(1), itertools.count(1)
        self.problem: str | None = None
        self.trusted = False
        self.now = 0.0
        self.watching = bool(os.environ.get(_WATCH))
        self._watched: deque[tuple[str, Any, bytes]] = deque()

    def topics(self) -> Iterator[tuple[str, list[Any]]]:
        """Yield each topic that somebody publishes or listens to, and their ends, by name."""
        for name in sorted({*self.publishers, *self.subscriptions}):
            ends = [*self.publishers[name], *self.subscriptions[name]]
            if ends:
                yield name, ends

    def run_timers(self) -> None:
        """Queue the callbacks of the timers whose time has come."""
        for timer in self.timers:
            timer.run_due()

    def new_uuid(self) -> UUID:
        """Return a goal's id, by its number in the process, so that runs are the same."""
        number = next(self._goals).to_bytes(16, "big")
        return UUID(uuid=np.frombuffer(number, np.uint8))

    def message_info(self, count: int) -> dict[str, int]:
        """Return the numbers of a message, of which rclpy's raw subscriptions tell.

        Args:
            count: Its publisher's number of it.
        """
        number = next(self._numbers)
        return {
            "publication_sequence_number": count,
            "received_timestamp": number,
            "source_timestamp": number,
        }

    def watch(self, topic: str, message: Any) -> None:
        """Note a message that was sent.

        Raises:
            ChangedMessageError: An earlier one is not as it was.
        """
        self._watched.append((topic, message, to_cdr(message)))
        if len(self._watched) > _WATCHED:
            changed, earlier, data = self._watched.popleft()
            if to_cdr(earlier) != data:
                raise ChangedMessageError(f"a message of '{changed}' was changed after it was sent")
