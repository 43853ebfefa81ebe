"""Goals among people who keep walking and stop for nobody, played by the cores alone."""

from __future__ import annotations

import argparse
from typing import Any

import numpy as np

from bringup.parameters import options
from tests.helpers.nav.crowds import Crowd
from tests.helpers.nav.layers import Body
from tests.helpers.nav.played import Play

_PEOPLE = (3, 5, 8, 12, 20)
_GOALS = 2  # of a crowd
_CORNERS = ((0.225, 0.15), (0.2, 0.19))  # of Arjuna's outline, a quarter [m]
_TIMEOUT_PER_METRE, _TIMEOUT = 15.0, 60.0  # of a goal, as of those of `bench goals` [s]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add this benchmark's options."""
    options.add(parser, "--seed")
    parser.add_argument(
        "--people", type=int, nargs="*", default=_PEOPLE, help=f"in a room of 12 x 9 m {_PEOPLE}"
    )
    parser.add_argument("--count", type=int, default=5, help="crowds of a size (%(default)s)")


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    """Drive to goals in crowds.

    Returns:
        Of each number of people how many goals were `reached`, of all `count`, how many of them
        within a `minute`, how often the robot `bumped` into somebody, how often it `met` somebody
        at all, whoever walked, and how often it touched `walls`.
    """
    result = {}
    for people in arguments.people:
        drives = [
            drive
            for number in range(arguments.count)
            for drive in _through(people, (arguments.seed or 0) + number)
        ]
        result[str(people)] = {
            "reached": sum(drive.arrived for drive in drives),
            "minute": sum(drive.arrived and drive.time <= _TIMEOUT for drive in drives),
            "count": len(drives),
            "bumped": sum(drive.meetings.bumped for drive in drives),
            "met": sum(drive.meetings.hits for drive in drives),
            "walls": sum(drive.touched for drive in drives),
        }
        print(f"{people:3} people: {result[str(people)]}", flush=True)
    return result


def _through(people: int, seed: int) -> list[Play]:
    """Drive to the goals of one crowd, each from where the last drive ended."""
    crowd = Crowd.draw(people, _GOALS, np.random.default_rng([people, seed]))
    quarter = np.array(_CORNERS)
    half = np.vstack((quarter, quarter[::-1] * (-1.0, 1.0)))
    body = Body(np.vstack((half, -half)), 0.25, 0.03)
    rng, pose, started = np.random.default_rng(seed), crowd.start, 0.0
    drives: list[Play] = []
    for goal in crowd.goals:
        walk, limit = crowd.since(started), _TIMEOUT + _TIMEOUT_PER_METRE * pose.distance(goal)
        drive = Play(crowd.walls, crowd.grid, pose, goal, body, rng, people=walk).run(limit)
        pose, started = drive.robot.pose, started + drive.time
        drives.append(drive)
    return drives
