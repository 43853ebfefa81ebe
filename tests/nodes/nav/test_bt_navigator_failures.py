"""bt_navigator: what goes wrong ends in a recovery or an error code, and the robot stands."""

from __future__ import annotations

import math
import re

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped, Quaternion, Vector3
from sensor_msgs.msg import Imu
from tf2_msgs.msg import TFMessage

from arjuna_core.ros import qos
from arjuna_core.ros.convert import transform_msg
from arjuna_core.se2 import SE2
from arjuna_core.twist import STILL
from tests.helpers.nav.navigation import CANCELED, SUCCEEDED, PlayedRobot, assert_failed
from tests.helpers.nav.navigator_goals import (
    GOAL,
    IN_BOX,
    IN_RING,
    TOLERANCE,
    assert_stopped_for_good,
    broken,
    drive,
    go,
    made,
    stamped,
    through,
)
from tests.nav.worlds import block

BAD: list[tuple[SE2 | PoseStamped, int]] = [
    (SE2(9.0, 0.0), 204),
    (IN_BOX, 206),
    (stamped(GOAL, "moon"), 202),
    (broken(), 202),
]


def message_of(diagnostics: DiagnosticArray, node: str) -> str:
    """Return a node's diagnostic message."""
    return next(
        str(each.message) for each in diagnostics.status if each.name.startswith(f"{node}:")
    )


@pytest.mark.parametrize("says_so", [True, False])
def test_goals_of_a_robot_that_has_overturned_end(
    robot: PlayedRobot, says_so: bool, capfd: pytest.CaptureFixture[str]
) -> None:
    """Its IMU is mounted on its side, whether its frame says so or not; a bump is no fall."""
    mount = transform_msg(SE2(), "base_link", "imu_link", 0.0)
    if says_so:
        mount.transform.rotation = Quaternion(x=math.sqrt(0.5), w=math.sqrt(0.5))
    robot.bench.publish(TFMessage, "/tf_static", TFMessage(transforms=[mount]), qos.TF_STATIC)
    array = robot.bench.collect(DiagnosticArray, "/diagnostics")

    def feel(x: float, y: float, z: float, seconds: float = 0.1) -> None:
        for _ in range(round(10 * seconds)):
            message = Imu(linear_acceleration=Vector3(x=x, y=y, z=z))
            message.header.frame_id = "imu_link"
            robot.bench.publish(Imu, "imu/data", message, qos.SENSOR_PUBLISHER)
            robot.run(0.1)

    feel(0.0, 9.81, 0.0, 1.5)
    assert ("90 degrees from the start: taken for upright" in capfd.readouterr().err) is not says_so
    goal = go(robot, SE2(3.0, 1.0))
    for side in (9.81, 40.0, 9.81):
        feel(9.81 * (side > 10.0), side, 0.0)
    drive(robot)
    assert message_of(array[-1], "/bt_navigator") == "all could be used"
    feel(-9.81, 0.0, 0.0, 2.0)
    assert_failed(goal, 0)
    said = r"the robot has overturned: 'imu/data' feels it tilted by [89]\d degrees; set it on its"
    assert re.match(said, goal.result.error_msg)
    assert_stopped_for_good(robot)
    again = go(robot, SE2(3.0, 1.0))
    feel(-9.81, 0.0, 0.0)
    assert_failed(again, 0)
    robot.run(1.0)
    assert re.match(said, message_of(array[-1], "/bt_navigator"))
    feel(0.0, 9.81, 0.0, 2.0)
    robot.run_until_done(good := go(robot, GOAL), 30.0)
    assert good.status == SUCCEEDED


def test_what_no_recovery_mends_fails_at_once(robot: PlayedRobot) -> None:
    for goal, code in BAD:
        robot.fail(go(robot, goal), 0.5, code)
        assert_stopped_for_good(robot)


def test_bad_goals_leave_the_running_one_alone(robot: PlayedRobot) -> None:
    good = go(robot, SE2(3.0, 1.0))
    drive(robot)
    robot.forget()
    for goal, code in BAD:
        bad = go(robot, goal)
        robot.run(0.5)
        assert_failed(bad, code)
    assert min(command.x for command in robot.commands) > 0.1
    robot.succeed(good, 30.0)
    good = through(robot, GOAL)
    drive(robot)
    robot.forget()
    assert_failed(through(robot, SE2(0.0, 1.0), IN_BOX), 306)
    robot.run(0.5)
    assert not good.done
    assert min(command.x for command in robot.commands) > 0.1


def test_what_cannot_be_reached_fails_after_the_recoveries() -> None:
    robot = made(number_of_retries=4, wait_duration=0.5)
    goal = go(robot, IN_RING)
    robot.fail(goal, 60.0, 208)
    assert goal.feedback[-1].number_of_recoveries == 4
    rates = [command.yaw_rate for command in robot.commands]
    assert max(rates) > 0.5  # it span
    assert min(command.x for command in robot.commands) == pytest.approx(-0.15)  # backed up
    assert_stopped_for_good(robot)


def test_a_robot_that_is_shut_in_is_not_driven_and_continues_once_free(robot: PlayedRobot) -> None:
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
    robot.succeed(goal, 60.0)


