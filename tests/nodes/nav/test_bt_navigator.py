"""bt_navigator: goals through all servers to the robot's wheels; every goal gets a result."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from typing import Any

import pytest

pytest.importorskip("rclpy", reason="no ROS here")

from geometry_msgs.msg import PoseStamped
from nav2_msgs.action import FollowPath, NavigateThroughPoses, NavigateToPose

from arjuna_core.ros.convert import path_msg, pose_stamped, se2_from_pose, seconds
from arjuna_core.se2 import SE2
from arjuna_core.twist import STILL
from bringup.stack import NAVIGATION_GROUP
from tests.helpers.navigation import CANCELED, SUCCEEDED, Goal, PlayedRobot, assert_failed
from tests.nav.worlds import block, polyline

pytestmark = pytest.mark.ros
GOAL = SE2(1.0, 1.0, 0.5)
TOLERANCE = 0.16
IN_BOX = SE2(4.0, -4.0)
IN_RING = SE2(-3.8, 3.8)


def made(**parameters: Any) -> PlayedRobot:
    robot = PlayedRobot({"bt_navigator": parameters})
    block(robot.world, 8.5, 0.5, 2.0, 2.0)  # a big box round IN_BOX
    for x, y, width, height in ((0.5, 8.4, 2.2, 0.1), (2.6, 8.4, 0.1, 2.2)):
        block(robot.world, x, y, width, height)  # closes off the corner of IN_RING
    robot.bring_up(*NAVIGATION_GROUP.nodes)
    robot.send_map()
    robot.run(1.0)
    return robot


@pytest.fixture
def robot() -> Iterator[PlayedRobot]:
    robot = made()
    yield robot
    robot.close()


def stamped(pose: SE2, frame: str = "map") -> PoseStamped:
    return pose_stamped(pose, frame, 0.0)


def go(robot: PlayedRobot, pose: SE2 | PoseStamped, tree: str = "") -> Goal:
    message = stamped(pose) if isinstance(pose, SE2) else pose
    request = NavigateToPose.Goal(pose=message, behavior_tree=tree)
    return robot.send(NavigateToPose, "navigate_to_pose", request)


def through(robot: PlayedRobot, *poses: SE2, frame: str = "map") -> Goal:
    request = NavigateThroughPoses.Goal(poses=[stamped(pose, frame) for pose in poses])
    return robot.send(NavigateThroughPoses, "navigate_through_poses", request)


def drive(robot: PlayedRobot) -> None:
    """Let the robot drive until it has its speed."""
    robot.run(3.0)
    assert robot.command.v > 0.2


def assert_stopped_for_good(robot: PlayedRobot) -> None:
    """Check that the robot was stopped without time passing, and stays so."""
    assert robot.command == STILL
    robot.forget()
    robot.run(1.0)
    assert all(command == STILL for command in robot.commands)


def test_a_goal_is_reached(robot: PlayedRobot) -> None:
    goal = go(robot, GOAL)
    robot.run_until_done(goal, 30.0)
    assert (goal.status, goal.result.error_code, goal.result.error_msg) == (SUCCEEDED, 0, "")
    assert robot.pose.distance(GOAL) < TOLERANCE
    assert abs(robot.pose.theta - GOAL.theta) < TOLERANCE
    assert_stopped_for_good(robot)


def test_feedback_says_how_it_goes(robot: PlayedRobot) -> None:
    begun = robot.now
    goal = go(robot, SE2(2.0, 1.0))
    robot.run_until_done(goal, 30.0)
    told = goal.feedback
    assert len(told) == pytest.approx(10.0 * (robot.now - begun), abs=4.0)
    times = [seconds(each.navigation_time) for each in told]
    assert times == sorted(times)
    assert times[-1] == pytest.approx(robot.now - begun, abs=0.2)
    distances = [each.distance_remaining for each in told[5:]]
    assert distances[0] == pytest.approx(math.hypot(2.0, 1.0), abs=0.3)
    assert distances[-1] < 0.3
    assert all(later <= earlier + 0.15 for earlier, later in itertools.pairwise(distances))
    middle = told[len(told) // 2]
    left = times[-1] - seconds(middle.navigation_time)
    assert seconds(middle.estimated_time_remaining) == pytest.approx(left, rel=0.5)
    assert se2_from_pose(told[-1].current_pose.pose).distance(robot.pose) < 0.1
    assert told[-1].current_pose.header.frame_id == "map"
    assert {each.number_of_recoveries for each in told} == {0}


def test_a_newer_goal_replaces_the_running_one_without_a_stop(robot: PlayedRobot) -> None:
    older = go(robot, SE2(3.0, 1.0))
    drive(robot)
    robot.forget()
    newer = go(robot, SE2(3.0, 1.4))
    robot.run(0.5)
    assert_failed(older, 0)
    assert "replaced by a newer goal" in older.result.error_msg
    assert min(command.v for command in robot.commands) > 0.1
    robot.run_until_done(newer, 30.0)
    assert newer.status == SUCCEEDED
    assert robot.pose.distance(SE2(3.0, 1.4)) < TOLERANCE


def test_many_goals_in_a_row_each_get_a_result(robot: PlayedRobot) -> None:
    goals = []
    for k in range(12):
        goals.append(go(robot, SE2(1.0, 0.1 * k)))
        robot.run(0.02 * (k % 3))
    robot.run_until_done(goals[-1], 30.0)
    for goal in goals[:-1]:
        assert_failed(goal, 0)
    assert goals[-1].status == SUCCEEDED
    assert robot.pose.distance(SE2(1.0, 1.1)) < TOLERANCE


@pytest.mark.parametrize("after", [0.0, 0.02, 0.1, 1.0, 3.0])
def test_cancellation_stops_the_robot_at_once_and_for_good(
    robot: PlayedRobot, after: float
) -> None:
    goal = go(robot, SE2(3.0, 1.0))
    robot.run(after)
    goal.cancel()
    assert goal.status == CANCELED
    assert_stopped_for_good(robot)
    again = go(robot, SE2(0.5, 0.0))
    robot.run_until_done(again, 30.0)
    assert again.status == SUCCEEDED


def test_a_preempting_goal_can_be_cancelled(robot: PlayedRobot) -> None:
    older = go(robot, SE2(3.0, 1.0))
    drive(robot)
    newer = go(robot, SE2(3.0, 1.5))
    newer.cancel()
    assert newer.status == CANCELED
    assert older.done
    assert_stopped_for_good(robot)


def broken() -> PoseStamped:
    message = stamped(GOAL)
    message.pose.orientation.w = message.pose.orientation.z = 0.0
    return message


@pytest.mark.parametrize(
    ("goal", "code"),
    [
        (SE2(9.0, 0.0), 204),
        (IN_BOX, 206),
        (stamped(GOAL, "moon"), 202),
        (broken(), 202),
    ],
)
def test_what_no_recovery_mends_fails_at_once(
    robot: PlayedRobot, goal: SE2 | PoseStamped, code: int
) -> None:
    sent = go(robot, goal)
    robot.run_until_done(sent, 0.5)
    assert_failed(sent, code)
    assert_stopped_for_good(robot)


def test_a_bad_goal_leaves_the_running_one_alone(robot: PlayedRobot) -> None:
    good = go(robot, GOAL)
    robot.run(1.0)
    bad = go(robot, stamped(GOAL, "moon"))
    assert_failed(bad, 202)
    robot.run_until_done(good, 30.0)
    assert good.status == SUCCEEDED


def test_what_cannot_be_reached_fails_after_the_recoveries() -> None:
    robot = made(number_of_retries=4, wait_duration=0.5)
    goal = go(robot, IN_RING)
    robot.run_until_done(goal, 60.0)
    assert_failed(goal, 208)
    assert goal.feedback[-1].number_of_recoveries == 4
    rates = [command.w for command in robot.commands]
    assert max(rates) > 0.5  # it span
    assert min(command.v for command in robot.commands) == pytest.approx(-0.15)  # backed up
    assert_stopped_for_good(robot)
    robot.close()


def test_a_robot_that_is_shut_in_is_not_driven_and_goes_on_once_free(robot: PlayedRobot) -> None:
    free = robot.world.data.copy()
    for x, y, width, height in (
        (4.9, 4.9, 1.2, 0.1),
        (4.9, 6.0, 1.2, 0.1),
        (4.9, 4.9, 0.1, 1.2),
        (6.0, 4.9, 0.1, 1.2),
    ):
        block(robot.world, x, y, width, height)
    robot.run(1.0)
    goal = go(robot, GOAL)
    robot.run(12.0)
    assert not goal.done
    assert goal.feedback[-1].number_of_recoveries > 0
    assert robot.pose.distance(SE2()) < 0.5
    robot.world.data[:] = free
    robot.run_until_done(goal, 60.0)
    assert goal.status == SUCCEEDED


def test_a_way_that_is_blocked_is_gone_round(robot: PlayedRobot) -> None:
    goal = go(robot, SE2(2.0, 1.5))
    drive(robot)
    x, y = robot.pose.x + 5.5, robot.pose.y + 5.5
    heading = robot.pose.theta
    block(
        robot.world, x + 0.8 * math.cos(heading) - 0.2, y + 0.8 * math.sin(heading) - 0.2, 0.4, 0.4
    )
    robot.run_until_done(goal, 60.0)
    assert goal.status == SUCCEEDED
    assert robot.pose.distance(SE2(2.0, 1.5)) < TOLERANCE


@pytest.mark.parametrize("topic", ["/goal_pose", "/move_base_simple/goal"])
def test_a_goal_on_a_topic_is_driven_to(robot: PlayedRobot, topic: str) -> None:
    robot.bench.publish(PoseStamped, topic, stamped(SE2(0.6, 0.3, 0.0)))
    robot.run(10.0)
    assert robot.pose.distance(SE2(0.6, 0.3)) < TOLERANCE
    assert robot.command == STILL


def test_a_goal_on_a_topic_replaces_one_of_a_client(robot: PlayedRobot) -> None:
    goal = go(robot, SE2(3.0, 1.0))
    drive(robot)
    robot.bench.publish(PoseStamped, "/goal_pose", stamped(SE2(0.5, 0.5)))
    robot.run(20.0)
    assert_failed(goal, 0)
    assert robot.pose.distance(SE2(0.5, 0.5)) < TOLERANCE


@pytest.mark.parametrize(
    ("tree", "accepted"),
    [
        ("", True),
        ("/opt/ros/jazzy/navigate_to_pose_w_replanning_and_recovery.xml", True),
        ("my_tree.xml", False),
    ],
)
def test_only_the_default_tree_is_offered(robot: PlayedRobot, tree: str, accepted: bool) -> None:
    assert go(robot, GOAL, tree).accepted == accepted


def test_goals_are_rejected_while_inactive(robot: PlayedRobot) -> None:
    robot.transition("bt_navigator", "deactivate")
    assert not go(robot, GOAL).accepted
    assert not through(robot, GOAL).accepted
    robot.bench.publish(PoseStamped, "/goal_pose", stamped(GOAL))
    robot.run(1.0)
    assert not robot.commands


@pytest.mark.parametrize("transition", ["deactivate", "shutdown"])
def test_the_end_of_activity_stops_the_robot_and_ends_the_goal(
    robot: PlayedRobot, transition: str
) -> None:
    goal = go(robot, SE2(3.0, 1.0))
    drive(robot)
    robot.transition("bt_navigator", transition)
    assert_failed(goal, 0)
    assert "deactivated" in goal.result.error_msg
    assert_stopped_for_good(robot)


def test_time_set_back_stops_the_robot_and_ends_the_goal(robot: PlayedRobot) -> None:
    goal = go(robot, SE2(3.0, 1.0))
    drive(robot)
    robot.bench.set_back()
    assert_failed(goal, 0)
    assert "set back" in goal.result.error_msg
    assert_stopped_for_good(robot)


def test_a_robot_that_does_not_know_its_place_refuses(robot: PlayedRobot) -> None:
    robot.localized = False
    robot.run(1.0)
    goal = go(robot, GOAL)
    assert_failed(goal, 202)
    assert "1.0" in goal.result.error_msg


def test_a_place_that_is_lost_under_way_stops_the_robot(robot: PlayedRobot) -> None:
    goal = go(robot, SE2(3.0, 1.0))
    drive(robot)
    robot.localized = False
    robot.run_until_done(goal, 10.0)
    assert_failed(goal, 102)
    assert_stopped_for_good(robot)


@pytest.mark.parametrize(
    ("name", "code"),
    [
        ("planner_server", 200),
        ("controller_server", 100),
        ("global_costmap/global_costmap", 207),
        ("local_costmap/local_costmap", 107),
    ],
)
def test_a_server_that_rests_ends_the_goal(name: str, code: int) -> None:
    robot = made(number_of_retries=1)
    goal = go(robot, SE2(3.0, 1.0))
    drive(robot)
    robot.transition(name, "deactivate")
    robot.run_until_done(goal, 20.0)
    assert_failed(goal, code)
    assert_stopped_for_good(robot)
    robot.close()


def test_a_behavior_server_that_rests_does_not_end_the_goal(robot: PlayedRobot) -> None:
    robot.transition("behavior_server", "deactivate")
    goal = go(robot, IN_RING)
    robot.run_until_done(goal, 60.0)
    assert_failed(goal, 208)


def test_poses_are_passed_in_turn(robot: PlayedRobot) -> None:
    stops = SE2(1.5, 1.0), SE2(0.0, 1.8), SE2(-1.2, 0.5, 2.0)
    goal = through(robot, *stops)
    nearest = [math.inf] * len(stops)
    while not goal.done:
        robot.run(0.1)
        nearest = [min(n, robot.pose.distance(s)) for n, s in zip(nearest, stops, strict=True)]
        assert robot.now < 60.0
    assert goal.status == SUCCEEDED
    assert max(nearest) < 0.5
    assert robot.pose.distance(stops[-1]) < TOLERANCE
    left = [each.number_of_poses_remaining for each in goal.feedback]
    assert (left[0], left[-1]) == (3, 1)
    assert left == sorted(left, reverse=True)


def test_poses_that_cannot_be_passed_fail_with_codes_of_their_own(robot: PlayedRobot) -> None:
    for poses, code in (((), 309), ((GOAL, IN_BOX), 306), ((GOAL, SE2(9.0, 0.0)), 304)):
        goal = through(robot, *poses)
        robot.run_until_done(goal, 0.5)
        assert_failed(goal, code)
    goal = through(robot, GOAL, frame="moon")
    assert_failed(goal, 302)
    assert robot.command == STILL


def test_going_through_poses_is_cancelled_at_once(robot: PlayedRobot) -> None:
    goal = through(robot, SE2(2.0, 1.0), SE2(0.0, 1.0))
    drive(robot)
    assert not go(robot, GOAL).accepted  # one action at a time
    goal.cancel()
    assert goal.status == CANCELED
    assert_stopped_for_good(robot)
    again = go(robot, GOAL)
    robot.run_until_done(again, 40.0)
    assert again.status == SUCCEEDED


def test_a_client_of_follow_path_is_not_disturbed_by_an_idle_navigator(robot: PlayedRobot) -> None:
    route = path_msg(polyline([(0.0, 0.0), (0.8, 0.0)], 0.0), "map", 0.0)
    goal = robot.send(FollowPath, "follow_path", FollowPath.Goal(path=route))
    robot.run_until_done(goal, 10.0)
    assert goal.status == SUCCEEDED
