"""controller_server: drives along paths, stops at once, and says why it does not drive."""

from __future__ import annotations

import math
from typing import Any

import pytest
from geometry_msgs.msg import PointStamped
from nav2_msgs.action import FollowPath
from nav2_msgs.msg import SpeedLimit
from nav_msgs.msg import Odometry, Path

from arjuna_core.ros.convert import path_msg, poses_from_path
from arjuna_core.se2 import SE2
from arjuna_core.twist import STILL
from bringup.stack import CONTROLLER_SERVER, LOCAL_COSTMAP
from tests.helpers.nav.navigation import (
    SUCCEEDED,
    Goal,
    PlayedRobot,
    assert_failed,
    started,
)
from tests.nav.worlds import block, polyline

Result = FollowPath.Result
COSTMAP = "local_costmap/local_costmap"
CLEARANCE = 0.28


def made(**parameters: Any) -> PlayedRobot:
    return started(LOCAL_COSTMAP, CONTROLLER_SERVER, settle=0.5, controller_server=parameters)


def path(*corners: tuple[float, float], frame: str = "map") -> Path:
    return path_msg(polyline([(0.0, 0.0), *corners], 0.0), frame, 0.0)


def follow(robot: PlayedRobot, route: Path, **ids: str) -> Goal:
    return robot.send(FollowPath, "follow_path", FollowPath.Goal(path=route, **ids))


def test_a_path_is_followed_to_its_end(robot: PlayedRobot) -> None:
    plans = robot.bench.collect(Path, "/received_global_plan")
    goal = follow(robot, path((1.5, 0.0), (1.5, 1.0)))
    robot.run_until_done(goal, 20.0)
    assert (goal.status, goal.result.error_code, goal.result.error_msg) == (SUCCEEDED, 0, "")
    assert robot.pose.distance(SE2(1.5, 1.0)) < 0.15
    assert abs(robot.pose.theta) < 0.15
    assert len(plans) == 1
    assert robot.command == STILL
    distances = [each.distance_to_goal for each in goal.feedback]
    assert distances[0] == pytest.approx(2.5, abs=0.1)
    assert distances[-1] < 0.2
    assert max(each.speed for each in goal.feedback) == pytest.approx(0.4, abs=0.01)
    assert goal.feedback[0].speed > 0.0  # of the command, as in Nav2: it still stands


def test_turns_that_a_car_cannot_make_are_reported_once(capfd: pytest.CaptureFixture[str]) -> None:
    robot = made(min_turning_radius=0.6)
    for _ in range(2):
        follow(robot, path((2.0, 0.0)))
        robot.run(0.2)
    assert capfd.readouterr().err.count("controller FollowPath turns on the spot, but the") == 1


def test_a_new_path_is_taken_without_a_stop(robot: PlayedRobot) -> None:
    older = follow(robot, path((2.0, 0.0)))
    robot.run(2.0)
    assert robot.command.x > 0.3
    robot.forget()
    newer = follow(robot, path((2.0, 0.1)))
    assert_failed(older, Result.UNKNOWN, "replaced")
    robot.run(0.5)
    assert min(command.x for command in robot.commands) > 0.3
    robot.succeed(newer, 10.0)


def test_a_speed_limit_holds_at_once_outlasts_paths_and_can_be_lifted(robot: PlayedRobot) -> None:
    for limit, speed in (
        (SpeedLimit(speed_limit=0.25), 0.25),
        (SpeedLimit(speed_limit=50.0, percentage=True), 0.2),
        (SpeedLimit(speed_limit=float("nan")), 0.2),
        (SpeedLimit(speed_limit=0.25), 0.25),
        (SpeedLimit(), 0.4),
    ):
        robot.bench.publish(SpeedLimit, "/speed_limit", limit)
        follow(robot, path((3.0, 0.0)))
        robot.run(1.0)
        assert robot.command.x == pytest.approx(speed)
        robot.pose = SE2()


def not_finite() -> Path:
    route = path((1.0, 0.0))
    route.poses[2].pose.position.x = math.nan
    return route