def test_a_path_that_is_blocked_is_left(robot: PlayedRobot) -> None:
    goal = go(robot, SE2(2.0, 1.5))
    drive(robot)
    x, y = robot.pose.x + 5.5, robot.pose.y + 5.5
    heading = robot.pose.theta
    block(
        robot.world, x + 0.8 * math.cos(heading) - 0.2, y + 0.8 * math.sin(heading) - 0.2, 0.4, 0.4
    )
    robot.succeed(goal, 60.0)
    assert robot.pose.distance(SE2(2.0, 1.5)) < TOLERANCE


def test_goals_are_rejected_while_inactive(robot: PlayedRobot) -> None:
    robot.transition("bt_navigator", "deactivate")
    assert not go(robot, GOAL).accepted
    assert not through(robot, GOAL).accepted
    robot.bench.publish(PoseStamped, "/goal_pose", stamped(GOAL))
    robot.run(1.0)
    assert not robot.commands


def test_a_robot_that_does_not_know_its_pose_refuses() -> None:
    robot = made(start_patience=2.0)
    robot.localized = False
    robot.run(1.0)
    goal = go(robot, GOAL)
    robot.fail(goal, 2.2, 202, "3.0")
    assert "(waited for 2.0" in goal.result.error_msg


def test_a_pose_that_is_known_later_is_waited_for(robot: PlayedRobot) -> None:
    diagnostics = robot.bench.collect(DiagnosticArray, "/diagnostics")
    robot.localized = False
    robot.run(1.0)
    goal = go(robot, GOAL)
    robot.run(5.0)
    assert "stands and waits: map -> base_link" in message_of(diagnostics[-1], "/bt_navigator")
    robot.localized = True
    robot.succeed(goal, 30.0)


def test_a_goal_waiting_for_the_pose_is_replaced_and_cancelled(robot: PlayedRobot) -> None:
    robot.localized = False
    robot.run(1.0)
    diagnostics = robot.bench.collect(DiagnosticArray, "/diagnostics")
    older, newer = go(robot, GOAL), go(robot, GOAL)
    assert_failed(older, 0)
    assert not through(robot, GOAL).accepted
    newer.cancel()
    robot.run(1.1)
    assert newer.status == CANCELED
    assert "waits" not in message_of(diagnostics[-1], "/bt_navigator")
    assert_stopped_for_good(robot)


def test_a_lost_pose_stops_the_robot_until_it_is_known(robot: PlayedRobot) -> None:
    diagnostics = robot.bench.collect(DiagnosticArray, "/diagnostics")
    goal = go(robot, SE2(3.0, 1.0))
    drive(robot)
    robot.localized = False
    robot.run(0.5)
    assert robot.command == STILL
    robot.forget()
    robot.run(6.0)
    assert all(command == STILL for command in robot.commands)
    assert "stands and waits: global_costmap was last" in message_of(
        diagnostics[-1], "/bt_navigator"
    )
    robot.localized = True
    robot.succeed(goal, 30.0)
    assert "could be used" in message_of(diagnostics[-1], "/bt_navigator")


def test_a_dead_scanner_stops_the_robot(robot: PlayedRobot) -> None:
    """For a moment, or for long."""
    diagnostics = robot.bench.collect(DiagnosticArray, "/diagnostics")
    goal = go(robot, SE2(3.0, 1.0))
    for seconds in (1.0, 5.0):
        robot.sees = True
        drive(robot)
        robot.sees = False
        robot.run(0.4)
        assert robot.command == STILL
        robot.forget()
        robot.run(seconds)
        assert all(command == STILL for command in robot.commands)
    troubles = {
        s.name.partition(":")[0]: s.message
        for a in diagnostics
        for s in a.status
        if s.level == b"\x02"
    }
    assert "no scan on /scan" in troubles["/local_costmap/local_costmap"]
    assert "no scan has come on /scan for" in troubles["/collision_monitor"]
    robot.sees = True
    robot.succeed(goal, 30.0)


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
    robot = made(number_of_retries=1, outage_patience=1.0)
    goal = go(robot, SE2(3.0, 1.0))
    drive(robot)
    robot.transition(name, "deactivate")
    robot.fail(goal, 20.0, code)
    assert_stopped_for_good(robot)


def test_a_behavior_server_that_rests_does_not_end_the_goal(robot: PlayedRobot) -> None:
    robot.transition("behavior_server", "deactivate")
    robot.fail(go(robot, IN_RING), 60.0, 208)


def test_poses_that_cannot_be_passed_fail_with_codes_of_their_own(robot: PlayedRobot) -> None:
    for poses, code in (((), 309), ((GOAL, IN_BOX), 306), ((GOAL, SE2(9.0, 0.0)), 304)):
        robot.fail(through(robot, *poses), 0.5, code)
    robot.fail(through(robot, GOAL, frame="moon"), 0.5, 302)
    assert robot.command == STILL


def test_transforms_that_contradict_living_ones_end_no_goal(robot: PlayedRobot) -> None:
    diagnostics = robot.bench.collect(DiagnosticArray, "/diagnostics")
    for parent, child in (("elsewhere", "odom"), ("map", "base_link"), ("odom", "map")):
        message = TFMessage(transforms=[transform_msg(SE2(9.0), parent, child, robot.now)])
        robot.bench.publish(TFMessage, "/tf", message, qos.TF)
        robot.run(0.1)
    robot.succeed(go(robot, SE2(2.0, 1.0)), 60.0)
    said = " ".join(f"{s.message} {s.values}" for each in diagnostics for s in each.status)
    assert "frames would form a loop: map -> odom -> map" in said
