"""Worlds of the BARN challenge, from their files."""

from __future__ import annotations

import lzma
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from arjuna_core.errors import InputFileError
from bringup.scenarios.barn import AHEAD, CELL, START

REACHED = 1.0  # distance from the goal that counts as reached [m]
TIME_LIMIT = 100.0  # [s]
FASTEST = 2.0  # speed that the optimal time is reckoned with [m/s]


@dataclass(frozen=True)
class BarnWorld:
    """One world.

    Attributes:
        name: As `world_0`.
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


def files_in(folder: Path, patterns: tuple[str, ...]) -> list[Path]:
    """Return the files of a folder by patterns, in the order of the numbers in their names."""
    found = [path for pattern in patterns for path in folder.glob(pattern)]
    return sorted(found, key=lambda path: (len(path.name), path.name))
