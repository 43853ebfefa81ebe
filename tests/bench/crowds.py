"""Goals among people who keep walking and stop for nobody, played by the cores alone."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arjuna_core.grid import OccupancyGrid
from arjuna_core.se2 import SE2
from arjuna_sim.model.world import PERSON, Trajectory
from bringup.parameters import options
from tests.helpers.nav.layers import Body
from tests.helpers.nav.played import Play
from tests.nav.worlds import block, empty_grid

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


_LENGTH, _WIDTH = 12.0, 9.0  # of the room [m]
_WALL = 0.2
_SIDES = 12  # of what stands for a person
_APART = 1.5  # from the robot's start to those who walk by, at first [m]
_NEAR = 1.0  # from walls to goals and boxes [m]


@dataclass(frozen=True)
class Crowd:
    """A room, its boxes, and who walks in it.

    Attributes:
        walls: Of the room and the boxes, `(N, 4)` x0, y0, x1, y1 [m].
        walkers: How each walks; they stop for nobody.
        goals: One after the other.
    """

    walls: NDArray[np.float64]
    grid: OccupancyGrid
    walkers: tuple[Trajectory, ...]
    start: SE2
    goals: tuple[SE2, ...]

    @staticmethod
    def draw(people: int, goals: int, rng: np.random.Generator) -> Crowd:
        """Return a crowd of so many people."""
        grid = empty_grid(_LENGTH, _WIDTH)
        rooms = [(0.0, 0.0, _LENGTH, _WALL), (0.0, _WIDTH - _WALL, _LENGTH, _WALL)]
        rooms += [(0.0, 0.0, _WALL, _WIDTH), (_LENGTH - _WALL, 0.0, _WALL, _WIDTH)]
        boxes = [(2.6 + 2.4 * k, 2.0 + 4.0 * float(rng.random()), 0.5, 0.5) for k in range(4)]
        for box in (*rooms, *boxes):
            block(grid, *box)
        stops = [_free_point(boxes, rng) for _ in range(goals + 1)]
        walkers: list[Trajectory] = []
        while len(walkers) < people:
            points = np.array([_free_point(boxes, rng) for _ in range(3)])
            walker = Trajectory.along(points, float(rng.uniform(0.4, 1.2)))
            if math.dist(points[0], stops[0]) > _APART:
                walkers.append(walker)
        poses = [SE2(x, y, float(rng.uniform(-math.pi, math.pi))) for x, y in stops]
        edges = np.vstack([_edges(*box) for box in (*rooms, *boxes)])
        return Crowd(edges, grid, tuple(walkers), poses[0], tuple(poses[1:]))

    def since(self, start: float) -> Callable[[float], list[NDArray[np.float64]]]:
        """Return a function of the edges of those who walk, by the time since a start [s]."""
        return lambda time: self.people(start + time)

    def people(self, time: float) -> list[NDArray[np.float64]]:
        """Return the edges of each of those who walk, at a time [s]."""
        turns = np.arange(_SIDES) * (2.0 * math.pi / _SIDES)
        ring = PERSON[0] * np.column_stack((np.cos(turns), np.sin(turns)))
        found = []
        for walker in self.walkers:
            at = walker.pose(time)
            corners = ring + np.array([at.x, at.y])
            found.append(np.hstack((corners, np.roll(corners, -1, axis=0))))
        return found


def _edges(x: float, y: float, width: float, height: float) -> NDArray[np.float64]:
    corners = np.array([[x, y], [x + width, y], [x + width, y + height], [x, y + height]])
    return np.hstack((corners, np.roll(corners, -1, axis=0)))


def _free_point(
    boxes: list[tuple[float, float, float, float]], rng: np.random.Generator
) -> tuple[float, float]:
    """Return a point with room about it."""
    while True:
        x, y = rng.uniform((_NEAR, _NEAR), (_LENGTH - _NEAR, _WIDTH - _NEAR)).tolist()
        if all(math.hypot(x - bx - w / 2, y - by - h / 2) > _NEAR for bx, by, w, h in boxes):
            return x, y
