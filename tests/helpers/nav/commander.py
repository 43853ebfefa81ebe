"""nav2_simple_commander's BasicNavigator on a robot in lock-step: where it waits, time moves."""

from __future__ import annotations

from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import pytest
from nav2_simple_commander import task
from nav2_simple_commander.robot_navigator import BasicNavigator
from rclpy import node as rclpy_node

if TYPE_CHECKING:
    from bringup.lockstep import LockStep

_FOR_EVER = 120.0  # what the original waits for for ever [s]


def commander(robot: LockStep, monkeypatch: pytest.MonkeyPatch) -> BasicNavigator:
    """Return a BasicNavigator among the nodes of a robot, whose waiting steps the simulator."""

    def spin_until_future_complete(
        node: Any, future: Any, executor: Any = None, timeout_sec: float | None = None
    ) -> None:
        robot.process.drain()
        robot.run_until(future.done, timeout_sec or _FOR_EVER, required=False)

    def spin_once(node: Any, timeout_sec: float | None = None) -> None:
        robot.step()

    spinning = SimpleNamespace(
        spin_until_future_complete=spin_until_future_complete, spin_once=spin_once
    )
    monkeypatch.setattr(task, "rclpy", spinning)
    monkeypatch.setattr(rclpy_node, "get_default_context", lambda: robot.process.context)
    navigator = BasicNavigator()
    robot.process.executor.add_node(navigator)
    return navigator
