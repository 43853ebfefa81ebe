"""`goto`: drive to one place of the map."""

from __future__ import annotations

import argparse

from bringup.parameters.options import add_robot_choice, finite, positive


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's options."""
    add_robot_choice(parser)
    parser.add_argument("x", type=finite, metavar="X", help="of the map [m]")
    parser.add_argument("y", type=finite, metavar="Y", help="of the map [m]")
    parser.add_argument(
        "yaw", nargs="?", type=finite, default=0.0, metavar="YAW", help="heading there [rad] (0)"
    )
    parser.add_argument(
        "--timeout", type=positive, default=600.0, help="give up after [s] (%(default)g)"
    )
    parser.add_argument(
        "--tolerance",
        type=positive,
        default=0.3,
        metavar="M",
        help="how far from it the robot may stand in the end [m] (%(default)g)",
    )


def run(arguments: argparse.Namespace) -> int:
    """Drive there; return 0 where it was reached, 1 where not."""
    from bringup.client.robot import Robot
    from bringup.client.waypoints import Progress
    from bringup.terminal import show

    x, y, yaw = arguments.x, arguments.y, arguments.yaw
    with Robot(namespace=arguments.namespace) as robot:
        show(f"Sending goal → X: {x:.2f} Y: {y:.2f} Yaw: {yaw:.2f}")
        progress = Progress(show)
        end = robot.goto(x, y, yaw, arguments.timeout, progress)
        end = progress.judged(end, x, y, arguments.tolerance)
        if not end.succeeded:
            show(f"GOAL FAILED: {end.reason}")
            return 1
        show(f"GOAL REACHED{progress.arrival}")
    return 0
