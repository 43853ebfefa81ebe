"""bt_navigator: goals through all servers to the robot's wheels; every goal gets a result."""

from __future__ import annotations

import itertools
import math
import re

import pytest
from geometry_msgs.msg import PoseStamped

from arjuna_core.ros.convert import se2_from_pose, seconds
from arjuna_core.se2 import SE2
from arjuna_core.twist import STILL
from arjuna_nav.navigator import NavigatorConfig
from tests.helpers.nav.navigation import SUCCEEDED, Goal, PlayedRobot, assert_failed
from tests.helpers.nav.navigator_goals import (
    GOAL,
    TOLERANCE,
    assert_stopped_for_good,
    drive,
    go,
    stamped,
    through,
)


def test_goals_end_with_a_result_and_in_the_log(
    robot: PlayedRobot, capfd: pytest.CaptureFixture[str]
) -> None:
    start = robot.now
    goal = go(robot, GOAL)
    robot.run_until_done(goal, 30.0)
    assert_feedback_said_how_it_went(robot, goal, start)
    assert (goal.status, goal.result.error_code, goal.result.error_msg) == (SUCCEEDED, 0, "")
    assert robot.pose.distance(GOAL) < TOLERANCE
    assert abs(robot.pose.theta - GOAL.theta) < TOLERANCE
    assert_stopped_for_good(robot)
    robot.run_until_done(go(robot, SE2(40.0, 0.0)), 30.0)
    log = [line.split("bt_navigator]: ")[1] for line in capfd.readouterr().err.splitlines()
           if "bt_navigator]: " in line]  # fmt: skip
    assert log[0] == "navigate_to_pose: goal (1.00, 1.00, 0.50) received"
    assert re.fullmatch(r"navigate_to_pose: goal succeeded after \d+\.\d s", log[1])
    assert log[2] == "navigate_to_pose: goal (40.00, 0.00, 0.00) received"
    assert re.fullmatch(r"navigate_to_pose: goal aborted after .* s: .*", log[-1])


def assert_feedback_said_how_it_went(robot: PlayedRobot, goal: Goal, start: float) -> None:
    feedback = goal.feedback
    assert len(feedback) == pytest.approx(10.0 * (robot.now - start), abs=4.0)
    times = [seconds(each.navigation_time) for each in feedback]
    assert times == sorted(times)
    assert times[-1] == pytest.approx(robot.now - start, abs=0.2)
    distances = [each.distance_remaining for each in feedback]
    assert distances[0] == pytest.approx(math.hypot(1.0, 1.0), abs=0.3)
    assert distances[-1] < 0.3
    assert all(later <= earlier + 0.15 for earlier, later in itertools.pairwise(distances))
    middle = feedback[len(feedback) // 2]
    left = times[-1] - seconds(middle.navigation_time)
    assert seconds(middle.estimated_time_remaining) == pytest.approx(left, rel=0.5)
    assert se2_from_pose(feedback[-1].current_pose.pose).distance(robot.pose) < 0.1
    assert feedback[-1].current_pose.header.frame_id == "map"
    assert {each.number_of_recoveries for each in feedback} == {0}


def test_a_newer_goal_replaces_the_running_one_without_a_stop(robot: PlayedRobot) -> None:
    older = go(robot, SE2(3.0, 1.0))
    drive(robot)
    robot.forget()
    newer = go(robot, SE2(3.0, 1.4))
    robot.run(0.5)
    assert_failed(older, 0, "replaced by a newer goal")
    assert min(command.x for command in robot.commands) > 0.1
    robot.succeed(newer, 30.0)
    assert robot.pose.distance(SE2(3.0, 1.4)) < TOLERANCE


def test_a_goal_on_a_topic_replaces_one_of_a_client(robot: PlayedRobot) -> None:
    for topic, pose in (("/goal_pose", SE2(1.5, 1.0)), ("/move_base_simple/goal", SE2(2.0, 1.8))):
        goal = go(robot, SE2(3.0, 1.0))
        drive(robot)
        robot.bench.publish(PoseStamped, topic, stamped(pose))
        robot.run(10.0)
        assert_failed(goal, 0)
        assert robot.pose.distance(pose) < TOLERANCE
        assert robot.command == STILL


def test_poses_are_passed_in_turn(robot: PlayedRobot) -> None:
    stops = SE2(1.5, 1.0), SE2(0.0, 1.8), SE2(-1.2, 0.5, 2.0)
    goal = through(robot, *stops)
    nearest = [math.inf] * len(stops)
    while not goal.done:
        robot.run(0.1)
        nearest = [min(n, robot.pose.distance(s)) for n, s in zip(nearest, stops, strict=True)]
        assert robot.now < 60.0
    assert goal.status == SUCCEEDED
    assert max(nearest) < NavigatorConfig.passed_goal_radius
    assert robot.pose.distance(stops[-1]) < TOLERANCE
    left = [each.number_of_poses_remaining for each in goal.feedback]
    assert (left[0], left[-1]) == (3, 1)
    assert left == sorted(left, reverse=True)


def test_one_action_has_a_goal_at_a_time(robot: PlayedRobot) -> None:
    through(robot, SE2(2.0, 1.0), SE2(0.0, 1.0))
    assert not go(robot, GOAL).accepted
