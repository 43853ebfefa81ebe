"""A made-up furnished room: much of what stands in it lies below or above the lidar's plane."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from arjuna_core.files.maps import save_map
from arjuna_core.grid import FREE, OCCUPIED, GridFrame, OccupancyGrid
from arjuna_core.se2 import SE2

_LENGTH, _WIDTH, _WALL = 10.0, 8.0, 0.1  # of the room [m]
_PLANE, _TOP = 0.28, 0.35  # of Arjuna's lidar, and above the robot [m]
_CELL = 0.05
_TOUCH = 1e-6  # of a cell's edge, without which rounding decides for one side of every wall [m]
_APART = 0.75  # between two pieces: the robot passes [m]
_MODEL = (
    "<model name='{name}'><static>1</static><pose>{x:.3f} {y:.3f} {z:.3f} 0 0 0</pose>"
    "<link name='link'><collision name='collision'><geometry><box><size>{dx:.3f} {dy:.3f} {dz:.3f}"
    "</size></box></geometry></collision></link></model>"
)
_GROUND = "<include><uri>model://ground_plane</uri></include>"


class Box(NamedTuple):
    """A box that stands square: its middle, size, and from which height to which [m]."""

    x: float
    y: float
    dx: float
    dy: float
    low: float
    high: float


class Room(NamedTuple):
    """Files of a room.

    Attributes:
        world: The SDF world.
        seen: The map that a lidar would make.
        whole: The map of all that the robot could touch.
    """

    world: Path
    seen: Path
    whole: Path


def make_room(folder: Path, rng: np.random.Generator) -> Room:
    """Write a room with low tables, desks with a bar, low things and plates into a folder."""
    boxes = [*_walls(), *_furniture(rng)]
    models = (_model(k, box) for k, box in enumerate(boxes))
    world = folder / "furnished.world"
    text = f"<sdf version='1.6'><world name='furnished'>{_GROUND}{''.join(models)}</world></sdf>"
    world.write_text(text, encoding="ascii")
    cut = [box for box in boxes if box.low <= _PLANE <= box.high]
    low = [box for box in boxes if box.low < _TOP]
    seen, whole = save_map(_grid(cut), folder / "seen"), save_map(_grid(low), folder / "whole")
    return Room(world, seen[0], whole[0])


def _walls() -> Iterator[Box]:
    for side in (-0.5, 0.5):
        yield Box(0.0, side * _WIDTH, _LENGTH, _WALL, 0.0, 1.0)
        yield Box(side * _LENGTH, 0.0, _WALL, _WIDTH, 0.0, 1.0)
    yield Box(-1.0, -2.2, _WALL, 3.4, 0.0, 1.0)
    yield Box(2.0, 1.8, _WALL, 4.2, 0.0, 1.0)


def _furniture(rng: np.random.Generator) -> Iterator[Box]:
    """Give pieces that stand apart from each other and from the walls."""
    taken: list[tuple[float, float, float]] = []
    for radius, piece in ((0.5, _table), (0.6, _desk), (0.5, _plate), (0.2, _low), (0.2, _low)) * 3:
        position = _free_position(radius, taken, rng)
        if position is not None:
            taken.append((*position, radius))
            x, y = position
            for box in piece(rng):
                yield box._replace(x=box.x + x, y=box.y + y)


def _free_position(
    radius: float,
    taken: list[tuple[float, float, float]],
    rng: np.random.Generator,
    tries: int = 1000,
) -> tuple[float, float] | None:
    """Return where a piece may stand, None where nothing was found."""
    room = radius + _APART
    half = np.array([_LENGTH / 2.0, _WIDTH / 2.0]) - room
    for _ in range(tries):
        x, y = rng.uniform(-half, half)
        beside_walls = (
            abs(x + 1.0) > room or y > -0.5 + room,
            abs(x - 2.0) > room or y < -0.3 - room,
        )
        if all(beside_walls) and all(
            math.hypot(x - other_x, y - other_y) > room + other for other_x, other_y, other in taken
        ):
            return float(x), float(y)
    return None


def _legs(dx: float, dy: float, height: float) -> list[Box]:
    ends = [(x, y) for x in (-dx, dx) for y in (-dy, dy)]
    return [Box(x, y, 0.04, 0.04, 0.0, height) for x, y in ends]


def _table(rng: np.random.Generator) -> list[Box]:
    """A board that the robot's mast would hit, below the lidar's plane."""
    height = float(rng.uniform(0.20, 0.24))
    return [Box(0.0, 0.0, 0.8, 0.5, height, height + 0.03), *_legs(0.37, 0.22, height)]


def _desk(rng: np.random.Generator) -> list[Box]:
    """A high board, and a bar between its legs."""
    bar = float(rng.uniform(0.16, 0.20))
    board, across = Box(0.0, 0.0, 1.0, 0.5, 0.70, 0.74), Box(0.0, 0.0, 0.9, 0.03, bar, bar + 0.05)
    return [board, across, *_legs(0.47, 0.20, 0.70)]


def _low(rng: np.random.Generator) -> list[Box]:
    """A thing that lies about."""
    dx, dy, height = (float(v) for v in rng.uniform((0.06, 0.06, 0.06), (0.25, 0.25, 0.20)))
    return [Box(0.0, 0.0, dx, dy, 0.0, height)]


def _plate(rng: np.random.Generator) -> list[Box]:
    """A plate that is too high to drive onto."""
    return [Box(0.0, 0.0, 0.7, 0.7, 0.0, float(rng.uniform(0.03, 0.05)))]


def _model(number: int, box: Box) -> str:
    z = 0.5 * (box.low + box.high)
    return _MODEL.format(
        name=f"box_{number}", x=box.x, y=box.y, z=z, dx=box.dx, dy=box.dy, dz=box.high - box.low
    )


def _grid(boxes: list[Box]) -> OccupancyGrid:
    """Return the map of boxes seen from above."""
    width, height = round((_LENGTH + 1.0) / _CELL), round((_WIDTH + 1.0) / _CELL)
    origin = SE2(-0.5 * width * _CELL, -0.5 * height * _CELL)
    x: NDArray[Any] = origin.x + (np.arange(width) + 0.5) * _CELL
    y: NDArray[Any] = origin.y + (np.arange(height) + 0.5) * _CELL
    data = np.full((height, width), FREE, np.int8)
    for box in boxes:
        columns = np.abs(x - box.x) < 0.5 * (box.dx + _CELL) - _TOUCH
        rows = np.abs(y - box.y) < 0.5 * (box.dy + _CELL) - _TOUCH
        data[np.ix_(rows, columns)] = OCCUPIED
    return OccupancyGrid(GridFrame(_CELL, width, height, origin), data)