REFUSED: list[tuple[int, Path, dict[str, str], str]] = [
    (Result.INVALID_CONTROLLER, path((1.0, 0.0)), {"controller_id": "Best"}, "FollowPath"),
    (Result.UNKNOWN, path((1.0, 0.0)), {"goal_checker_id": "Best"}, "general_goal_checker"),
    (Result.UNKNOWN, path((1.0, 0.0)), {"progress_checker_id": "Best"}, "progress_checker"),
    (Result.INVALID_PATH, Path(), {}, "0 poses"),
    (Result.INVALID_PATH, not_finite(), {}, "nan"),
    (Result.TF_ERROR, path((1.0, 0.0), frame="moon"), {}, "moon"),
]


def test_what_cannot_be_followed_fails_with_its_code(robot: PlayedRobot) -> None:
    for code, route, ids, says in REFUSED:
        robot.fail(follow(robot, route, **ids), 0.5, code, says)
    assert robot.command == STILL


def test_a_bad_path_ends_the_one_before(robot: PlayedRobot) -> None:
    older = follow(robot, path((2.0, 0.0)))
    robot.run(2.0)
    newer = follow(robot, Path())
    assert_failed(older, Result.UNKNOWN)
    assert_failed(newer, Result.INVALID_PATH)
    assert robot.command == STILL
    robot.forget()
    robot.run(1.0)
    assert not robot.commands


def test_the_robot_stops_before_what_it_sees_and_loses_patience(robot: PlayedRobot) -> None:
    block(robot.world, 6.5, 2.5, 0.2, 6.0)  # at x = 1, too wide to go round
    goal = follow(robot, path((2.0, 0.0)))
    robot.fail(goal, 15.0, Result.PATIENCE_EXCEEDED, "collision ahead at")
    assert robot.pose.x < 1.0 - CLEARANCE
    assert robot.command == STILL


@pytest.mark.parametrize("escapes", [True, False])
def test_without_tolerance_the_first_failure_is_the_last_but_for_an_escape(escapes: bool) -> None:
    robot = made(failure_tolerance=0.0, **{"escape.enabled": escapes})
    block(robot.world, 6.0, 5.2, 0.2, 0.6)
    goal = follow(robot, path((2.0, 0.0)))
    robot.run_until_done(goal, 30.0)
    if escapes:
        assert goal.status == SUCCEEDED
    else:
        assert_failed(goal, Result.NO_VALID_CONTROL)


def test_an_obstacle_that_goes_in_time_is_tolerated(robot: PlayedRobot) -> None:
    free = robot.world.data.copy()
    goal = follow(robot, path((2.0, 0.0)))
    robot.run(1.0)
    block(robot.world, 6.1, 5.2, 0.2, 0.6)
    while robot.command != STILL:
        robot.run(0.02)
    robot.world.data[:] = free
    robot.succeed(goal, 20.0)


@pytest.mark.parametrize(
    ("touch", "seconds", "code"),
    [
        (False, 9.5, Result.FAILED_TO_MAKE_PROGRESS),
        (True, 0.9, Result.PATIENCE_EXCEEDED),  # something is taken to stand ahead
    ],
)
def test_wheels_that_do_not_grip_are_no_progress(touch: bool, seconds: float, code: int) -> None:
    layer: dict[str, Any] = {COSTMAP: {"contact_layer": {"enabled": touch}}}
    robot = started(LOCAL_COSTMAP, CONTROLLER_SERVER, settle=0.5, **layer)
    robot.grips = False
    goal = follow(robot, path((2.0, 0.0)))
    robot.run(seconds)
    assert not goal.done
    robot.fail(goal, 5.0, code)
    assert robot.command == STILL


def test_a_robot_whose_pose_is_lost_stops(robot: PlayedRobot) -> None:
    goal = follow(robot, path((2.0, 0.0)))
    robot.run(1.0)
    robot.localized = False
    robot.run(0.4)
    assert robot.command == STILL
    assert not goal.done
    robot.fail(goal, 0.4, Result.TF_ERROR, "tolerance of 0.3 s")
    assert robot.command == STILL


