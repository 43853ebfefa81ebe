"""`tour`: drive to the waypoints of a file, one after the other."""

from __future__ import annotations

import argparse
from pathlib import Path

from bringup.parameters import options

EXAMPLES = ("tour guides/arjuna/waypoints.yaml",)


def configure(parser: argparse.ArgumentParser) -> None:
    options.add(parser, *options.ROBOT_CHOICE)
    parser.add_argument(
        "file", type=Path, metavar="FILE", help="YAML: 'waypoints: [[x, y, yaw], ...]'"
    )
    options.add(parser, "--timeout", help="for each [s] (%(default)g)")
    parser.add_argument(
        "--pause", type=options.positive, default=1.0, help="between two [s] (%(default)g)"
    )
    options.add(parser, "--tolerance")


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
