"""`save-map`: write the map that is on the topic to files."""

from __future__ import annotations

import argparse
from pathlib import Path

from bringup.parameters.options import add_robot_choice, positive


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's options."""
    add_robot_choice(parser)
    parser.add_argument(
        "name", type=Path, metavar="NAME", help="path without suffix: NAME.pgm, NAME.yaml"
    )
    parser.add_argument(
        "--timeout", type=positive, default=10.0, help="wait for a map for [s] (%(default)g)"
    )


def run(arguments: argparse.Namespace) -> int:
    """Save the map."""
    from bringup.client.robot import Robot
    from bringup.terminal import show

    with Robot(arguments.timeout, arguments.namespace) as robot:
        show(f"saved {robot.save_map(arguments.name)}")
    return 0
