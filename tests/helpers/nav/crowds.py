"""Rooms with people who keep walking, drawn by seed."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arjuna_core.grid import OccupancyGrid
from arjuna_core.se2 import SE2
from arjuna_sim.model.world import PERSON, Trajectory
from tests.nav.worlds import block, empty_grid

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
