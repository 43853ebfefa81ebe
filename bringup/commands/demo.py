"""`demo`: explore, map, drive waypoints, be carried off and drive home, as fast as it goes."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from arjuna_core.files.whole_file import emptied_folder
from bringup.parameters import options

if TYPE_CHECKING:
    from bringup.demo.demo import DemoOptions
    from bringup.parameters.files import Parameters

EXAMPLES = (
    "demo",
    "demo --seed 7 --out out/seven",
    "demo --robot my.urdf --world my.world --waypoints points.yaml --no-kidnap",
    "demo --scene house --goals 5 --explore-time 300 --no-kidnap",
)


def configure(parser: argparse.ArgumentParser) -> None:
    options.add(parser, *options.NODES, *options.SIMULATION, "--seed")
    parser.add_argument(
        "--waypoints",
        type=Path,
        metavar="FILE",
        help="where to drive: YAML, 'waypoints: [[x, y, yaw], ...]' (five in the room)",
    )
    parser.add_argument(
        "--goals", type=int, default=0, metavar="N", help="goals drawn on the map, in their place"
    )
    parser.add_argument("--scene", choices=options.BUILDINGS, help=options.ABOUT_BUILDINGS)
    parser.add_argument(
        "--explore-time",
        type=options.positive,
        metavar="S",
        help="after which what is mapped so far is the map [s] (all is mapped)",
    )
    parser.add_argument("--no-kidnap", action="store_true", help="do not carry the robot off")
    about = "where the report, pictures, map and recording go (%(default)s)"
    options.add(parser, "--out", default=Path("out/demo"), help=about)


def run(arguments: argparse.Namespace) -> int:
    """Run the demo; return 0 where it succeeds, 1 where it does not."""
    import numpy as np
    from rclpy.logging import LoggingSeverity, set_logger_level

    from bringup.demo.demo import Demo
    from bringup.demo.measures import ARTIFACTS, summary
    from bringup.lockstep import LockStepError
    from bringup.parameters.inputs import gather
    from bringup.scenarios.furnished import make_room
    from bringup.terminal import Progress, show

    options.extend_search(arguments)
    set_logger_level("", LoggingSeverity[arguments.log_level.upper()])
    out = emptied_folder(arguments.out.resolve(), *ARTIFACTS)
    if arguments.scene is not None:
        rng = np.random.default_rng(arguments.seed or 0)
        arguments.world = make_room(out, rng, arguments.scene).world
    try:
        report = Demo(_options(arguments, out, gather(arguments)), Progress()).run()
    except LockStepError as error:
        sys.stderr.write(f"error: {error}\n")
        return 1
    show(summary(arguments.out, report))
    return 0 if report.success else 1


def _options(arguments: argparse.Namespace, out: Path, parameters: Parameters) -> DemoOptions:
    from arjuna_core.se2 import SE2
    from bringup.client.waypoints import load_waypoints
    from bringup.demo.demo import WAYPOINTS, DemoOptions

    file = arguments.waypoints
    waypoints = WAYPOINTS if file is None else tuple(SE2(*pose) for pose in load_waypoints(file))
    return DemoOptions(
        arguments.seed or 0,
        out,
        parameters,
        waypoints,
        goals=arguments.goals,
        kidnap=not arguments.no_kidnap,
        explore_time=arguments.explore_time,
    )
