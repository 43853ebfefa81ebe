"""The pillar arena has the coordinates of TurtleBot3's world, for which guides are written."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from arjuna_core.files.maps import load_map
from arjuna_core.files.shipped import shipped_file
from arjuna_core.se2 import SE2
from arjuna_sim.files.world_file import load_world
from arjuna_sim.model.geometry.walls import surfaces
from tests.sim.builders import simulator

_WORLD = shipped_file("worlds/pillar_arena.world")
_PILLARS = set(itertools.product((-1.1, 0.0, 1.1), repeat=2))


def test_pillars_stand_where_turtlebot3s_do() -> None:
    world = load_world(_WORLD)
    places = {
        tuple(round(value, 6) for value in body.T_world_model.position[:2])
        for body in world.bodies
        if body.model.startswith("pillar")
    }
    assert places == _PILLARS


@pytest.mark.parametrize("start", [(-2.0, -0.5), (-2.0, 0.0), (-1.5, 0.5)])
def test_starts_of_the_guides_are_free_and_inside(start: tuple[float, float]) -> None:
    """TurtleBot3 spawns at the first, a guide at the second, and its AMCL begins at the third."""
    sim = simulator(_WORLD, spawn=SE2(*start), robot=shipped_file("urdf/burger.urdf"))
    assert sim.robot.spawn == SE2(*start)
    assert not any("start" in note for note in sim.notes)


def test_the_shipped_map_lies_on_the_world() -> None:
    """Each surface at the lidar's height has an occupied cell within two cells, but for a tenth."""
    grid = load_map(shipped_file("maps/pillar_arena.yaml"))
    ends = surfaces(load_world(_WORLD), 0.17)
    middles = (ends[:, :2] + ends[:, 2:]) / 2.0
    frame, (rows, columns) = grid.frame, np.nonzero(grid.occupied())
    occupied = (np.column_stack((columns, rows)) + 0.5) * frame.resolution
    occupied += (frame.origin.x, frame.origin.y)
    gaps = np.linalg.norm(middles[:, None] - occupied[None], axis=2).min(axis=1)
    pillars = np.abs(middles).max(axis=1) < 1.3  # walls are seen from inside only
    assert np.mean(gaps[pillars] < 2.0 * frame.resolution) > 0.9
