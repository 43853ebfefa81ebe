"""Made-up buildings with furniture: a room with much out of the lidar's plane, houses, halls."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from arjuna_core.files.maps import save_map
from arjuna_core.grid import FREE, OCCUPIED, GridFrame, OccupancyGrid
from arjuna_core.se2 import SE2
from bringup.parameters.options import BUILDINGS

_WALL = 0.1  # thickness of walls [m]
_PLANE, _TOP = 0.28, 0.35  # of Arjuna's lidar, and above the robot [m]
_CELL = 0.05
_TOUCH = 1e-6  # of a cell's edge, without which rounding decides for one side of every wall [m]
_APART = 0.75  # between two pieces: the robot passes [m]
_MODEL = (
    "<model name='{name}'><static>1</static><pose>{x:.3f} {y:.3f} {z:.3f} 0 0 0</pose>"
    "<link name='link'><collision name='collision'><geometry>{shape}</geometry></collision></link>"
    "</model>"
)
_BOX = "<box><size>{dx:.3f} {dy:.3f} {dz:.3f}</size></box>"
_SHELL = "<mesh><uri>shell.obj</uri><scale>{dx:.3f} {dy:.3f} {dz:.3f}</scale></mesh>"
_CORNERS = tuple((x, y, z) for z in (-0.5, 0.5) for y in (-0.5, 0.5) for x in (-0.5, 0.5))
_FACES = ((1, 2, 6, 5), (2, 4, 8, 6), (4, 3, 7, 8), (3, 1, 5, 7), (5, 6, 8, 7))
"""Of the mesh of furniture by the numbers of its corners: it is open below."""
_GROUND = "<include><uri>model://ground_plane</uri></include>"


class Box(NamedTuple):
    """A box that stands square: its middle, size, and from which height to which [m].

    Attributes:
        hollow: Whether it is a mesh without thickness, open below.
    """

    x: float
    y: float
    dx: float
    dy: float
    low: float
    high: float
    hollow: bool = False


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


@dataclass(frozen=True)
class Layout:
    """A building [m].

    Attributes:
        walls: Within it.
        pieces: Of furniture, each with the radius that it takes.
    """

    length: float
    width: float
    walls: tuple[Box, ...]
    pieces: tuple[tuple[float, Callable[[np.random.Generator], list[Box]]], ...]


def make_room(folder: Path, rng: np.random.Generator, name: str = "furnished") -> Room:
    """Write a building of a name of `LAYOUTS` into a folder."""
    layout = LAYOUTS[name](rng)
    boxes = [*_outer_walls(layout), *layout.walls, *_furniture(layout, rng)]
    models = (_model(k, box) for k, box in enumerate(boxes))
    world = folder / f"{name}.world"
    text = f"<sdf version='1.6'><world name='{name}'>{_GROUND}{''.join(models)}</world></sdf>"
    mesh = [f"v {x} {y} {z}\n" for x, y, z in _CORNERS]
    mesh += ["f " + " ".join(map(str, face)) + "\n" for face in _FACES]
    (folder / "shell.obj").write_text("".join(mesh), encoding="ascii")
    world.write_text(text, encoding="ascii")
    cut = [box for box in boxes if box.low <= _PLANE <= box.high]
    low = [box for box in boxes if box.low < _TOP]
    seen, whole = (
        save_map(_grid(layout, part), folder / stem)
        for stem, part in (("seen", cut), ("whole", low))
    )
    return Room(world, seen[0], whole[0])


def _room(rng: np.random.Generator) -> Layout:
    """A room with low tables, desks with a bar, low things and plates."""
    walls = Box(-1.0, -2.2, _WALL, 3.4, 0.0, 1.0), Box(2.0, 1.8, _WALL, 4.2, 0.0, 1.0)
    pieces = (0.5, _table), (0.6, _desk), (0.5, _plate), (0.2, _low), (0.2, _low)
    return Layout(10.0, 8.0, walls, pieces * 3)


def _house(rng: np.random.Generator) -> Layout:
    """A house of four rooms or more, with cupboards, boxes and tables on legs."""
    walls = tuple(_divided(Box(0.0, 0.0, 12.0, 9.0, 0.0, 2.0), rng))
    return Layout(12.0, 9.0, walls, ((0.45, _cupboard), (0.6, _dining_table), (0.3, _crate)) * 3)


def _shop(rng: np.random.Generator) -> Layout:
    """A shop of shelves in rows, each with a way through, and a counter."""
    rows = [
        Box(side * 2.6 + float(rng.uniform(-0.3, 0.3)), y, 3.4, 0.5, 0.0, 1.8, True)
        for y in (-3.0, -1.0, 1.0, 3.0)
        for side in (-1, 1)
    ]
    counter = Box(6.2, float(rng.uniform(-1.5, 1.5)), 0.6, 2.0, 0.0, 1.0, True)
    return Layout(16.0, 10.0, (*rows, counter), ((0.3, _crate),) * 4)


def _hall(rng: np.random.Generator) -> Layout:
    """A hall with few things in it, far from each other."""
    return Layout(24.0, 16.0, (), ((0.3, _crate),) * 4 + ((0.45, _cupboard),) * 2)


LAYOUTS = dict(zip(BUILDINGS, (_room, _house, _shop, _hall), strict=True))
"""The buildings by name."""


def _outer_walls(layout: Layout) -> Iterator[Box]:
    for side in (-0.5, 0.5):
        yield Box(0.0, side * layout.width, layout.length, _WALL, 0.0, 1.0)
        yield Box(side * layout.length, 0.0, _WALL, layout.width, 0.0, 1.0)


def _divided(
    room: Box, rng: np.random.Generator, largest: float = 32.0, door: float = 1.1, jamb: float = 0.3
) -> Iterator[Box]:
    """Yield walls that divide a room until none is larger [m^2], each with a door [m].

    A door is beside a wall across, by a jamb [m]: no later wall ends in it.
    """
    x, y, dx, dy = room[:4]
    if dx * dy <= largest:
        return
    along, across = max(dx, dy), min(dx, dy)
    cut = along * float(rng.uniform(-0.12, 0.12))
    side, opening = int(rng.choice((-1, 1))), jamb + door
    pieces = (
        (side * (across - jamb) / 2.0, jamb),
        (-side * opening / 2.0, across - opening),
    )
    for middle, length in pieces:
        upright, flat = (x + cut, y + middle, _WALL, length), (x + middle, y + cut, length, _WALL)
        yield Box(*(upright if dx >= dy else flat), room.low, room.high)
    for end in (-1, 1):
        middle, length = (cut + end * along / 2.0) / 2.0, along / 2.0 - end * cut
        part = (x + middle, y, length, dy) if dx >= dy else (x, y + middle, dx, length)
        yield from _divided(Box(*part, room.low, room.high), rng)


def _furniture(layout: Layout, rng: np.random.Generator) -> Iterator[Box]:
    """Give pieces that stand apart from each other and from the walls."""
    taken: list[tuple[float, float, float]] = []
    for radius, piece in layout.pieces:
        position = _free_position(layout, radius, taken, rng)
        if position is not None:
            taken.append((*position, radius))
            x, y = position
            for box in piece(rng):
                yield box._replace(x=box.x + x, y=box.y + y)


def _free_position(
    layout: Layout,
    radius: float,
    taken: list[tuple[float, float, float]],
    rng: np.random.Generator,
    tries: int = 1000,
) -> tuple[float, float] | None:
    """Return where a piece may stand, None where nothing was found."""
    room = radius + _APART
    half = np.array([layout.length, layout.width]) / 2.0 - room
    for _ in range(tries):
        x, y = rng.uniform(-half, half)
        beside_walls = (
            abs(x - wall.x) > room + (wall.dx - _WALL) / 2.0
            or abs(y - wall.y) > room + wall.dy / 2.0
            for wall in layout.walls
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


def _cupboard(rng: np.random.Generator) -> list[Box]:
    dx, dy, height = (float(v) for v in rng.uniform((0.3, 0.3, 1.0), (0.6, 0.6, 1.8)))
    return [Box(0.0, 0.0, dx, dy, 0.0, height, True)]


def _dining_table(rng: np.random.Generator) -> list[Box]:
    """A board above most robots, on legs."""
    return [Box(0.0, 0.0, 1.0, 0.6, 0.72, 0.75, True), *_legs(0.47, 0.27, 0.72)]


def _crate(rng: np.random.Generator) -> list[Box]:
    dx, dy = (float(v) for v in rng.uniform(0.25, 0.4, 2))
    return [Box(0.0, 0.0, dx, dy, 0.0, 0.8, True)]


def _model(number: int, box: Box) -> str:
    z = 0.5 * (box.low + box.high)
    shape = (_SHELL if box.hollow else _BOX).format(dx=box.dx, dy=box.dy, dz=box.high - box.low)
    return _MODEL.format(name=f"box_{number}", x=box.x, y=box.y, z=z, shape=shape)


def _grid(layout: Layout, boxes: list[Box]) -> OccupancyGrid:
    """Return the map of boxes seen from above."""
    width, height = (round((size + 1.0) / _CELL) for size in (layout.length, layout.width))
    origin = SE2(-0.5 * width * _CELL, -0.5 * height * _CELL)
    x: NDArray[Any] = origin.x + (np.arange(width) + 0.5) * _CELL
    y: NDArray[Any] = origin.y + (np.arange(height) + 0.5) * _CELL
    data = np.full((height, width), FREE, np.int8)
    for box in boxes:
        columns = np.abs(x - box.x) < 0.5 * (box.dx + _CELL) - _TOUCH
        rows = np.abs(y - box.y) < 0.5 * (box.dy + _CELL) - _TOUCH
        data[np.ix_(rows, columns)] = OCCUPIED
    return OccupancyGrid(GridFrame(_CELL, width, height, origin), data)
