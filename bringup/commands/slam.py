"""`slam`: slam_toolbox and map_saver on a running robot; or SLAM on a log."""

from __future__ import annotations

import argparse
from pathlib import Path

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
    group = options.add_log_options(
        parser, "out/slam", "where map, trajectory, report and picture go"
    )
    group.add_argument(
        "--relations", type=Path, metavar="FILE", help="reference relations to compare with"
    )


def run(arguments: argparse.Namespace) -> int:
    """Map until stopped, or map a log."""
    if arguments.offline is None:
        from bringup.processes.interactive import supervise

        robot_options.extend_search(arguments)
        return supervise(arguments)
    from bringup.offline import slam
    from bringup.terminal import show

    show(slam.run(arguments))
    return 0
