"""`initial-pose`: set AMCL's initial pose."""

from __future__ import annotations

import argparse

from bringup.parameters import options

EXAMPLES = ("initial-pose 0 0", "initial-pose 2.5 1 1.57")


def configure(parser: argparse.ArgumentParser) -> None:
    options.add(parser, *options.ROBOT_CHOICE, "x", "y")
    options.add(parser, "yaw", help="heading [rad] (0)")


def run(arguments: argparse.Namespace) -> int:
    """Send the pose."""
    from bringup.client.robot import Robot
    from bringup.terminal import show

    x, y, yaw = arguments.x, arguments.y, arguments.yaw
    with Robot(namespace=arguments.namespace) as robot:
        robot.set_pose(x, y, yaw)
        show(f"sent to AMCL: ({x:.2f}, {y:.2f}), yaw {yaw:.2f}")
    return 0
