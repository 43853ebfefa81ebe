"""`nav`: AMCL and navigation of a running robot; or AMCL on a log."""

from __future__ import annotations

import argparse

from bringup.parameters import options, robot_options


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's options."""
    options.add_node_options(parser)
    robot_options.add_robot(parser, "whose topics, frames and outline it has: the shipped one's")
    options.add_robot_names(parser)
    options.add_record(parser)
    options.add_supervision(parser)
    options.add_resume(parser)
    options.add_maps_folder(parser)
    options.add_clock(parser)
    options.add_parts(parser)
    options.add_log_options(parser, "out/amcl", "where trajectory, report and picture go")
    options.add_seed(parser)


def run(arguments: argparse.Namespace) -> int:
    """Navigate until stopped, or localize a log."""
    if arguments.offline is None:
        from bringup.processes.interactive import supervise

        robot_options.extend_search(arguments)
        return supervise(arguments)
    from bringup.offline import amcl
    from bringup.terminal import show

    show(amcl.run(arguments))
    return 0
