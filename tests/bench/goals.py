"""Random goals on a map, as by the command `goals`, for a day in pieces if need be."""

from __future__ import annotations

import argparse
from dataclasses import asdict
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from arjuna_core.se2 import SE2
from bringup.commands.goals import add_options
from bringup.parameters.options import extend_search
from bringup.scenarios.course import Arrival, Continuation, course
from bringup.scenarios.goals import figures_of
from tests.helpers.nav.journal import Journal, Ticks, draw, steadiness

_HOUR = 3600.0
_SETTING = (
    *("seed", "world", "map", "truth", "scene", "boxes", "people", "radius", "robot"),
    *("params", "param"),
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add this benchmark's options."""
    add_options(parser)
    parser.add_argument(
        "--furnished", dest="scene", action="store_const", const="furnished", help="that scene"
    )
    parser.add_argument("--hours", type=float, help="simulated, to drive instead of --count goals")
    parser.add_argument(
        "--piece", type=float, metavar="H", help="simulated hours after which this process ends"
    )
    parser.add_argument(
        "--state",
        type=Path,
        metavar="FILE",
        help="keeps each goal: the same command again continues behind the last, whatever ended"
        " the one before; all are drawn beside it, as .png",
    )


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    """Drive to one goal after the other.

    Returns:
        Their figures (`figures_of`); with `--state` how steady it was too.

    A process that continues has its own noise, drawn from the seed and its number. It puts the
    robot at rest where it was, its odometry and belief with it, and people where they were on
    their routes. Lost are AMCL's particles (drawn again about the belief), what costmaps hold
    beside the map, and who was being tracked.
    """
    extend_search(arguments)
    rng = np.random.default_rng(arguments.seed or 0)
    journal = Journal(arguments.state, {name: str(vars(arguments)[name]) for name in _SETTING})
    with TemporaryDirectory() as folder:
        speed = _drive(arguments, rng, journal, Path(folder))
    result = figures_of([Arrival(**row["arrival"]) for row in journal.rows], speed)
    if arguments.state is not None:
        result.update(steadiness(journal.rows))
        draw(journal.rows, arguments.state.with_suffix(".png"))
    for name, value in result.items():
        print(f"{name:18}{value:10.4g}")
    return result


def _drive(
    arguments: argparse.Namespace, rng: np.random.Generator, journal: Journal, folder: Path
) -> float:
    """Drive what is left of the goals; return the desired speed [m/s]."""
    arguments.seed = (arguments.seed or 0) + journal.piece
    resume, after = journal.resume, Continuation()
    if resume:
        at, memory = SE2(*resume["believed"]), journal.parameters(folder)
        after = Continuation(at, memory, journal.began, resume["walked"], len(journal.rows))
    with course(arguments, rng, folder, after) as driver:
        rng.bit_generator.state = resume.get("rng", rng.bit_generator.state)
        ticks, given = Ticks(driver.robot), driver.given
        arguments.count = len(given) or arguments.count
        while not _is_done(arguments, journal, driver.robot.now):
            goal = given[len(journal.rows)] if given else driver.draw(rng)
            arrival = driver.drive(goal)
            journal.append(driver.robot, rng, goal, arrival=asdict(arrival), cost=ticks.taken())
        return driver.speed


def _is_done(arguments: argparse.Namespace, journal: Journal, now: float) -> bool:
    if arguments.hours is not None:
        done = now >= arguments.hours * _HOUR
    else:
        done = len(journal.rows) >= arguments.count
    pieces = arguments.piece is not None and now - journal.began >= arguments.piece * _HOUR
    return done or (pieces and bool(journal.resume))
