"""The transport of one process: a queue that is its executor, and who publishes and answers."""

from __future__ import annotations

import itertools
import os
from collections import defaultdict, deque
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np
from rclpy.task import Task
from unique_identifier_msgs.msg import UUID

from arjuna_core.errors import ArjunaError
from arjuna_core.ros.local.cdr import to_cdr


class TransportError(ArjunaError):
    """A node or an action's end that speaks through the middleware, where nobody else does."""


class LocalExecutor:
    """The counterpart of rclpy's executors for nodes of the local transport.

    Attributes:
        put: Takes a callable without arguments, to be run when it is its turn.
    """

    def __init__(self) -> None:
        self.nodes: set[Any] = set()
        self._queue: deque[Callable[[], Any]] = deque()
        self._suspended: list[Task[Any]] = []
        self.put = self._queue.append

    def add_node(self, node: Any) -> None:
        """Run a node's callbacks from now on.

        Raises:
            TransportError: The node speaks through the middleware.
        """
        if getattr(node, "transport", None) is None:
            raise TransportError(
                f"'{node.get_name()}' is a node of rclpy's own, which nobody here would hear: "
                "make it with Process.make_node, or the robot with LockStep(transport='dds')"
            )
        if node not in self.nodes:
            self.nodes.add(node)
            node.executor = self

    def remove_node(self, node: Any) -> None:
        """Run a node's callbacks no more."""
        self.nodes.discard(node)

    def create_task(self, callback: Callable[..., Any], *args: Any, **named: Any) -> Task[Any]:
        """Queue a function or coroutine; the task returned says when it is done."""
        task: Task[Any] = Task(callback, args, named, executor=self)
        self.put(partial(self._run, task))
        return task

    def _run(self, task: Task[Any]) -> None:
        """Run a task, or a coroutine up to where it waits."""
        task()
        if not (task.done() or task.cancelled()):
            self._suspended.append(task)
        elif task.exception() is not None:
            raise task.exception()

    def spin_once(self, timeout_sec: float | None = None) -> None:
        """Run what waits first; nothing comes from outside, so that nothing is waited for."""
        self._resume()
        if self._queue:
            self._queue.popleft()()

    def run_all(self) -> None:
        """Run what waits and all that it causes."""
        self._resume()
        queue = self._queue
        while queue:
            queue.popleft()()

    def _resume(self) -> None:
        """Let coroutines look again whether what they wait for has come."""
        suspended, self._suspended = self._suspended, []
        for task in suspended:
            self.put(partial(self._run, task))

    def __len__(self) -> int:
        """Return how much waits."""
        return len(self._queue)

    def __bool__(self) -> bool:
        """Return True: rclpy's nodes ask so whether they have an executor."""
        return True

    def wake(self) -> None:
        """Do nothing: it never sleeps."""

    def shutdown(self, timeout_sec: float | None = None) -> bool:
        """Forget what waits."""
        self._queue.clear()
        self._suspended.clear()
        return True


_WATCH = "ARJUNA_WATCH_MESSAGES"


class ChangedMessageError(ArjunaError):
    """A message was changed after it was published."""


class Registry:
    """The topics and services of the nodes of one isolated process.

    Messages are delivered in the order in which they were published, to the subscriptions of a
    topic in the order in which these were made; the answer of a service is queued like a message.

    With the environment's ARJUNA_WATCH_MESSAGES set, a message that anyone changes after it was
    published is an error, raised some messages later.

    Attributes:
        problem: Why the message that is delivered now cannot be used; None if it can.
        trusted: Whether a node of ours made what is handled now, a message or a request.
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
        """Return the numbers that rclpy gives with raw messages, for its publisher's count."""
        number = next(self._numbers)
        return {
            "publication_sequence_number": count,
            "received_timestamp": number,
            "source_timestamp": number,
        }

    def watch(self, topic: str, message: Any, depth: int = 500) -> None:
        """Note a message that was sent, and compare the one that was `depth` messages before.

        Raises:
            ChangedMessageError: An earlier one is not as it was.
        """
        self._watched.append((topic, message, to_cdr(message)))
        if len(self._watched) > depth:
            changed, earlier, data = self._watched.popleft()
            if to_cdr(earlier) != data:
                raise ChangedMessageError(f"a message of '{changed}' was changed after it was sent")


class LocalTimer:
    """The counterpart of rclpy's Timer; of several periods that pass at once one is run."""

    def __init__(
        self, registry: Registry, period: float, callback: Callable[[], Any], clock: Any
    ) -> None:
        self._registry = registry
        self._clock = clock
        self._canceled, self._waits, self._last = False, False, 0
        self.callback = callback
        self.timer_period_ns = round(period * 1e9)
        self.reset()
        registry.timers.append(self)

    def run_due(self) -> None:
        """Queue the callback if its time has come; where time was set back, start again."""
        now = self._clock.now().nanoseconds
        if now < self._last:
            self._last = now
        if not self._canceled and now - self._last >= self.timer_period_ns:
            self._last += (now - self._last) // self.timer_period_ns * self.timer_period_ns
            if not self._waits:
                self._waits = True
                self._registry.executor.put(self._call)

    def _call(self) -> None:
        self._waits = False
        if not self._canceled:
            self.callback()

    def is_canceled(self) -> bool:
        """Return whether it does not fire."""
        return self._canceled

    def cancel(self) -> None:
        """Fire no more."""
        self._canceled = True

    def reset(self) -> None:
        """Start again, now."""
        self._canceled = False
        self._last = self._clock.now().nanoseconds

    def destroy(self) -> None:
        """Leave the process."""
        self.cancel()
        if self in self._registry.timers:
            self._registry.timers.remove(self)
