"""`teleop`: drive by keys."""

from __future__ import annotations

import argparse

from bringup.client.keys import PAGES
from bringup.parameters import options

EXAMPLES = ("teleop", "teleop --keys twist --speed 0.2")


def configure(parser: argparse.ArgumentParser) -> None:
    options.add(parser, *options.ROBOT_CHOICE)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.epilog = "\n\n".join(f"--keys {name}:\n{page}" for name, page in PAGES.items())
    parser.add_argument(
        "--keys", choices=sorted(PAGES), default="wasd", help="the layout (%(default)s)"
    )
    options.add(parser, "--speed", "--turn")
    options.add(
        parser, "--timeout", default=10.0, help="wait for a robot that listens [s] (%(default)g)"
    )
    parser.add_argument("--topic", default="cmd_vel", help="where the robot listens (%(default)s)")
    parser.add_argument(
        "--stamped", action="store_true", default=None, help="send TwistStamped in any case"
    )


def run(arguments: argparse.Namespace) -> int:
    """Drive until a key quits; the robot stops however this ends."""
    from bringup.client.keyboard import drive_by_keys
    from bringup.client.keys import Driving

    start = Driving(arguments.keys, arguments.speed, arguments.turn)
    drive_by_keys(start, arguments, arguments.timeout)
    return 0
