"""`avoid`: drive about by itself, away from what the lidar sees."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from typing import TYPE_CHECKING

from bringup.parameters import options

if TYPE_CHECKING:
    from bringup.client.robot import Robot

EXAMPLES = ("avoid", "avoid --distance 1.0 --duration 30")


def configure(parser: argparse.ArgumentParser) -> None:
    options.add(parser, *options.ROBOT_CHOICE)
    parser.add_argument(
        "--distance", type=options.positive, default=0.7, help="that is too near [m] (%(default)s)"
    )
    options.add(parser, "--speed", "--turn")
    options.add(parser, "--duration", help="end after this time [s]; else with Ctrl-C")


def run(arguments: argparse.Namespace) -> int:
    """Drive until stopped; the robot stops however this ends."""
    from bringup.client.robot import Robot
    from bringup.terminal import show

    with Robot(namespace=arguments.namespace) as robot:
        avoid(robot, arguments, show)
    return 0


def avoid(robot: Robot, arguments: argparse.Namespace, write: Callable[[str], None]) -> None:
    """Decide at each scan and say so, until the time is over."""
    from bringup.client.avoidance import decide

    end = robot.session.now + (arguments.duration or float("inf"))
    while robot.session.now < end:
        decision = decide(robot.scan(), arguments.distance, arguments.speed, arguments.turn)
        write(str(decision))
        robot.command(decision.v, decision.w)
