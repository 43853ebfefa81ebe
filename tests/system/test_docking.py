"""Docking and undocking of the whole robot, simulated, in lock-step."""

from __future__ import annotations

import math
from typing import Any

import pytest
from action_msgs.msg import GoalStatus
from geometry_msgs.msg import PoseStamped
from nav2_msgs.action import DockRobot, UndockRobot

from arjuna_core.ros import qos
from arjuna_core.ros.convert import pose_stamped
from arjuna_core.se2 import SE2, wrap
from bringup.lockstep import LockStep
from bringup.stack import LOCALIZATION_GROUP, NAVIGATION_GROUP
from tests.helpers.robots import ON_MAP, Stack, outcome, truth

pytestmark = [pytest.mark.ros, pytest.mark.system]
NEAR, TURNED = 0.02, math.radians(2.0)
DOCK = SE2(1.5, 0.6, 0.4)
SEEN = {
    "simple_charging_dock.use_external_detection_pose": True,
    "simple_charging_dock.external_detection_translation_x": 0.0,
    "simple_charging_dock.external_detection_rotation_roll": 0.0,
    "simple_charging_dock.external_detection_rotation_pitch": 0.0,
    "docks": ["home"],
    "home.type": "simple_charging_dock",
    "home.pose": [DOCK.x + 0.05, DOCK.y - 0.05, DOCK.theta + 0.05],  # as maps err
}
PARAMETERS: dict[str, dict[str, Any]] = {
    **ON_MAP,
    "docking_server": SEEN,
}


def show_the_dock(robot: LockStep) -> None:
    """Publish ten times a second where the dock is, seen from the robot."""
    publisher = robot.client.create_publisher(PoseStamped, "detected_dock_pose", qos.LATEST)
    ticks = 0

    def tick() -> None:
        nonlocal ticks
        ticks += 1
        if ticks % 5 == 0:
            seen = truth(robot).inverse() @ DOCK
            publisher.publish(pose_stamped(seen, "base_footprint", robot.now))

    robot.on_tick = tick


def run(robot: LockStep, action: Any, name: str, goal: Any) -> Any:
    """Send a goal; return its end, once the robot stands."""
    ended = outcome(robot, action, name, goal, 90.0)
    robot.run(0.5)
    return ended


def assert_at(pose: SE2, goal: SE2) -> None:
    assert pose.distance(goal) < NEAR
    assert abs(wrap(pose.theta - goal.theta)) < TURNED


def test_it_docks_where_the_dock_is_seen(stack: Stack) -> None:
    robot = stack(LOCALIZATION_GROUP, NAVIGATION_GROUP, parameters=PARAMETERS)
    robot.run(1.0)
    show_the_dock(robot)
    docked = run(robot, DockRobot, "dock_robot", DockRobot.Goal(dock_id="home"))
    assert docked.status == GoalStatus.STATUS_SUCCEEDED, docked.result.error_msg
    assert (docked.result.success, docked.result.error_code) == (True, 0)
    assert_at(truth(robot), DOCK)
    stood = truth(robot)
    undocked = run(robot, UndockRobot, "undock_robot", UndockRobot.Goal())
    assert undocked.status == GoalStatus.STATUS_SUCCEEDED, undocked.result.error_msg
    assert_at(truth(robot), stood @ SE2(-0.7, 0.0, 0.0))
