"""A node that sees the graph for as long as it is used."""

from __future__ import annotations

import os
from typing import Any

import rclpy

from ros2cli.node import NODE_NAME_PREFIX


class DirectNode:
    """A hidden node; a context manager, with all that an rclpy node has.

    Args:
        args: A command's arguments; `spin_time` is how long it looks about first [s].
        node_name: Its name; a hidden one if None.
    """

    def __init__(self, args: Any = None, *, node_name: str | None = None) -> None:
        self._began = not rclpy.ok()
        if self._began:
            rclpy.init()
        name = node_name or f"{NODE_NAME_PREFIX}_{os.getpid()}"
        self.node = rclpy.create_node(name, start_parameter_services=False)
        self._look_about(getattr(args, "spin_time", None) or 0.5)

    def _look_about(self, seconds: float) -> None:
        clock = rclpy.clock.Clock(clock_type=rclpy.clock.ClockType.STEADY_TIME)
        end = clock.now() + rclpy.duration.Duration(seconds=seconds)
        while rclpy.ok() and clock.now() < end:
            rclpy.spin_once(self.node, timeout_sec=0.05)

    def __enter__(self) -> DirectNode:
        return self

    def __getattr__(self, name: str) -> Any:
        return getattr(self.node, name)

    def __exit__(self, kind: object, error: object, trace: object) -> None:
        self.node.destroy_node()
        if self._began:
            rclpy.shutdown()
