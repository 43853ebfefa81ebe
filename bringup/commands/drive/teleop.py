"""`teleop`: drive by keys."""

from __future__ import annotations

import argparse

from bringup.client.keys import PAGES
from bringup.parameters.options import add_robot_choice, positive


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's options."""
    add_robot_choice(parser)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.epilog = "\n\n".join(f"--keys {name}:\n{page}" for name, page in PAGES.items())
    parser.add_argument(
        "--keys", choices=sorted(PAGES), default="wasd", help="the layout (%(default)s)"
    )
    parser.add_argument("--speed", type=positive, default=0.3, help="forward [m/s] (%(default)s)")
    parser.add_argument("--turn", type=positive, default=0.5, help="turning [rad/s] (%(default)s)")
    parser.add_argument("--topic", default="cmd_vel", help="where the robot listens (%(default)s)")
    parser.add_argument(
        "--stamped", action="store_true", default=None, help="send TwistStamped in any case"
    )


def run(arguments: argparse.Namespace) -> int:
    """Drive until told to quit; the robot stops however this ends."""
    from bringup.client.keyboard import drive_by_keys
    from bringup.client.keys import Driving

    start = Driving(arguments.keys, arguments.speed, arguments.turn)
    drive_by_keys(start, arguments)
    return 0
