"""behavior_server: whatever ends a behaviour, the robot stands and the client gets the reason."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import pytest

pytest.importorskip("rclpy", reason="no ROS here")

from std_msgs.msg import Empty

from arjuna_core.ros.convert import seconds
from arjuna_core.twist import STILL
from bringup.stack import BEHAVIOR_SERVER, LOCAL_COSTMAP
from tests.helpers.nav.behaviors import KINDS, MOVING, UNKNOWN, backup, drive, spin, start
from tests.helpers.nav.navigation import CANCELED, SUCCEEDED, PlayedRobot, assert_failed

pytestmark = pytest.mark.ros
COSTMAP = "local_costmap/local_costmap"


@pytest.fixture
def robot() -> Iterator[PlayedRobot]:
    robot = PlayedRobot()
    robot.bring_up(LOCAL_COSTMAP, BEHAVIOR_SERVER)
    robot.run(0.5)
    yield robot
    robot.close()


@pytest.mark.parametrize("kind", KINDS)
def test_cancellation_stops_the_robot_at_once_and_for_good(robot: PlayedRobot, kind: str) -> None:
    goal = start(robot, kind)
    robot.run(0.8)
    assert (robot.command == STILL) == (kind == "wait")
    robot.forget()
    goal.cancel()
    assert goal.status == CANCELED
    assert seconds(goal.result.total_elapsed_time) == pytest.approx(0.8, abs=0.05)
    assert robot.command == STILL
    robot.run(1.0)
    assert all(command == STILL for command in robot.commands)


@pytest.mark.parametrize("second", KINDS)
@pytest.mark.parametrize("first", KINDS)
def test_a_new_goal_ends_the_running_one(robot: PlayedRobot, first: str, second: str) -> None:
    older = start(robot, first)
    robot.run(0.5)
    newer = start(robot, second)
    assert_failed(older, UNKNOWN[first])
    if second == "assisted_teleop":
        robot.run(0.5)
        robot.bench.publish(Empty, "/preempt_teleop", Empty())
    robot.run_until_done(newer, 10.0)
    assert newer.status == SUCCEEDED
    assert robot.command == STILL


@pytest.mark.parametrize(
    ("kind", "code"),
    [("spin", 701), ("backup", 711), ("drive_on_heading", 721), ("assisted_teleop", 731)],
)
def test_the_time_allowance_ends_a_motion(robot: PlayedRobot, kind: str, code: int) -> None:
    goal = start(robot, kind, allowance=1.0)
    robot.run_until_done(goal, 1.3)
    assert_failed(goal, code)
    assert "allowance of 1 s" in goal.result.error_msg
    assert robot.command == STILL


@pytest.mark.parametrize(
    ("kind", "code"),
    [("spin", 702), ("backup", 712), ("drive_on_heading", 722), ("assisted_teleop", 732)],
)
def test_a_pose_that_is_lost_ends_a_motion(robot: PlayedRobot, kind: str, code: int) -> None:
    goal = start(robot, kind)
    robot.run(0.5)
    robot.localized = False
    robot.run_until_done(goal, 0.6)
    assert_failed(goal, code)
    assert robot.command == STILL


@pytest.mark.parametrize("kind", MOVING)
def test_nothing_moves_without_a_costmap(robot: PlayedRobot, kind: str) -> None:
    goal = start(robot, kind)
    robot.run(0.5)
    robot.transition(COSTMAP, "deactivate")
    robot.run_until_done(goal, 0.2)
    assert_failed(goal, UNKNOWN[kind])
    assert robot.command == STILL
    robot.forget()
    assert_failed(start(robot, kind), UNKNOWN[kind])
    assert not robot.commands


def test_a_bad_goal_of_the_same_kind_stops_the_robot(robot: PlayedRobot) -> None:
    older = drive(robot, 2.0, 0.2)
    robot.run(0.8)
    assert_failed(drive(robot, 1.0, -0.2), 724)
    assert older.done
    assert robot.command == STILL
    robot.forget()
    robot.run(0.5)
    assert all(command == STILL for command in robot.commands)


@pytest.mark.parametrize(
    ("send", "code"),
    [
        (lambda robot: drive(robot, 0.5, -0.1), 724),
        (lambda robot: drive(robot, -0.5, 0.1), 724),
        (lambda robot: drive(robot, 0.5, 0.0), 724),
        (lambda robot: drive(robot, 0.5, 0.1, y=0.2), 724),
        (lambda robot: drive(robot, math.nan, 0.1), 724),
        (lambda robot: backup(robot, 0.5, 0.0), 713),
        (lambda robot: backup(robot, 0.5, 0.1, y=0.2), 713),
        (lambda robot: backup(robot, math.inf, 0.1), 713),
        (lambda robot: spin(robot, math.nan), 700),
        (lambda robot: spin(robot, math.inf), 700),
    ],
)
def test_what_makes_no_sense_is_not_begun(robot: PlayedRobot, send: Any, code: int) -> None:
    goal = send(robot)
    robot.run_until_done(goal, 0.2)
    assert_failed(goal, code)
    assert all(command == STILL for command in robot.commands)


@pytest.mark.parametrize("kind", KINDS)
def test_deactivation_stops_the_robot_and_ends_the_goal(robot: PlayedRobot, kind: str) -> None:
    goal = start(robot, kind)
    robot.run(0.5)
    robot.transition("behavior_server", "deactivate")
    assert_failed(goal, UNKNOWN[kind])
    assert robot.command == STILL
    assert not start(robot, kind).accepted
    robot.transition("behavior_server", "activate")
    robot.run(0.2)
    assert robot.command == STILL


@pytest.mark.parametrize("kind", KINDS)
def test_time_set_back_stops_the_robot_and_ends_the_goal(robot: PlayedRobot, kind: str) -> None:
    goal = start(robot, kind)
    robot.run(0.5)
    robot.bench.set_back()
    assert_failed(goal, UNKNOWN[kind])
    assert robot.command == STILL
