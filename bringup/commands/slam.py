"""`slam`: mapping and localization of a running robot, or of a log."""

from __future__ import annotations

import argparse
from pathlib import Path

from bringup.parameters import options

EXAMPLES = (
    "slam",
    "slam --params guides/ros2/params.yaml",
    "slam --param mode:=lifelong",
    "slam --offline drive.mcap",
)


def configure(parser: argparse.ArgumentParser) -> None:
    options.add_running(parser)
    group = options.add_log_options(
        parser, "out/slam", "where map, trajectory, report and picture go"
    )
    group.add_argument(
        "--relations", type=Path, metavar="FILE", help="reference relations to compare with"
    )


def run(arguments: argparse.Namespace) -> int:
    """Map until stopped, or map a log."""
    options.extend_search(arguments)
    if arguments.offline is None:
        from bringup.processes.interactive import supervise

        return supervise(arguments)
    from bringup.offline.logs import run_slam
    from bringup.terminal import show

    show(run_slam(arguments))
    return 0
