"""Goals that tests send to behavior_server."""

from __future__ import annotations

from geometry_msgs.msg import Point, Twist
from nav2_msgs.action import AssistedTeleop, BackUp, DriveOnHeading, Spin, Wait

from arjuna_core.ros.convert import duration_msg
from tests.helpers.nav.navigation import Goal, PlayedRobot
from tests.nav.worlds import block

COSTMAP = "local_costmap/local_costmap"
KINDS = ("spin", "backup", "drive_on_heading", "assisted_teleop", "wait")
MOVING = KINDS[:4]
UNKNOWN = {"spin": 700, "backup": 710, "drive_on_heading": 720, "assisted_teleop": 730, "wait": 740}


def spin(robot: PlayedRobot, angle: float, allowance: float = 10.0) -> Goal:
    request = Spin.Goal(target_yaw=angle, time_allowance=duration_msg(allowance))
    return robot.send(Spin, "spin", request)


def backup(
    robot: PlayedRobot, x: float, speed: float, allowance: float = 10.0, y: float = 0.0
) -> Goal:
    request = BackUp.Goal(
        target=Point(x=x, y=y), speed=speed, time_allowance=duration_msg(allowance)
    )
    return robot.send(BackUp, "backup", request)


def drive(
    robot: PlayedRobot, x: float, speed: float, allowance: float = 10.0, y: float = 0.0
) -> Goal:
    request = DriveOnHeading.Goal(
        target=Point(x=x, y=y), speed=speed, time_allowance=duration_msg(allowance)
    )
    return robot.send(DriveOnHeading, "drive_on_heading", request)


def wait(robot: PlayedRobot, time: float) -> Goal:
    return robot.send(Wait, "wait", Wait.Goal(time=duration_msg(time)))


def teleop(robot: PlayedRobot, allowance: float = 10.0) -> Goal:
    request = AssistedTeleop.Goal(time_allowance=duration_msg(allowance))
    return robot.send(AssistedTeleop, "assisted_teleop", request)


def command(robot: PlayedRobot, v: float, w: float = 0.0) -> None:
    """Command a velocity as a person at a joystick does."""
    message = Twist()
    message.linear.x, message.angular.z = v, w
    robot.bench.publish(Twist, "/cmd_vel_teleop", message)


def start(robot: PlayedRobot, kind: str, allowance: float = 10.0) -> Goal:
    if kind == "wait":
        return wait(robot, 3.0)
    if kind == "spin":
        return spin(robot, 3.0, allowance)
    if kind == "assisted_teleop":
        goal = teleop(robot, allowance)
        command(robot, 0.2)
        return goal
    return (backup if kind == "backup" else drive)(robot, 1.0, 0.2, allowance)


def wall_ahead(robot: PlayedRobot, x: float) -> None:
    """Put a wall across the robot's path at a distance [m] from the origin."""
    block(robot.world, 5.5 + x, 4.5, 0.1, 2.0)
