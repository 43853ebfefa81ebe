"""The command line of `python -m bringup`; argparse only, so that `--help` is instant."""

from __future__ import annotations

import argparse
import math
from collections.abc import Sequence
from pathlib import Path

from bringup import bench
from bringup.parameters import robot_options
from bringup.simulator import parser as simulator_parser

LOG_LEVELS = ("debug", "info", "warn", "error", "fatal")


def parse(argv: Sequence[str] | None = None) -> argparse.Namespace:
    """Read the command line.

    Args:
        argv: The arguments; those of the process if None.

    Returns:
        `command` and the command's options.
    """
    return build_parser().parse_args(argv)


def build_parser() -> argparse.ArgumentParser:
    """Return the parser of all commands."""
    parser = argparse.ArgumentParser(
        prog="python -m bringup", description="Run the Arjuna robot: simulation, SLAM, navigation."
    )
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    _add_sim(commands)
    _add_slam(commands)
    _add_nav(commands)
    _add_demo(commands)
    simulator_parser.add_commands(commands)
    _add_calibrate(commands)
    _add_bench(commands)
    return parser


def _add_sim(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    parser = _add(commands, "sim", "the simulated robot in its world, in real time")
    _add_simulator_options(parser)
    robot_options.add_check(parser)
    parser.add_argument(
        "--rtf",
        type=_factor,
        metavar="FACTOR",
        help="simulated seconds per real second, 0 for as fast as it goes (1)",
    )


def _add_slam(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    about = "mapping and localization of a running robot, slam_toolbox and map_saver, or of a log"
    parser = _add(commands, "slam", about)
    group = _add_offline(parser, "out/slam", "where map, trajectory, report and picture go")
    group.add_argument(
        "--relations", type=Path, metavar="FILE", help="reference relations to compare with"
    )


def _add_nav(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    about = "AMCL and navigation of a running robot on a map, or AMCL of a log"
    parser = _add(commands, "nav", about)
    parser.add_argument(
        "--map", required=True, type=Path, metavar="FILE", help="the map's YAML file"
    )
    _add_offline(parser, "out/amcl", "where trajectory, report and picture go")
    _add_seed(parser)


def _add_offline(parser: argparse.ArgumentParser, out: str, what: str) -> argparse._ArgumentGroup:
    group = parser.add_argument_group("on a log")
    group.add_argument(
        "--offline",
        type=Path,
        metavar="INPUT",
        help="a CARMEN log (.clf, .log, also .xz, .gz, .bz2), an mcap recording or rosbag2 folder",
    )
    group.add_argument(
        "--out",
        type=Path,
        default=Path(out),
        metavar="FOLDER",
        help=f"{what} (%(default)s)",
    )
    group.add_argument("--scan-topic", metavar="TOPIC", help="of a recording (/scan)")
    group.add_argument(
        "--odom-topic", metavar="TOPIC", help="of a recording, instead of what /tf says"
    )
    return group


def _add_demo(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    about = "explore, map, drive waypoints, be carried off and drive home, as fast as it goes"
    parser = _add(commands, "demo", about)
    _add_simulator_options(parser)
    parser.add_argument(
        "--out",
        type=Path,
        default=Path("out/demo"),
        metavar="FOLDER",
        help="where the report, pictures, map and recording go (%(default)s)",
    )


def _add_calibrate(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    about = "find a robot's effective track width and wheel radius by driving it in the simulator"
    parser = commands.add_parser("calibrate", help=about, description=f"{about.capitalize()}.")
    parser.add_argument("--robot", type=Path, metavar="FILE", help="the URDF (urdf/arjuna.urdf)")
    parser.add_argument(
        "--world", type=Path, metavar="FILE", help="with 4 m free space (worlds/empty.world)"
    )
    parser.add_argument(
        "--out",
        type=Path,
        default=Path("out/calibration"),
        metavar="FOLDER",
        help="where parameter file, URDF snippet and picture go (%(default)s)",
    )


def _add_bench(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    about = "measure a part of the robot"
    parser = commands.add_parser("bench", help=about, description=f"{about.capitalize()}.")
    valid = f"one of: {', '.join(bench.names())}"
    parser.add_argument("name", metavar="NAME", help=valid)
    parser.add_argument("options", nargs=argparse.REMAINDER, help="its own; see NAME --help")


def _add(
    commands: argparse._SubParsersAction[argparse.ArgumentParser], name: str, about: str
) -> argparse.ArgumentParser:
    parser = commands.add_parser(name, help=about, description=f"Run {about}.")
    parser.add_argument(
        "--params",
        type=Path,
        action="append",
        default=[],
        metavar="FILE",
        help="a ROS parameter file; may be given again, later files win",
    )
    parser.add_argument(
        "--log-level", choices=LOG_LEVELS, default="info", help="what to log at least (info)"
    )
    return parser


def _add_simulator_options(parser: argparse.ArgumentParser) -> None:
    robot_options.add_options(parser)
    _add_seed(parser)


def _add_seed(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--seed", type=_seed, metavar="N", help="seed of every random choice, 0 or more (0)"
    )


def _seed(text: str) -> int:
    if not text.isascii() or not text.isdigit() or int(text) >= 2**63:
        raise argparse.ArgumentTypeError(f"{text!r} is no seed; valid: a whole number from 0")
    return int(text)


def _factor(text: str) -> float:
    try:
        factor = float(text)
    except ValueError:
        factor = -1.0
    if not 0.0 <= factor < math.inf:
        raise argparse.ArgumentTypeError(f"{text!r} is no factor; valid: a number from 0")
    return factor
