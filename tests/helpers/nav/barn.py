"""Worlds of the BARN challenge: where they lie, where one starts, and how a run is scored.

Source: Perille et al., Benchmarking metric ground navigation, SSRR 2020; the rules of the BARN
challenge at ICRA: score = success * OT / clip(AT, 2 OT, 8 OT).
"""

from __future__ import annotations

import lzma
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from arjuna_core.errors import InputFileError
from arjuna_core.se2 import SE2
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
        optimal: Length of the way that came with it, from the start to the goal [m].
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

    Raises:
        InputFileError: There is none, or one has no path.
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
    way = np.vstack((ends[:1], points, ends[1:]))
    return float(np.hypot(*np.diff(way, axis=0).T).sum())
