"""`initial-pose`: tell AMCL where the robot is."""

from __future__ import annotations

import argparse

from bringup.parameters.options import add_robot_choice, finite


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's options."""
    add_robot_choice(parser)
    parser.add_argument("x", type=finite, metavar="X", help="of the map [m]")
    parser.add_argument("y", type=finite, metavar="Y", help="of the map [m]")
    parser.add_argument(
        "yaw", nargs="?", type=finite, default=0.0, metavar="YAW", help="heading [rad] (0)"
    )


def run(arguments: argparse.Namespace) -> int:
    """Send the pose."""
    from bringup.client.robot import Robot
    from bringup.terminal import show

    x, y, yaw = arguments.x, arguments.y, arguments.yaw
    with Robot(namespace=arguments.namespace) as robot:
        robot.set_pose(x, y, yaw)
        show(f"told AMCL: ({x:.2f}, {y:.2f}), yaw {yaw:.2f}")
    return 0
