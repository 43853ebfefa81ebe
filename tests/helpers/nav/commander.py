"""nav2_simple_commander's BasicNavigator on a robot in lock-step: where it waits, time moves."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest
from nav2_simple_commander.robot_navigator import BasicNavigator
from nav2_simple_commander.task import Task
from rclpy import node as rclpy_node

if TYPE_CHECKING:
    from bringup.lockstep import LockStep


def commander(robot: LockStep, monkeypatch: pytest.MonkeyPatch) -> BasicNavigator:
    """Return a BasicNavigator among the nodes of a robot, whose waiting steps the simulator."""
    monkeypatch.setattr(Task, "now", property(lambda task: robot.now))
    monkeypatch.setattr(Task, "spin_once", lambda task, timeout=0.0: robot.step())
    monkeypatch.setattr(Task, "settle", lambda task: robot.settle())
    monkeypatch.setattr(rclpy_node, "get_default_context", lambda: robot.process.context)
    navigator = BasicNavigator()
    robot.process.executor.add_node(navigator)
    return navigator
