"""A node that is spun beside a test."""

from __future__ import annotations

import threading

import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node

_LOOK = 0.1  # [s] from one look whether to stop to the next


class MessagePump:
    """Spins a node in a thread of its own, from `start` to `stop`."""

    def __init__(
        self,
        node: Node,
        context: Context | None = None,
        executor: SingleThreadedExecutor | None = None,
    ) -> None:
        self._node, self._stopped = node, False
        self._context = context or rclpy.get_default_context()
        self._executor = executor or SingleThreadedExecutor(context=self._context)
        self._thread = threading.Thread(target=self._spin, daemon=True)

    def start(self) -> None:
        self._thread.start()

    def stop(self) -> None:
        self._stopped = True
        self._thread.join()

    def _spin(self) -> None:
        self._executor.add_node(self._node)
        while not self._stopped and self._context.ok():
            self._executor.spin_once(timeout_sec=_LOOK)
        self._executor.remove_node(self._node)
