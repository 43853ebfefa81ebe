"""motion_control: a Create 3's motions end where they should, and its dock is where it began."""

from __future__ import annotations

import math
from typing import Any

import pytest
from geometry_msgs.msg import PoseStamped
from irobot_create_msgs import action
from irobot_create_msgs.msg import DockStatus
from sensor_msgs.msg import BatteryState

from arjuna_core.se2 import SE2
from arjuna_core.twist import STILL
from bringup.stack import PROGRAMS
from tests.helpers.nav.navigation import ABORTED, CANCELED, SUCCEEDED, PlayedRobot, started

NODE = PROGRAMS["irobot_create_nodes", "motion_control"]


def made(**values: Any) -> PlayedRobot:
    values = {"base_frame": "base_footprint", **values}
    return started(NODE, settle=0.5, motion_control=values)


def goal_of(robot: PlayedRobot, name: str, **fields: Any) -> Any:
    kind = getattr(action, "".join(word.capitalize() for word in name.split("_")))
    return robot.send(kind, name, kind.Goal(**fields))


def status(robot: PlayedRobot) -> Any:
    found = robot.bench.collect(DockStatus, "/dock_status")
    robot.run(0.2)
    return found[-1]


@pytest.mark.parametrize(
    ("name", "fields", "expected"),
    [
        ("drive_distance", {"distance": -0.5}, SE2(-0.5, 0.0, 0.0)),
        ("rotate_angle", {"angle": 1.57}, SE2(0.0, 0.0, 1.57)),
        (
            "drive_arc",
            {"angle": 1.57, "radius": 0.5, "translate_direction": 1},
            SE2(0.5, 0.5, 1.57),
        ),
    ],
)
def test_a_motion_ends_where_it_was_asked_to(
    robot: PlayedRobot, name: str, fields: dict[str, Any], expected: SE2
) -> None:
    goal = goal_of(robot, name, **fields)
    assert not goal_of(robot, "rotate_angle", angle=1.0).accepted  # one motion at a time
    robot.succeed(goal, 8.0)
    assert robot.pose.distance(expected) < 0.05
    assert robot.pose.theta == pytest.approx(expected.theta, abs=0.1)
    assert goal.result.pose.header.frame_id == "odom"
    assert goal.feedback[0] != goal.feedback[-1]
    assert robot.command == STILL
    assert status(robot).is_docked == (name == "rotate_angle")


def test_it_drives_to_a_position_of_odometry(robot: PlayedRobot) -> None:
    pose = PoseStamped()
    pose.header.frame_id = "odom"
    pose.pose.position.y = 0.6
    goal = goal_of(robot, "navigate_to_position", goal_pose=pose, achieve_goal_heading=True)
    robot.succeed(goal, 12.0)
    assert robot.pose.distance(SE2(0.0, 0.6, 0.0)) < 0.05
    assert [each.navigate_state for each in goal.feedback][-1] == 3


def test_it_leaves_its_dock_and_comes_back(robot: PlayedRobot) -> None:
    assert status(robot).is_docked
    refused = goal_of(robot, "dock")
    robot.run(0.2)
    assert refused.status == ABORTED
    undock = goal_of(robot, "undock")
    robot.run_until_done(undock, 10.0)
    assert (undock.status, undock.result.is_docked) == (SUCCEEDED, False)
    assert robot.pose.x == pytest.approx(-0.4, abs=0.05)
    assert abs(robot.pose.theta) == pytest.approx(math.pi, abs=0.1)
    assert not status(robot).is_docked
    dock = goal_of(robot, "dock")
    robot.run_until_done(dock, 20.0)
    assert (dock.status, dock.result.is_docked) == (SUCCEEDED, True)
    assert robot.pose.distance(SE2()) < 0.06
    assert status(robot).is_docked


def test_without_a_dock_docking_fails_and_a_motion_can_be_cancelled() -> None:
    robot = made(starts_docked=False)
    assert not status(robot).is_docked
    for name in ("dock", "undock"):
        goal = goal_of(robot, name)
        robot.run(0.1)
        assert goal.status == ABORTED
    goal = goal_of(robot, "drive_distance", distance=1.0)
    robot.run(1.0)
    goal.cancel()
    robot.run(0.1)
    assert goal.status == CANCELED
    assert robot.command == STILL


def test_its_battery_is_full_unless_the_robot_has_one(robot: PlayedRobot) -> None:
    found = robot.bench.collect(BatteryState, "/battery_state")
    robot.run(1.5)
    assert {state.percentage for state in found} == {1.0}
    robot.bench.node.create_publisher(BatteryState, "/battery_state", 10)
    found.clear()
    robot.run(2.5)
    assert len(found) <= 1
