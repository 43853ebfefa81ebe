"""Meetings with two people at once, who close in on the robot from both sides."""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from arjuna_core.errors import ArjunaError
from arjuna_core.se2 import SE2
from arjuna_sim.model.entities import Entity
from arjuna_sim.model.world import PERSON, Trajectory, person
from bringup.commands.goals import add_options
from bringup.parameters.options import extend_search
from bringup.scenarios.course import Arrival, Course, course
from bringup.scenarios.goals import figures_of
from bringup.scenarios.space import FreeSpace

_EVERY = 8.0  # from one meeting to the next [s]
_SPEEDS = (0.4, 1.2)  # of those who walk, as of `--people` [m/s]
_WITHIN = (1.5, 3.0)  # after which they are at the robot [s]
_APART = 1.2  # from the robot, where they come from at the least [m]
_BEYOND = (1.5, 1.0, 0.5, 0.2)  # how far they walk on behind it, as there is room [m]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add this benchmark's options."""
    add_options(parser)
    parser.add_argument("--meetings", type=int, default=100, help="to drive through (%(default)s)")


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    """Drive to goals until there have been so many meetings.

    Returns:
        The figures of the goals (`figures_of`), and how many `meetings` there were.
    """
    extend_search(arguments)
    rng = np.random.default_rng(arguments.seed or 0)
    with TemporaryDirectory() as folder, course(arguments, rng, Path(folder)) as driver:
        pair, arrivals = Pair(driver, rng), list[Arrival]()
        while pair.meetings < arguments.meetings:
            arrivals.append(driver.drive(driver.draw(rng)))
        result = {"meetings": pair.meetings, **figures_of(arrivals, driver.speed)}
    for name, value in result.items():
        print(f"{name:18}{value:10.4g}")
    return result


class Pair:
    """Two people who walk to and fro through where the robot will be, from opposite sides.

    Args:
        driver: Whose robot they meet; its `step` is wrapped.

    Attributes:
        meetings: How many there have been.
    """

    def __init__(self, driver: Course, rng: np.random.Generator) -> None:
        grid = driver.space.grid
        room = PERSON[0] + grid.frame.resolution
        self._robot, self._rng = driver.robot, rng
        self._space = FreeSpace(grid, room, room)
        self._stage, self._step = driver.robot.sim.simulator.stage, driver.robot.step
        self._walking = False
        self.meetings, self._due = 0, driver.robot.now
        driver.robot.step = self._stepped
        self._come(tries=1000)
        if not self._walking:
            raise ArjunaError("the map has no room for people beside the robot")

    def _stepped(self) -> None:
        self._step()
        if self._robot.now >= self._due:
            self._come()

    def _come(self, tries: int = 20) -> None:
        """Let both come from elsewhere, where there is room for them to."""
        for _ in range(tries):
            walks = self._drawn()
            if len(walks) == 2:
                break
        else:
            return
        for k, walk in enumerate(walks):
            if self._walking:
                self._stage.delete(f"person_{k}")
            self._stage.spawn(Entity(f"person_{k}", person(), trajectory=walk, spawned=True))
        self._walking = True
        self.meetings += 1
        self._due = self._robot.now + _EVERY

    def _drawn(self) -> list[Trajectory]:
        """Return how the two walk: at any angle, one a little earlier than the other or not."""
        rng, truth = self._rng, self._robot.sim.last.truth
        within, bearing = rng.uniform(*_WITHIN), rng.uniform(-math.pi, math.pi)
        met = truth.pose @ SE2(float(rng.uniform(0.0, 0.4) * within))
        walks = []
        for angle in (bearing, bearing + rng.normal(math.pi, 0.35)):
            speed, late = rng.uniform(*_SPEEDS), rng.normal(0.0, 0.4)
            aim = self._space.nearest(
                *(np.array([met.x, met.y]) + rng.normal(0.0, 0.1, 2)).tolist()
            )
            line = SE2(aim.x, aim.y, float(angle))
            start = line @ SE2(float(speed * max(within + late, 0.5)))
            if start.distance(truth.pose) < _APART or not self._space.sees(start, aim):
                continue
            ends = (line @ SE2(-far) for far in _BEYOND)
            end = next((each for each in ends if self._space.sees(aim, each)), aim)
            walks.append(Trajectory.along(np.array([[start.x, start.y], [end.x, end.y]]), speed))
        return walks
