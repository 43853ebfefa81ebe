"""An executor that is a queue: what waits runs in the order in which it came."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from functools import partial
from typing import Any

from rclpy.task import Task

from arjuna_core.errors import ArjunaError


class TransportError(ArjunaError):
    """A node or an action's end that speaks through the middleware, where nobody else does."""


class LocalExecutor:
    """What rclpy's executors are to their nodes, for nodes of the local transport.

    Attributes:
        nodes: The nodes whose callbacks run.
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
