"""`goto`: drive to a pose of the map."""

from __future__ import annotations

import argparse

from bringup.parameters import options

EXAMPLES = ("goto 2 2", "goto 1.5 -1 3.14", "goto 2 2 --controller FollowPath")


def configure(parser: argparse.ArgumentParser) -> None:
    options.add(parser, *options.ROBOT_CHOICE, "x", "y")
    options.add(parser, "yaw", help="heading there [rad] (0)")
    options.add(parser, "--timeout", "--tolerance")
    parser.add_argument(
        "--controller", metavar="NAME", help="of controller_plugins, for this goal (the first)"
    )


def run(arguments: argparse.Namespace) -> int:
    """Drive there; return 0 where it was reached, 1 where not."""
    from bringup.client.goals import chosen
    from bringup.client.robot import Robot
    from bringup.client.waypoints import Progress
    from bringup.terminal import show

    x, y, yaw = arguments.x, arguments.y, arguments.yaw
    with Robot(namespace=arguments.namespace) as robot:
        show(f"Sending goal → X: {x:.2f} Y: {y:.2f} Yaw: {yaw:.2f}")
        progress = Progress(show)
        with chosen(robot.session, "controller", arguments.controller):
            end = robot.goto(x, y, yaw, arguments.timeout, progress)
        end = progress.judged(end, x, y, arguments.tolerance)
        if not end.succeeded:
            show(f"GOAL FAILED: {end.reason}")
            return 1
        show(f"GOAL REACHED{progress.arrival}")
        if end.reason:
            show(f"  {end.reason}")
    return 0
