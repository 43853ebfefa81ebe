"""behavior_server: turns, drives and waits as asked, and stands where it cannot."""

from __future__ import annotations

import math
from typing import Any

import pytest
from std_msgs.msg import Empty

from arjuna_core.ros.convert import seconds
from arjuna_core.se2 import SE2
from arjuna_core.twist import STILL, Velocity
from bringup.stack import BEHAVIOR_SERVER, LOCAL_COSTMAP
from tests.helpers.nav.navigation import (
    COSTMAP,
    KINDS,
    MOVING,
    SUCCEEDED,
    UNKNOWN,
    PlayedRobot,
    assert_failed,
    backup,
    command,
    drive,
    spin,
    start,
    started,
    teleop,
    wait,
)
from tests.nav.worlds import block, room


def made(**values: Any) -> PlayedRobot:
    return started(LOCAL_COSTMAP, BEHAVIOR_SERVER, settle=0.5, behavior_server=values)


@pytest.mark.parametrize("angle", [1.57, -2.5, 7.0])
def test_spin_turns_by_the_angle(robot: PlayedRobot, angle: float) -> None:
    goal = spin(robot, angle, 20.0)
    turned, last = 0.0, 0.0
    while not goal.done:
        robot.run(0.02)
        turned += (robot.pose.theta - last + math.pi) % (2.0 * math.pi) - math.pi
        last = robot.pose.theta
        assert robot.now < 25.0
    assert (goal.status, goal.result.error_code, goal.result.error_msg) == (SUCCEEDED, 0, "")
    assert turned == pytest.approx(angle, abs=0.1)
    assert robot.pose.distance(SE2()) < 0.01
    assert robot.command == STILL
    angles = [each.angular_distance_traveled for each in goal.feedback]
    assert abs(angles[-1]) == pytest.approx(abs(angle), abs=0.15)
    assert seconds(goal.result.total_elapsed_time) == pytest.approx(robot.now - 0.5, abs=0.15)


def test_backup_drives_back_the_distance(robot: PlayedRobot) -> None:
    goal = backup(robot, 0.3, 0.15)
    robot.succeed(goal, 4.0)
    assert robot.pose.x == pytest.approx(-0.3, abs=0.03)
    assert min(command.x for command in robot.commands) == pytest.approx(-0.15)
    assert goal.feedback[-1].distance_traveled == pytest.approx(0.3, abs=0.03)
    assert seconds(goal.result.total_elapsed_time) == pytest.approx(2.1, abs=0.2)
    assert robot.command == STILL


@pytest.mark.parametrize("kind", ["drive_on_heading", "backup"])
def test_a_drive_has_limits_of_its_own(kind: str) -> None:
    values = {f"{kind}.minimum_speed": 0.22}
    robot = started(LOCAL_COSTMAP, BEHAVIOR_SERVER, settle=0.5, behavior_server=values)
    (drive if kind == "drive_on_heading" else backup)(robot, 0.5, 0.1)
    robot.run(0.3)
    assert abs(robot.command.x) == pytest.approx(0.22)


@pytest.mark.parametrize(("distance", "speed"), [(0.5, 0.25), (-0.4, -0.2)])
def test_drive_on_heading_goes_both_ways(robot: PlayedRobot, distance: float, speed: float) -> None:
    robot.succeed(drive(robot, distance, speed), 4.0)
    assert robot.pose.x == pytest.approx(distance, abs=0.04)
    assert robot.command == STILL


def test_wait_stands_still_for_the_time_and_needs_nothing_else(robot: PlayedRobot) -> None:
    robot.localized = robot.sees = False
    robot.transition(COSTMAP, "deactivate")
    goal = wait(robot, 2.0)
    robot.run(1.8)
    assert not goal.done
    robot.succeed(goal, 0.4)
    assert seconds(goal.feedback[0].time_left) == pytest.approx(2.0, abs=0.15)
    assert seconds(goal.feedback[-1].time_left) < 0.2
    assert not robot.commands


