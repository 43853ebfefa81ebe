"""Scenes to drive in: a world's file with its map, or one that is made up by the seed."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from arjuna_core.errors import ArjunaError
from arjuna_core.files.maps import load_map
from arjuna_core.files.shipped import shipped_file
from arjuna_core.grid import OccupancyGrid
from arjuna_core.se2 import SE2
from bringup.scenarios import barn
from bringup.scenarios.doors import Door
from bringup.scenarios.furnished import LAYOUTS, make_room


@dataclass(frozen=True)
class Scene:
    """A world, its maps, and the goals that it has.

    Attributes:
        world: Its file.
        map: The robot's map; None where it navigates in odom, without one.
        grid: All that the robot could touch.
        start: Of the robot; drawn if None.
        goals: In the world; drawn if there are none.
    """

    world: Path
    map: Path | None
    grid: OccupancyGrid
    start: SE2 | None = None
    goals: tuple[SE2, ...] = ()


def _furnished(arguments: argparse.Namespace, folder: Path, rng: np.random.Generator) -> Scene:
    world, seen, whole = make_room(folder, rng, arguments.scene)
    return Scene(world, seen, load_map(whole))


def _door(arguments: argparse.Namespace, folder: Path, rng: np.random.Generator) -> Scene:
    door = Door.draw(arguments.width, rng)
    return Scene(*door.save(folder), door.map(), door.start, (door.goal,))


def _field(arguments: argparse.Namespace, folder: Path, rng: np.random.Generator) -> Scene:
    kind = barn.KINDS[int(rng.integers(len(barn.KINDS)))]
    world, grid = barn.make_world(folder, 0, kind, rng)
    return Scene(world, None, grid, barn.START, (barn.START @ SE2(barn.AHEAD, 0.0),))


def _of_file(arguments: argparse.Namespace, folder: Path, rng: np.random.Generator) -> Scene:
    world = arguments.world or shipped_file("worlds/arjuna_room.world")
    own = arguments.map or shipped_file(f"maps/{world.stem}.yaml")
    if not (arguments.map or own.exists()):
        made = f"python -m bringup demo --world {world}"
        raise ArjunaError(f"{world}: no map of it is here; --map FILE, as '{made}' makes it")
    return Scene(world, own, load_map(arguments.truth or own))


SCENES: dict[str | None, Callable[[argparse.Namespace, Path, np.random.Generator], Scene]] = {
    None: _of_file,
    **dict.fromkeys(LAYOUTS, _furnished),
    "door": _door,
    "field": _field,
}
"""The scenes by name; the one without a name is a world's file with its map."""
