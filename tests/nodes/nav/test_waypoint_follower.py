"""waypoint_follower: each waypoint in turn, rounds, misses, and at once to rest."""

from __future__ import annotations

from typing import Any

import pytest
from nav2_msgs.action import FollowWaypoints, NavigateToPose

from arjuna_core.ros.convert import pose_stamped
from arjuna_core.se2 import SE2
from arjuna_core.twist import STILL
from bringup.stack import NAVIGATION_GROUP
from tests.helpers.nav.navigation import (
    SUCCEEDED,
    Goal,
    PlayedRobot,
    assert_failed,
    started,
)

UNKNOWN = FollowWaypoints.Result.UNKNOWN
OUTSIDE = SE2(9.0, 0.0)
SQUARE = SE2(0.5, 0.0), SE2(0.5, 0.5), SE2(0.0, 0.5)


def made(**parameters: Any) -> PlayedRobot:
    return started(*NAVIGATION_GROUP.nodes, waypoint_follower=parameters)


def follow(robot: PlayedRobot, *poses: SE2, **fields: int) -> Goal:
    stamped = [pose_stamped(pose, "map", 0.0) for pose in poses]
    request = FollowWaypoints.Goal(poses=stamped, **fields)
    return robot.send(FollowWaypoints, "follow_waypoints", request)


def visited(robot: PlayedRobot, goal: Goal, timeout: float) -> list[int]:
    """Run to the goal's end; return the waypoints in the order in which they were come near to."""
    order: list[int] = []
    deadline = robot.now + timeout
    while not goal.done:
        robot.run(0.1)
        assert robot.now < deadline
        for k, pose in enumerate(SQUARE):
            if robot.pose.distance(pose) < 0.15 and order[-1:] != [k]:
                order.append(k)
    return order


def indices(goal: Goal) -> list[int]:
    """Return the waypoints that feedback names, without repetitions."""
    indices = [each.current_waypoint for each in goal.feedback]
    return [k for i, k in enumerate(indices) if indices[i - 1 : i] != [k]]


def test_waypoints_are_driven_to_in_turn(robot: PlayedRobot) -> None:
    goal = follow(robot, *SQUARE)
    assert visited(robot, goal, 40.0) == [0, 1, 2]
    assert (goal.status, goal.result.error_code, goal.result.error_msg) == (SUCCEEDED, 0, "")
    assert goal.result.missed_waypoints == []
    assert indices(goal) == [0, 1, 2]
    assert robot.command == STILL


def test_rounds_begin_where_asked(robot: PlayedRobot) -> None:
    goal = follow(robot, *SQUARE, number_of_loops=1, goal_index=1)
    robot.run_until_done(goal, 80.0)
    assert goal.status == SUCCEEDED
    assert indices(goal) == [1, 2, 0, 1, 2]


def test_a_waypoint_that_is_not_reached_ends_it_all(robot: PlayedRobot) -> None:
    goal = follow(robot, SQUARE[0], OUTSIDE, SQUARE[1])
    robot.run_until_done(goal, 30.0)
    assert_failed(goal, UNKNOWN)
    assert "waypoint 1 of 3" in goal.result.error_msg
    assert "outside the costmap" in goal.result.error_msg
    (missed,) = goal.result.missed_waypoints
    assert (missed.index, missed.error_code) == (1, 204)
    assert missed.goal.pose.position.x == OUTSIDE.x


def test_the_robot_waits_at_each_waypoint() -> None:
    robot = made(**{"wait_at_waypoint.waypoint_pause_duration": 2000})
    goal = follow(robot, SE2(0.0, 0.0), SE2(0.0, 0.0))
    robot.run(3.5)
    assert not goal.done
    robot.run_until_done(goal, 1.5)
    assert goal.status == SUCCEEDED


def test_a_newer_list_replaces_the_running_one_without_a_stop(robot: PlayedRobot) -> None:
    older = follow(robot, SE2(3.0, 1.0), *SQUARE)
    robot.run(3.0)
    robot.forget()
    newer = follow(robot, SE2(2.0, 0.8), SE2(2.5, 1.0))
    assert_failed(older, UNKNOWN)
    robot.run(0.3)
    assert min(command.x for command in robot.commands) > 0.1
    robot.run_until_done(newer, 30.0)
    assert newer.status == SUCCEEDED
    assert indices(newer) == [0, 1]


@pytest.mark.parametrize(
    ("poses", "index", "says"), [((), 0, "0 poses"), (SQUARE, 3, "no waypoint 3")]
)
def test_a_list_without_its_waypoint_is_an_error_and_leaves_the_running_one_alone(
    robot: PlayedRobot, poses: tuple[SE2, ...], index: int, says: str
) -> None:
    running = follow(robot, SE2(3.0, 1.0))
    robot.run(3.0)
    goal = follow(robot, *poses, goal_index=index)
    assert_failed(goal, UNKNOWN)
    assert says in goal.result.error_msg
    robot.run(0.5)
    assert not running.done
    assert robot.command.x > 0.2


def test_a_list_that_leads_nowhere_ends_also_what_it_was_to_replace(robot: PlayedRobot) -> None:
    running = follow(robot, SE2(3.0, 1.0))
    robot.run(3.0)
    goal = follow(robot, SE2(90.0, 0.0))
    assert_failed(running, UNKNOWN)
    assert_failed(goal, UNKNOWN)
    assert robot.command == STILL


def test_a_goal_of_someone_else_is_a_miss(robot: PlayedRobot) -> None:
    goal = follow(robot, SE2(3.0, 1.0))
    robot.run(2.0)
    request = NavigateToPose.Goal(pose=pose_stamped(SE2(0.5, 0.5), "map", 0.0))
    other = robot.send(NavigateToPose, "navigate_to_pose", request)
    assert_failed(goal, UNKNOWN)
    assert "replaced" in goal.result.error_msg
    robot.run_until_done(other, 20.0)
    assert other.status == SUCCEEDED


@pytest.mark.parametrize("transition", ["deactivate", "shutdown"])
def test_a_navigator_that_rests_or_goes_ends_it(robot: PlayedRobot, transition: str) -> None:
    goal = follow(robot, SE2(3.0, 1.0))
    robot.run(3.0)
    robot.transition("bt_navigator", transition)
    assert_failed(goal, UNKNOWN)
    again = follow(robot, SE2(1.0, 0.0))
    robot.run_until_done(again, 1.0)
    assert_failed(again, UNKNOWN)
    assert "navigate_to_pose" in again.result.error_msg
