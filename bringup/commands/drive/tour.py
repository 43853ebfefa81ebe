"""`tour`: drive to the way-points of a file, one after the other."""

from __future__ import annotations

import argparse
from pathlib import Path

from bringup.parameters.options import add_robot_choice, positive


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's options."""
    add_robot_choice(parser)
    parser.add_argument(
        "file", type=Path, metavar="FILE", help="YAML: 'waypoints: [[x, y, yaw], ...]'"
    )
    parser.add_argument(
        "--timeout", type=positive, default=600.0, help="for each [s] (%(default)g)"
    )
    parser.add_argument("--pause", type=positive, default=1.0, help="between two [s] (%(default)g)")
    parser.add_argument(
        "--tolerance",
        type=positive,
        default=0.3,
        metavar="M",
        help="how far from it the robot may stand in the end [m] (%(default)g)",
    )


def run(arguments: argparse.Namespace) -> int:
    """Drive the tour; return 0 where all were reached, 1 where not."""
    from bringup.client.robot import Robot
    from bringup.client.waypoints import Tour, load_waypoints
    from bringup.terminal import show

    waypoints = load_waypoints(arguments.file)
    with Robot(namespace=arguments.namespace) as robot:
        limits = arguments.timeout, arguments.pause, arguments.tolerance
        reached = Tour(robot, show).drive(waypoints, *limits)
    return 0 if reached == len(waypoints) else 1
