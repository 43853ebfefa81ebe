"""`explore`: drive to the edges of the map until all is seen."""

from __future__ import annotations

import argparse

from bringup.parameters.options import add_node_options, add_robot_choice, positive


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's options."""
    add_node_options(parser)
    add_robot_choice(parser)
    parser.add_argument("--base-frame", metavar="FRAME", help="of the robot (base_footprint)")
    parser.add_argument(
        "--timeout", type=positive, default=1800.0, help="give up after [s] (%(default)g)"
    )


def run(arguments: argparse.Namespace) -> int:
    """Explore; return 0 where all was seen, 1 where the time is over."""
    from bringup.parameters.inputs import gather
    from bringup.processes.host import run_until_done
    from bringup.stack import EXPLORER_GROUP
    from bringup.terminal import show

    done = run_until_done(EXPLORER_GROUP, gather(arguments, ask=True), arguments)
    show("explored" if done else "ended before all was seen")
    return 0 if done else 1
