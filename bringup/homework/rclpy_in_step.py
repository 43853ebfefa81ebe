"""rclpy for a program in lock-step: its nodes, spinning and waiting, and the clocks of Python."""

from __future__ import annotations

import contextlib
import math
import threading
import time
from collections.abc import Callable, Iterable
from typing import Any

import rclpy
import rclpy.executors
import rclpy.node

import bringup.client.session
from arjuna_core.ros.local.doors import PlainNode
from arjuna_core.ros.process import Process
from bringup.client.session import POLL, Session
from bringup.homework.bridge import Bridge, Message, Topic


class Steps:
    """A process whose time is the grader's, and passes a tick at a time.

    Args:
        send: Takes a message to the grader.
        receive: Returns the grader's next one.
        listen: The topics that come from the robot.
        publish: Those that go to it; all others stay in this process.
    """

    def __init__(
        self,
        send: Callable[[Message], None],
        receive: Callable[[], Message],
        listen: Iterable[Topic],
        publish: Iterable[Topic],
    ) -> None:
        self.process = Process("program", True, True)
        robot = self.process.make_node("robot", spun=False)
        self._bridge = Bridge(robot, publish, listen)
        self._send, self._receive = send, receive
        self._thread = threading.get_ident()
        self.called = 0

    @property
    def now(self) -> float:
        """Simulated time [s]."""
        return self.process.now

    def tick(self) -> None:
        """Let a tick pass; what comes meanwhile waits."""
        if threading.get_ident() != self._thread:
            raise RuntimeError("homework runs in one thread: spin and sleep in the main one")
        self._send({"out": self._bridge.take()})
        message = self._receive()
        self.process.set_time(message["now"])
        self._bridge.give(message["in"])

    def sleep(self, duration: float) -> None:
        """Let a time pass [s]; no callback runs meanwhile."""
        end = self.now + duration
        while self.now < end - 1e-9:
            self.tick()

    def spin_once(self, timeout_sec: float | None = None) -> None:
        """Run one callback of the program, waiting up to a timeout for it [s]."""
        end = self._end(timeout_sec)
        called, executor = self.called, self.process.executor
        while self.called == called:
            if len(executor):
                executor.spin_once()
            elif self.now < end - 1e-9:
                self.tick()
            else:
                return

    def spin(self, done: Callable[[], bool] = lambda: False, timeout: float | None = None) -> None:
        """Run callbacks until something is done, or a time has passed [s]."""
        end = self._end(timeout)
        while not done() and self.now < end - 1e-9:
            self.spin_once(end - self.now if math.isfinite(end) else None)

    def _end(self, timeout: float | None) -> float:
        return math.inf if timeout is None or timeout < 0.0 else self.now + timeout

    def counted(self, callback: Callable[..., Any]) -> Callable[..., Any]:
        """Return a callback of the program that `spin_once` knows of."""

        def run(*arguments: Any) -> Any:
            self.called += 1
            return callback(*arguments)

        return run

    def install(self) -> None:
        """Take the places of rclpy's nodes, executors and functions, and of Python's clocks."""
        node, executor = _node_class(self), _executor_class(self)
        rclpy.node.Node = node
        for name in ("SingleThreadedExecutor", "MultiThreadedExecutor", "Executor"):
            setattr(rclpy.executors, name, executor)
        functions: dict[str, Callable[..., Any]] = {
            **dict.fromkeys(("init", "shutdown", "try_shutdown"), _nothing),
            "ok": lambda *_, **__: True,
            "create_node": node,
            "spin": lambda node, executor=None: self.spin(),
            "spin_once": lambda node, *, executor=None, timeout_sec=None: self.spin_once(
                timeout_sec
            ),
            "spin_until_future_complete": lambda node, future, executor=None, timeout_sec=None: (
                self.spin(future.done, timeout_sec)
            ),
        }
        for name, function in functions.items():
            setattr(rclpy, name, function)
        taken: tuple[tuple[Any, str, Any], ...] = (
            (bringup.client.session, "Connection", _session_class(self)),
            (time, "sleep", self.sleep),
        )
        for module, name, ours in taken:
            setattr(module, name, ours)
        for name in ("time", "monotonic", "perf_counter"):
            setattr(time, name, lambda: self.now)
            setattr(time, f"{name}_ns", lambda: round(self.now * 1e9))


def _nothing(*arguments: Any, **named: Any) -> Any:
    """Stand for what has nothing to do here; `with rclpy.init()` is one too."""
    return contextlib.nullcontext()


def _node_class(steps: Steps) -> type[PlainNode]:
    class Node(PlainNode):
        """A node of the program."""

        def __init__(self, node_name: str, **options: Any) -> None:
            options = {"start_parameter_services": False, **options, "enable_rosout": False}
            super().__init__(
                steps.process.transport, node_name, **{**options, "context": steps.process.context}
            )
            self._clock = steps.process.clock
            steps.process.executor.add_node(self)

        def create_subscription(
            self, msg_type: Any, topic: str, callback: Any, *options: Any, **named: Any
        ) -> Any:
            return super().create_subscription(
                msg_type, topic, steps.counted(callback), *options, **named
            )

        def create_timer(
            self, timer_period_sec: float, callback: Any, *options: Any, **named: Any
        ) -> Any:
            return super().create_timer(
                timer_period_sec, steps.counted(callback), *options, **named
            )

        def create_rate(self, frequency: float, *options: Any, **named: Any) -> Any:
            return _Rate(steps, frequency)

    return Node


class _Rate:
    """The counterpart of rclpy's Rate."""

    def __init__(self, steps: Steps, frequency: float) -> None:
        self._steps, self._period = steps, 1.0 / frequency

    def sleep(self) -> None:
        """Let the rest of the period pass, callbacks running."""
        due = (math.floor(self._steps.now / self._period + 1e-6) + 1) * self._period
        self._steps.spin(timeout=due - self._steps.now)


def _executor_class(steps: Steps) -> type[Any]:
    class Executor(contextlib.AbstractContextManager[Any]):
        """The counterpart of rclpy's executors: all nodes of the program are of one."""

        def __init__(self, *options: Any, **named: Any) -> None:
            self._nodes: list[Any] = []
            self.add_node, self.remove_node = self._nodes.append, self._nodes.remove
            self.get_nodes = lambda: self._nodes
            self.spin, self.spin_once = steps.spin, steps.spin_once
            self.shutdown = _nothing

        def spin_until_future_complete(self, future: Any, timeout_sec: float | None = None) -> None:
            steps.spin(future.done, timeout_sec)

        def __exit__(self, *error: object) -> None:
            pass

    return Executor


def _session_class(steps: Steps) -> type[Session]:
    class Connection(Session):
        """Connection by which a `Robot` of the program reaches the robot."""

        def __init__(self, *options: Any, **named: Any) -> None:
            self.client = rclpy.create_node("robot_client")

        @property
        def now(self) -> float:
            return steps.now

        def spin_once(self, timeout: float = POLL) -> None:
            steps.spin(timeout=timeout)

        def close(self) -> None:
            self.client.destroy_node()

    return Connection
