"""velocity_smoother: between who commands and who drives."""

from __future__ import annotations

import pytest
from geometry_msgs.msg import Twist, TwistStamped
from nav_msgs.msg import Odometry

from arjuna_core.ros.convert import header, seconds, time_msg
from arjuna_core.twist import STILL
from bringup.stack import VELOCITY_SMOOTHER
from tests.helpers.nav.navigation import PlayedRobot, started

SMOOTHER = {
    "cmd_vel_out_topic": "cmd_vel",
    "max_accel": [2.5, 0.0, 3.2],
}


def made() -> PlayedRobot:
    return started(VELOCITY_SMOOTHER, settle=0.5, velocity_smoother=SMOOTHER)


def command(robot: PlayedRobot, v: float) -> None:
    message = Twist()
    message.linear.x = v
    robot.bench.publish(Twist, "/cmd_vel_nav", message)


def test_a_command_is_followed_smoothly_until_it_ceases(robot: PlayedRobot) -> None:
    assert not robot.commands
    command(robot, 0.4)
    robot.run(0.5)
    speeds = [each.x for each in robot.commands]
    assert speeds == sorted(speeds)
    assert speeds[0] < 0.2
    assert speeds[-1] == pytest.approx(0.4)
    robot.run(1.5)
    assert robot.command == STILL
    robot.forget()
    robot.run(1.0)
    assert not robot.commands


def test_a_stop_is_passed_on_without_time_passing(robot: PlayedRobot) -> None:
    command(robot, 0.3)
    robot.run(0.5)
    command(robot, 0.0)
    assert robot.command == STILL


@pytest.mark.parametrize("how", ["deactivate", "set_back"])
def test_the_robot_is_stopped_at_once(robot: PlayedRobot, how: str) -> None:
    command(robot, 0.4)
    robot.run(0.5)
    if how == "set_back":
        robot.bench.set_back()
    else:
        robot.transition("velocity_smoother", "deactivate")
    assert robot.command == STILL
    robot.forget()
    robot.bench.advance(1.0)
    assert not robot.commands


@pytest.mark.parametrize(("duration", "first"), [(0.0, 0.325), (1.0, 0.225)])
def test_what_is_measured_is_a_mean_over_a_duration(duration: float, first: float) -> None:
    values = {**SMOOTHER, "feedback": "CLOSED_LOOP", "odom_duration": duration}
    robot = started(VELOCITY_SMOOTHER, settle=0.5, velocity_smoother=values)
    for x in (0.0, 0.2):  # the robot's own odometry says that it stands
        odometry = Odometry()
        odometry.header.stamp = time_msg(robot.now + 5.0 + x)
        odometry.twist.twist.linear.x = x
        robot.bench.publish(Odometry, "/odom", odometry)
    command(robot, 0.5)
    assert robot.command.x == pytest.approx(first)


@pytest.mark.parametrize("own", [False, True])
def test_stamps_are_the_commands_or_those_of_smoothing(own: bool) -> None:
    values = {
        **SMOOTHER,
        "enable_stamped_cmd_vel": True,
        "cmd_vel_out_topic": "smoothed",
        "stamp_smoothed_velocity_with_smoothing_time": own,
    }
    robot = started(VELOCITY_SMOOTHER, settle=0.5, velocity_smoother=values)
    smoothed = robot.bench.collect(TwistStamped, "/smoothed")
    message = TwistStamped(header=header("base_link", 0.3))
    message.twist.linear.x = 0.3
    robot.bench.publish(TwistStamped, "/cmd_vel_nav", message)
    robot.run(2.0)
    stamps = [seconds(each.header.stamp) for each in smoothed]
    assert (0.3 in stamps) is not own
    assert stamps[0] == pytest.approx(0.5 if own else 0.3)
    assert stamps[-1] > 1.5  # nobody commands any more


def test_the_type_that_alone_is_published_is_taken(robot: PlayedRobot) -> None:
    """A command that is TwistStamped, in a file without `enable_stamped_cmd_vel`, was not heard."""
    message = TwistStamped()
    message.twist.linear.x = 0.3
    robot.bench.publish(TwistStamped, "/cmd_vel_nav", message)
    robot.run(5.0)  # a look at who publishes is each 2 s, and the types follow each other
    assert not robot.commands
    robot.bench.publish(TwistStamped, "/cmd_vel_nav", message)
    robot.run(0.5)
    assert robot.command.x == pytest.approx(0.3)