def test_teleoperation_drives_as_commanded_until_it_is_ended(robot: PlayedRobot) -> None:
    goal = teleop(robot)
    robot.run(0.3)
    assert robot.command == STILL
    command(robot, 0.3, 0.4)
    robot.run(0.3)
    assert robot.command == Velocity(pytest.approx(0.3), yaw_rate=pytest.approx(0.4))  # type: ignore[arg-type]
    robot.run(1.0)
    assert robot.command == STILL  # nobody commands any more
    robot.bench.publish(Empty, "/preempt_teleop", Empty())
    robot.succeed(goal, 0.2)
    assert seconds(goal.feedback[-1].current_teleop_duration) == pytest.approx(1.6, abs=0.15)
    robot.forget()
    command(robot, 0.3)
    robot.run(0.5)
    assert not robot.commands


def test_spinning_stops_where_a_corner_would_hit() -> None:
    corners = "[[0.4, 0.1], [0.4, -0.1], [-0.4, -0.1], [-0.4, 0.1]]"
    parameters: dict[str, Any] = {COSTMAP: {"footprint": corners}}
    world = room()
    block(world, 5.2, 5.85, 0.6, 0.1)  # 0.35 m to the left
    robot = started(LOCAL_COSTMAP, BEHAVIOR_SERVER, world=world, **parameters)
    robot.fail(spin(robot, 1.57), 4.0, 703)


def test_it_moves_in_a_frame_of_its_own_and_asks_for_a_young_pose() -> None:
    values = {"local_frame": "map", "transform_tolerance": 0.1}
    robot = started(LOCAL_COSTMAP, BEHAVIOR_SERVER, behavior_server=values)
    robot.succeed(backup(robot, 0.2, 0.2), 4.0)
    goal = backup(robot, 0.4, 0.2)
    robot.run(0.2)
    robot.localized = False
    robot.fail(goal, 0.3, 712, "over the tolerance of 0.1 s")


@pytest.mark.parametrize(("first", "second"), list(zip(KINDS, (*KINDS[1:], KINDS[0]), strict=True)))
def test_a_new_goal_ends_the_running_one(robot: PlayedRobot, first: str, second: str) -> None:
    older = start(robot, first)
    robot.run(0.5)
    newer = start(robot, second)
    assert_failed(older, UNKNOWN[first])
    if second == "assisted_teleop":
        robot.run(0.5)
        robot.bench.publish(Empty, "/preempt_teleop", Empty())
    robot.succeed(newer, 10.0)
    assert robot.command == STILL


@pytest.mark.parametrize("kind", MOVING)
@pytest.mark.parametrize(("allowance", "code"), [(1.0, 1), (0.0, 2)])
def test_time_or_a_lost_pose_ends_a_motion(
    robot: PlayedRobot, kind: str, allowance: float, code: int
) -> None:
    goal = start(robot, kind, allowance=allowance)
    robot.run(0.5)
    robot.localized = allowance > 0.0
    robot.fail(goal, 0.8, UNKNOWN[kind] + code)
    assert ("allowance of 1 s" in goal.result.error_msg) is robot.localized
    assert robot.command == STILL


def test_an_old_pose_is_tolerated_where_that_is_asked() -> None:
    robot = made(transform_tolerance=100.0, cycle_frequency=25.0)
    goal = spin(robot, 1.5)
    robot.run(0.5)
    robot.localized = False
    robot.forget()
    robot.run(0.4)
    assert not goal.done
    assert len(robot.commands) == pytest.approx(10, abs=1)


@pytest.mark.parametrize("kind", MOVING)
def test_nothing_moves_without_a_costmap(robot: PlayedRobot, kind: str) -> None:
    goal = start(robot, kind)
    robot.run(0.5)
    robot.transition(COSTMAP, "deactivate")
    robot.fail(goal, 0.2, UNKNOWN[kind])
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


def test_what_makes_no_sense_is_not_started(robot: PlayedRobot) -> None:
    impossible: list[tuple[Any, int]] = [
        *((drive(robot, *wrong), 724) for wrong in [(0.5, -0.1), (-0.5, 0.1), (0.5, 0.0)]),
        (drive(robot, 0.5, 0.1, y=0.2), 724),
        (drive(robot, math.nan, 0.1), 724),
        *((backup(robot, distance, v), 713) for distance, v in [(0.5, 0.0), (math.inf, 0.1)]),
        (backup(robot, 0.5, 0.1, y=0.2), 713),
        *((spin(robot, angle), 700) for angle in (math.nan, math.inf)),
    ]
    for goal, code in impossible:
        robot.fail(goal, 0.2, code)
    assert all(command == STILL for command in robot.commands)
