"""`nav`: localization and navigation of a running robot on a map, or AMCL of a log."""

from __future__ import annotations

import argparse

from bringup.parameters import options

EXAMPLES = (
    "nav --map maps/arjuna_room.yaml",
    "nav --slam",
    "nav --offline drive.mcap --map m.yaml",
)


def configure(parser: argparse.ArgumentParser) -> None:
    options.add_running(parser)
    options.add_parts(parser)
    options.add_log_options(parser, "out/amcl", "where trajectory, report and picture go")
    options.add(parser, "--seed")


def run(arguments: argparse.Namespace) -> int:
    """Navigate until stopped, or localize a log."""
    options.extend_search(arguments)
    if arguments.offline is None:
        from bringup.processes.interactive import supervise

        return supervise(arguments)
    from bringup.offline.logs import run_amcl
    from bringup.terminal import show

    show(run_amcl(arguments))
    return 0
