"""`sim`: the simulated robot in its world; or a check of a robot's or world's file."""

from __future__ import annotations

import argparse

from bringup.parameters import options, robot_options


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's options."""
    options.add_node_options(parser)
    options.add_record(parser)
    options.add_supervision(parser)
    robot_options.add_options(parser)
    options.add_seed(parser)
    robot_options.add_check(parser)
    parser.add_argument(
        "--rtf",
        type=options.factor,
        metavar="FACTOR",
        help="simulated seconds per real second, 0 for as fast as it goes (1)",
    )
    where = "where the robot starts, or the nearest free place [m] (0 0)"
    parser.add_argument("--at", nargs=2, type=options.finite, metavar=("X", "Y"), help=where)
    parser.add_argument("--yaw", type=options.finite, metavar="RAD", help="its heading there (0)")


def run(arguments: argparse.Namespace) -> int:
    """Run the simulator until it is stopped, or check a file."""
    if arguments.check is not None:
        from bringup.terminal import show

        show(robot_options.check(arguments))
        return 0
    from bringup.processes.interactive import supervise

    robot_options.extend_search(arguments)
    return supervise(arguments)
