"""Doors, drawn by seed: a room of two halves and a gap between them that the robot fits through."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from arjuna_core.files.maps import save_map
from arjuna_core.grid import GridFrame, OccupancyGrid
from arjuna_core.se2 import SE2

_LENGTH, _WIDTH = 7.0, 5.0  # of the room, the door's wall across its middle [m]
_OUTER = 0.2  # thickness of the room's own walls [m]
_CELL, _MARGIN = 0.05, 0.5  # of the map [m]
Box = tuple[float, float, float, float]
"""Middle and size of a wall in the room's frame [m]."""


@dataclass(frozen=True)
class Door:
    """One door.

    Attributes:
        width: Of the gap [m].
        walls: Of the room and of the door.
        T_world_room: Where the room lies: off the map's cells, and turned against them.
        start: Of the robot, in the world.
        goal: Beyond the door, in the world.
    """

    width: float
    walls: tuple[Box, ...]
    T_world_room: SE2
    start: SE2
    goal: SE2

    @staticmethod
    def draw(width: float, rng: np.random.Generator) -> Door:
        """Return a door in a wall of some thickness, come to from some side."""
        thick, middle = float(rng.choice([0.05, 0.1, 0.2, 0.35])), float(rng.uniform(-1.0, 1.0))
        turned = float(rng.choice([0.0, rng.uniform(-0.6, 0.6)]))
        room = SE2(float(rng.uniform(-0.5, 0.5)), float(rng.uniform(-0.5, 0.5)), turned)
        sides = [-_WIDTH / 2.0, middle - width / 2.0, middle + width / 2.0, _WIDTH / 2.0]
        jambs = [(0.0, (a + b) / 2.0, thick, b - a) for a, b in (sides[:2], sides[2:])]
        x, y, t = _LENGTH / 2.0, _WIDTH / 2.0, _OUTER
        outer = [(s * x, 0.0, t, 2.0 * y + t) for s in (-1, 1)]
        outer += [(0.0, s * y, 2.0 * x + t, t) for s in (-1, 1)]
        lateral = np.clip(middle + rng.uniform(-1.2, 1.2, 2), 0.7 - y, y - 0.7)
        start, goal = (
            SE2(s * float(rng.uniform(1.2, 2.4)), float(side))
            for s, side in zip((-1, 1), lateral, strict=True)
        )
        start = start @ SE2(0.0, 0.0, float(rng.uniform(-math.pi, math.pi)))
        return Door(width, (*jambs, *outer), room, room @ start, room @ goal)

    def is_through(self, pose: SE2) -> bool:
        """Return whether a robot is beyond the door."""
        return (self.T_world_room.inverse() @ pose).x > 0.5

    def save(self, folder: Path) -> tuple[Path, Path]:
        """Write the world and its map; return both."""
        world, walls = folder / "door.world", []
        for k, (x, y, dx, dy) in enumerate(self.walls):
            at = self.T_world_room @ SE2(x, y)
            size = f"<geometry><box><size>{dx:.4f} {dy:.4f} 1</size></box></geometry>"
            walls.append(
                f"<model name='wall_{k}'><static>true</static>"
                f"<pose>{at.x:.4f} {at.y:.4f} 0.5 0 0 {at.theta:.5f}</pose>"
                f"<link name='link'><collision name='c'>{size}</collision></link></model>"
            )
        world.write_text(f"<sdf version='1.7'><world name='door'>{''.join(walls)}</world></sdf>")
        return world, save_map(self.map(), folder / "door")[0]

    def edges(self) -> NDArray[np.float64]:
        """Return the walls' edges in the world, `(N, 4)` x0, y0, x1, y1 [m]."""
        pieces = []
        for x, y, dx, dy in self.walls:
            half = np.array([[-dx, -dy], [dx, -dy], [dx, dy], [-dx, dy]]) / 2.0
            corners = self.T_world_room.apply(half + np.array([x, y]))
            pieces.append(np.hstack((corners, np.roll(corners, -1, axis=0))))
        return np.vstack(pieces)

    def map(self) -> OccupancyGrid:
        """Return the map: what a wall covers any of is occupied."""
        points = np.vstack([_filled(box) for box in self.walls])
        reach = math.hypot(_LENGTH, _WIDTH) / 2.0 + _MARGIN
        cells = 2 * math.ceil(reach / _CELL)
        corner = SE2(self.T_world_room.x - reach, self.T_world_room.y - reach)
        frame = GridFrame(_CELL, cells, cells, corner)
        data = np.zeros(frame.shape, np.int8)
        data[tuple(frame.to_cells(self.T_world_room.apply(points)).T)] = 100
        return OccupancyGrid(frame, data)


def _filled(box: Box, spacing: float = 0.01) -> NDArray[np.float64]:
    """Return points that fill a box, at most a spacing apart [m]."""
    x, y, dx, dy = box
    across = [np.linspace(-d / 2.0, d / 2.0, math.ceil(d / spacing) + 1) for d in (dx, dy)]
    grid = np.stack(np.meshgrid(*across), axis=-1).reshape(-1, 2)
    shifted: NDArray[np.float64] = grid + np.array([x, y])
    return shifted
