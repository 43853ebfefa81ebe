"""`sim`: the simulated robot in its world; or a check of a robot's or world's file."""

from __future__ import annotations

import argparse

from bringup.parameters import fleet_options, options, robot_options

_SEVERAL = """Several robots in one world: give --namespace again for each, and --at, --yaw and
--robot in the same order. Each is driven and seen below its own namespace, as
`nav --namespace NAME` takes it; one that is spawned while it runs too."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's options."""
    parser.epilog = _SEVERAL
    options.add_node_options(parser)
    options.add_record(parser)
    options.add_supervision(parser, fleet_options.Each)
    robot_options.add_options(parser, fleet_options.Each)
    fleet_options.add_start(parser)
    options.add_seed(parser)
    parser.set_defaults(use_sim_time=True)
    robot_options.add_check(parser)
    parser.add_argument(
        "--viewer",
        action="store_true",
        help="show the world in MuJoCo's own viewer, where there is a screen",
    )
    parser.add_argument(
        "--rtf",
        type=options.factor,
        metavar="FACTOR",
        help="simulated seconds per real second, 0 for as fast as it goes (1)",
    )


def run(arguments: argparse.Namespace) -> int:
    """Run the simulator until it is stopped, or check a file."""
    if arguments.check is not None:
        from bringup.terminal import show

        show(robot_options.check(arguments))
        return 0
    from bringup.processes.interactive import supervise

    fleet_options.one_process(arguments)
    robot_options.extend_search(arguments)
    return supervise(arguments)
