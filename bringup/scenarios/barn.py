"""Worlds like those of the BARN challenge, made up by a cellular automaton.

Perille et al., "Benchmarking metric ground navigation", SSRR 2020: a field of cylinders that a
robot crosses, drawn with some fill and smoothed some times.
"""

from __future__ import annotations

import itertools
import math
from pathlib import Path

import numpy as np
from scipy.ndimage import binary_dilation, convolve

from arjuna_core.arrays import Bools, Ints
from arjuna_core.grid import FREE, OCCUPIED, GridFrame, OccupancyGrid
from arjuna_core.se2 import SE2
from arjuna_nav.costmap.costmap import LETHAL
from arjuna_nav.planners.waves.descent import descend
from arjuna_nav.planners.waves.potential import traversal_costs, wavefront

START = SE2(-2.25, 3.0, math.pi / 2.0)
AHEAD = 10.0
"""From the start to the goal [m]."""
CELL = 0.15
"""Of the field and of the path files [m]."""
_SIZE = 30  # of the field [cells]
_FIRST_ROW = 34  # of the field, counted from where the fence begins
_LEFT = -4.425  # x of the first column's centres [m]
_BEFORE_PATH = 5.075, -4.575  # y and x of the cell (0, 0) of path files [m]
KINDS = tuple(itertools.product((2, 3, 4), (0.15, 0.20, 0.25, 0.30)))
"""How often a field is smoothed, and which share of it is filled at first."""
_CYLINDER = (
    "<model name='unit_cylinder_{}'><static>1</static><pose>{:.3f} {:.3f} 0.5 0 0 0</pose>"
    "<link name='link'><collision name='collision'><geometry><cylinder><radius>0.075</radius>"
    "<length>1</length></cylinder></geometry></collision></link></model>"
)
_GROUND = "<include><uri>model://ground_plane</uri></include>"


def make_worlds(folder: Path, count: int, rng: np.random.Generator) -> Path:
    """Write `world_N.world`, their kinds in turns, and `path_N.npy`; return the folder."""
    for number, kind in zip(range(count), itertools.cycle(KINDS), strict=False):
        make_world(folder, number, kind, rng)
    return folder


def make_world(
    folder: Path, number: int, kind: tuple[int, float], rng: np.random.Generator
) -> tuple[Path, OccupancyGrid]:
    """Write a world of one of `KINDS` and its path; return its file and its cylinders' map."""
    field, path_cells = _passable(*kind, rng)
    world = np.zeros((_FIRST_ROW + _SIZE, _SIZE), np.bool_)
    world[_FIRST_ROW:] = field
    world[:_FIRST_ROW, [0, -1]] = True  # the fence about the start
    world[0] = True
    cells = enumerate(np.argwhere(world).tolist())
    models = (_CYLINDER.format(k, _LEFT + CELL * x, CELL * (y + 0.5)) for k, (y, x) in cells)
    text = f"<sdf version='1.6'><world name='made'>{_GROUND}{''.join(models)}</world></sdf>"
    path = folder / f"world_{number}.world"
    path.write_text(text, encoding="ascii")
    np.save(folder / f"path_{number}.npy", path_cells)
    return path, _map_of(world)


def _map_of(world: Bools, finer: int = 3) -> OccupancyGrid:
    """Return the map of a world's cells, with the open ground before its goal."""
    open_rows = math.ceil((START.y + AHEAD + 1.0) / CELL) - len(world)
    whole = np.kron(np.pad(world, ((0, open_rows), (0, 0))), np.ones((finer, finer)))
    data = np.where(whole > 0, OCCUPIED, FREE).astype(np.int8)
    corner = SE2(_LEFT - 0.5 * CELL, 0.0)
    return OccupancyGrid(GridFrame(CELL / finer, data.shape[1], data.shape[0], corner), data)


def _passable(smoothings: int, fill: float, rng: np.random.Generator) -> tuple[Bools, Ints]:
    """Return a field `(row, column)` and the path's cells `(column, row)`, as files have them."""
    while True:
        field = rng.random((_SIZE, _SIZE)) < fill
        field[:, [0, -1]] = True
        for _ in range(smoothings):
            field = _smoothed(field)
        path_cells = _shortest_path(field)
        if path_cells is not None:
            return field, path_cells


def _smoothed(field: Bools) -> Bools:
    """Fill what has more than four neighbours, empty what has fewer than two; fences are filled."""
    padded = np.pad(field, ((1, 1), (0, 0)))
    padded = np.pad(padded, ((0, 0), (1, 1)), constant_values=True)
    around = convolve(padded.astype(np.int64), np.ones((3, 3), np.int64), mode="constant")
    neighbours = (around - padded)[1:-1, 1:-1]
    kept: Bools = (field | (neighbours > 4)) & (neighbours >= 2)
    return kept


def _shortest_path(field: Bools) -> Ints | None:
    """Return the shortest path five cells wide, None where there is none."""
    wide = binary_dilation(field, np.ones((5, 5)))
    data = np.where(wide, LETHAL, 0).astype(np.uint8)
    middle = round((START.x - _LEFT) / CELL)
    near = [c for c in range(_SIZE) if not wide[0, c]]
    if not near:
        return None
    first = min(near, key=lambda column: abs(column - middle))
    potential = wavefront(data, traversal_costs(), np.array([[0.0, first, 0.0]]))
    last = min(range(_SIZE), key=lambda c: potential[-1, c] + 50.0 * abs(c - middle))
    if not math.isfinite(potential[-1, last]):
        return None
    cells = np.round(descend(potential, (_SIZE - 1, last))[::-1]).astype(np.int64)
    y0, x0 = _BEFORE_PATH
    shift = round((_LEFT - x0) / CELL), round((CELL * (_FIRST_ROW + 0.5) - y0) / CELL)
    return cells[:, ::-1] + shift
