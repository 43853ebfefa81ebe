"""Worlds of the BARN challenge, and ones like them made up by a cellular automaton."""

from __future__ import annotations

import itertools
import lzma
import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation, convolve

from arjuna_core.errors import InputFileError
from arjuna_core.se2 import SE2
from arjuna_nav.costmap.costmap import LETHAL
from arjuna_nav.planners.waves.descent import descend
from arjuna_nav.planners.waves.potential import spread, traversal_costs
from tests.helpers.nav.drives import files_in

START = SE2(-2.25, 3.0, math.pi / 2.0)
AHEAD = 10.0  # from the start to the goal [m]
REACHED = 1.0  # distance from the goal that counts as reached [m]
TIME_LIMIT = 100.0  # [s]
FASTEST = 2.0  # speed that the optimal time is reckoned with [m/s]
CELL = 0.15  # of the path files [m]


@dataclass(frozen=True)
class BarnWorld:
    """One world.

    Attributes:
        name: As `world_0`.
        world: Its SDF, unpacked.
        optimal: Length of the path that came with it, from the start to the goal [m].
    """

    name: str
    world: Path
    optimal: float

    def score(self, time: float | None) -> float:
        """Return the score of a run that took a time [s]; None for one that failed."""
        best = self.optimal / FASTEST
        return 0.0 if time is None else best / min(max(time, 2.0 * best), 8.0 * best)


def load_worlds(folder: Path, unpacked: Path, every: int = 1) -> list[BarnWorld]:
    """Return the worlds of a folder: `world_N.world[.xz]` with `path_N.npy` beside or below it.

    Args:
        folder: What was given: the worlds' own folder or the one above.
        unpacked: Where unpacked worlds are put.
        every: Only each so manieth of them.
    """
    patterns = ("world_*.world", "world_*.world.xz")
    paths = next((f for f in (files_in(d, patterns) for d in (folder, folder / "worlds")) if f), [])
    if not paths:
        problem = f"holds no world; valid: {' or '.join(patterns)}, here or in worlds/"
        raise InputFileError(folder, problem)
    return [_load(path, unpacked) for path in paths[::every]]


def _load(path: Path, unpacked: Path) -> BarnWorld:
    name = path.name.split(".")[0]
    world = path
    if path.suffix == ".xz":
        world = unpacked / path.stem
        world.write_bytes(lzma.decompress(path.read_bytes()))
    return BarnWorld(name, world, _optimal(path, name.removeprefix("world_")))


def _optimal(path: Path, number: str) -> float:
    """Return the length of a world's path with what leads from the start to it and to the goal."""
    folders = (path.parent, path.parent / "path_files", path.parent.parent / "path_files")
    found = [f / f"path_{number}.npy" for f in folders if (f / f"path_{number}.npy").is_file()]
    if not found:
        raise InputFileError(path, f"has no path_{number}.npy beside it or in path_files/")
    cells = np.load(found[0], allow_pickle=False).astype(np.float64)
    points = cells * CELL + (-4.575, 5.075)
    ends = np.array([[START.x, START.y], [START.x, START.y + AHEAD]])
    path_cells = np.vstack((ends[:1], points, ends[1:]))
    return float(np.hypot(*np.diff(path_cells, axis=0).T).sum())


_SIZE = 30  # of the field [cells]
_FIRST_ROW = 34  # of the field, counted from where the fence begins
_LEFT = -4.425  # x of the first column's centres [m]
_BEFORE_PATH = 5.075, -4.575  # y and x of the cell (0, 0) of path files [m]
_FILLS = (0.15, 0.20, 0.25, 0.30)
_SMOOTHINGS = (2, 3, 4)
_CYLINDER = (
    "<model name='unit_cylinder_{}'><static>1</static><pose>{:.3f} {:.3f} 0.5 0 0 0</pose>"
    "<link name='link'><collision name='collision'><geometry><cylinder><radius>0.075</radius>"
    "<length>1</length></cylinder></geometry></collision></link></model>"
)
_GROUND = "<include><uri>model://ground_plane</uri></include>"


def make_worlds(folder: Path, count: int, rng: np.random.Generator) -> Path:
    """Write worlds `world_N.world` and their `path_N.npy` into a folder, and return it.

    Args:
        folder: Where to.
        count: How many; their fills and smoothings take turns.
        rng: Where chance comes from.
    """
    kinds = itertools.cycle(itertools.product(_SMOOTHINGS, _FILLS))
    for number, (smoothings, fill) in zip(range(count), kinds, strict=False):
        field, path_cells = _passable(fill, smoothings, rng)
        models = (_CYLINDER.format(i, x, y) for i, (x, y) in enumerate(_cylinders(field)))
        text = f"<sdf version='1.6'><world name='made'>{_GROUND}{''.join(models)}</world></sdf>"
        (folder / f"world_{number}.world").write_text(text, encoding="ascii")
        np.save(folder / f"path_{number}.npy", path_cells)
    return folder


def _passable(
    fill: float, smoothings: int, rng: np.random.Generator
) -> tuple[NDArray[np.bool_], NDArray[np.int64]]:
    """Return a field `(row, column)` and the path's cells `(column, row)`, as files have them."""
    while True:
        field = rng.random((_SIZE, _SIZE)) < fill
        field[:, [0, -1]] = True
        for _ in range(smoothings):
            field = _smoothed(field)
        path_cells = _shortest_path(field)
        if path_cells is not None:
            return field, path_cells


def _smoothed(field: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Fill what has more than four neighbours, empty what has fewer than two; fences are filled."""
    padded = np.pad(field, ((1, 1), (0, 0)))
    padded = np.pad(padded, ((0, 0), (1, 1)), constant_values=True)
    around = convolve(padded.astype(np.int64), np.ones((3, 3), np.int64), mode="constant")
    neighbours = (around - padded)[1:-1, 1:-1]
    kept: NDArray[np.bool_] = (field | (neighbours > 4)) & (neighbours >= 2)
    return kept


def _shortest_path(field: NDArray[np.bool_]) -> NDArray[np.int64] | None:
    """Return the shortest path five cells wide, None where there is none."""
    wide = binary_dilation(field, np.ones((5, 5)))
    data = np.where(wide, LETHAL, 0).astype(np.uint8)
    middle = round((START.x - _LEFT) / CELL)
    near = [c for c in range(_SIZE) if not wide[0, c]]
    if not near:
        return None
    first = min(near, key=lambda column: abs(column - middle))
    potential = spread(data, traversal_costs(), np.array([[0.0, first, 0.0]]))
    last = min(range(_SIZE), key=lambda c: potential[-1, c] + 50.0 * abs(c - middle))
    if not math.isfinite(potential[-1, last]):
        return None
    cells = np.round(descend(potential, (_SIZE - 1, last))[::-1]).astype(np.int64)
    y0, x0 = _BEFORE_PATH
    shift = round((_LEFT - x0) / CELL), round((CELL * (_FIRST_ROW + 0.5) - y0) / CELL)
    return cells[:, ::-1] + shift


def _cylinders(field: NDArray[np.bool_]) -> Iterator[tuple[float, float]]:
    """Return the positions of a world's cylinders: the field's, and the fence about the start."""
    world = np.zeros((_FIRST_ROW + _SIZE, _SIZE), np.bool_)
    world[_FIRST_ROW:] = field
    world[:_FIRST_ROW, [0, -1]] = True
    world[0] = True
    for row, column in np.argwhere(world):
        yield _LEFT + CELL * float(column), CELL * (float(row) + 0.5)