def test_a_costmap_that_rests_stops_the_robot(robot: PlayedRobot) -> None:
    goal = follow(robot, path((2.0, 0.0)))
    robot.run(1.0)
    robot.transition(COSTMAP, "deactivate")
    robot.fail(goal, 0.5, Result.CONTROLLER_TIMED_OUT)
    assert robot.command == STILL
    assert_failed(follow(robot, path((2.0, 0.0))), Result.CONTROLLER_TIMED_OUT)


def test_a_costmap_that_has_just_started_is_waited_for() -> None:
    robot = started(LOCAL_COSTMAP, CONTROLLER_SERVER, settle=0.04)
    robot.succeed(follow(robot, path((0.5, 0.0))), 5.0)


def test_the_lookahead_point_is_shown(robot: PlayedRobot) -> None:
    shown = robot.bench.collect(PointStamped, "/lookahead_point")
    goal = follow(robot, path((1.5, 0.0), (1.5, 1.0)))
    robot.run(2.0)
    assert {each.header.frame_id for each in shown} == {"base_link"}
    distances = [math.hypot(each.point.x, each.point.y) for each in shown]
    assert distances[0] == pytest.approx(0.3, abs=0.02)  # at rest: the least
    assert distances[-1] == pytest.approx(0.6, abs=0.02)  # at speed: 1.5 s of it
    assert abs(shown[-1].point.y) < 0.05
    robot.run_until_done(goal, 20.0)
    assert len(shown) < 20.0 * robot.now


def test_the_local_plan_is_what_the_robot_drives_next(robot: PlayedRobot) -> None:
    plans = robot.bench.collect(Path, "/local_plan")
    goal = follow(robot, path((3.0, 0.0)))
    robot.run(2.0)
    assert {plan.header.frame_id for plan in plans} == {"base_link"}
    before, plan = robot.pose, poses_from_path(plans[-1])
    assert plan[0] == pytest.approx((0.0, 0.0, 0.0))
    robot.run(1.7)
    end = before @ SE2.from_array(plan[-1])
    assert robot.pose.distance(end) < 0.1
    robot.run_until_done(goal, 30.0)
    count = len(plans)
    robot.run(1.0)
    assert len(plans) == count  # nothing is driven


@pytest.mark.parametrize("stops", [True, False])
def test_zero_is_commanded_at_the_end_unless_it_is_not_to_be(stops: bool) -> None:
    robot = made(publish_zero_velocity=stops, **{"arrival.enabled": False})
    robot.succeed(follow(robot, path((1.0, 0.0))), 10.0)
    assert (robot.commands[-1] == STILL) is stops


@pytest.mark.parametrize(("least", "counts"), [(0.2, True), (0.3, False), (0.4, False)])
def test_slow_measurements_count_as_none(least: float, counts: bool) -> None:
    names = ("min_x_velocity_threshold", "min_y_velocity_threshold", "min_theta_velocity_threshold")
    node = made(**dict.fromkeys(names, least)).nodes["controller_server"]
    message = Odometry()
    moved = message.twist.twist
    moved.linear.x = moved.linear.y = moved.angular.z = -0.3
    node._on_odometry(message)
    measured = node._velocity
    assert [v != 0.0 for v in (measured.x, measured.y, measured.yaw_rate)] == [counts] * 3


@pytest.mark.parametrize("topic", ["odom", "base_controller/odom"])
def test_odometry_that_is_on_another_topic_is_named_once(
    topic: str, capfd: pytest.CaptureFixture[str]
) -> None:
    """A robot of ros2_control turned at 0.2 rad/s: its speed seemed to be 0."""
    robot = made(odom_topic=topic)
    robot.run(6.0)
    lines = [line for line in capfd.readouterr().err.splitlines() if "odometry message" in line]
    assert len(lines) == (topic != "odom")
    reason = "nobody publishes it; odometry messages are on /odom: set odom_topic"
    assert all(line.endswith(f"comes on '/base_controller/odom': {reason}") for line in lines)
