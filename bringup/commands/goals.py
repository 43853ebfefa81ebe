"""`goals`: drive to random goals in a scene, as fast as it goes, judged by the truth."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from arjuna_core.files.whole_file import emptied_folder
from bringup.parameters import options

EXAMPLES = (
    "goals --count 5 --seed 3",
    "goals --scene door --width 0.6 --params my_controller.yaml --out out/door",
)
RESULT = "result.json"


def configure(parser: argparse.ArgumentParser) -> None:
    add_options(parser)
    about = "where the figures go, and recordings and pictures of the first drives that fail"
    options.add(parser, "--out", help=about)


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add what a drive to goals depends on."""
    options.add(parser, *options.SIMULATION, *options.NODES, "--seed")
    parser.add_argument(
        "--scene",
        choices=(*options.BUILDINGS, "door", "field"),
        help=f"{options.ABOUT_BUILDINGS}; a door "
        "between two rooms; a field of cylinders, as of the BARN challenge, without a map",
    )
    parser.add_argument(
        "--width", type=options.positive, default=0.7, help="of the door [m] (%(default)s)"
    )
    parser.add_argument("--map", type=Path, metavar="FILE", help="the world's map (its own)")
    parser.add_argument(
        "--truth",
        type=Path,
        metavar="FILE",
        help="a map of all that the robot could touch, for goals and shortest paths (the map)",
    )
    parser.add_argument("--boxes", type=int, default=0, help="that the map does not have (0)")
    parser.add_argument(
        "--people", type=int, default=0, help="who walk to and fro, each along a line (0)"
    )
    parser.add_argument(
        "--count", type=int, default=20, help="how many goals (%(default)s; one past a door)"
    )
    parser.add_argument(
        "--radius", type=float, default=0.2, help="of the robot, for the shortest path [m]"
    )
    parser.set_defaults(log_level="error", slam=False, out=None)


def run(arguments: argparse.Namespace) -> int:
    """Drive to the goals; return 0 where all are reached without a touch."""
    from bringup.scenarios.goals import drive_to_goals

    options.extend_search(arguments)
    if arguments.out is not None:
        emptied_folder(arguments.out, RESULT, "goal_*.mcap", "goal_*.png")
    result = drive_to_goals(arguments)
    if arguments.out is not None:
        text = json.dumps(result, indent=2)
        (arguments.out / RESULT).write_text(f"{text}\n", encoding="utf-8")
    return 0 if result["missed"] == result["touches"] == 0 else 1
