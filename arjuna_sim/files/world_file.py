"""Files of worlds: SDF, or a map whose walls are built up from the floor."""

from __future__ import annotations

import re
from collections.abc import Collection
from pathlib import Path

import numpy as np

from arjuna_core.arrays import Bools, Ints
from arjuna_core.errors import MapError, RobotError, WorldError
from arjuna_core.files.input_file import read_bytes
from arjuna_core.files.maps import load_map
from arjuna_core.grid import OccupancyGrid
from arjuna_core.pose3 import Pose3
from arjuna_core.se2 import SE2
from arjuna_sim.files.sdf.includes import Includes
from arjuna_sim.files.sdf.robots_in_world import robots_of
from arjuna_sim.files.sdf.world import read_world
from arjuna_sim.files.search_path import SearchPath
from arjuna_sim.files.urdf.xacro_file import expand, has_macros
from arjuna_sim.files.xml_file import BYTES_MAX, XmlFile
from arjuna_sim.model.geometry.shapes import Kind, Part, Shape
from arjuna_sim.model.world import Body, World, ground_bodies

MAP_SUFFIXES = (".yaml", ".yml")
WALLS = "walls"
_STAGE = re.compile(
    rb"(\s*#.*\n)*\s*(include|define|window|floorplan|resolution|paused|interval_sim)\b"
)
_HEIGHT = 1.0  # [m]
_COLOUR = (0.75, 0.7, 0.6, 1.0)
_BOXES_MAX = 20_000


def load_map_world(path: str | Path) -> World:
    """Read a map's YAML as a world of walls 1 m high on a floor; unknown cells are floor.

    Raises:
        WorldError: The map cannot be read, or its walls are too many to be simulated.
    """
    path = Path(path)
    try:
        grid = load_map(path)
    except MapError as error:
        raise WorldError(error.path, error.problem, error.location) from error
    boxes = rectangles(grid.data >= 65)  # as map_server's occupied_thresh
    if len(boxes) > _BOXES_MAX:
        raise WorldError(path, f"has walls of {len(boxes)} boxes; valid: up to {_BOXES_MAX}")
    walls = [_wall(grid, box) for box in boxes.tolist()]
    bodies = [Body(WALLS, part, collides) for part in walls for collides in (True, False)]
    return World(path, path.stem, (*ground_bodies(), *bodies), ())


def rectangles(occupied: Bools) -> Ints:
    """Cover the occupied cells with few rectangles that do not overlap.

    Runs of cells in a row grow upward as long as the next row has the same run.
    """
    found: list[tuple[int, int, int, int]] = []
    open_runs: dict[tuple[int, int], int] = {}
    padded = np.pad(occupied, ((0, 1), (1, 1))).astype(np.int8)
    for row, edges in enumerate(np.diff(padded, axis=1)):
        starts, ends = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1)
        runs = set(zip(starts.tolist(), ends.tolist(), strict=True))
        for run in sorted(open_runs.keys() - runs):
            first = open_runs.pop(run)
            found.append((first, run[0], row - first, run[1] - run[0]))
        for run in runs - open_runs.keys():
            open_runs[run] = row
    return np.array(sorted(found), np.int64).reshape(-1, 4)


def _wall(grid: OccupancyGrid, box: list[int]) -> Part:
    row, column, rows, columns = box
    cell = grid.frame.resolution
    center = SE2((column + columns / 2) * cell, (row + rows / 2) * cell, 0.0)
    pose = Pose3.from_se2(grid.frame.origin @ center, _HEIGHT / 2)
    return Part(Shape(Kind.BOX, (columns * cell, rows * cell, _HEIGHT)), pose, _COLOUR)


def load_world(
    path: str | Path, search: SearchPath | None = None, without: Collection[str] = ()
) -> World:
    """Read a world from an SDF file, which may have xacro macros, or from a map's YAML.

    Args:
        search: Where to look for what it refers to; the environment's folders if None.
        without: Names of its models that are robots, and no part of it.

    Raises:
        WorldError: The file cannot be read, or holds values or models that cannot be simulated.
    """
    path = Path(path)
    if path.suffix in MAP_SUFFIXES:
        return load_map_world(path)
    return read_world(_opened(path, search), without)


def robots_in(path: str | Path, search: SearchPath | None = None) -> tuple[str, ...]:
    """Return the names of a world's models that drive, in the file's order.

    Args:
        search: As `load_world` takes it.

    Raises:
        WorldError: The file cannot be read.
    """
    path = Path(path)
    if path.suffix in MAP_SUFFIXES:
        return ()
    xml = _opened(path, search)
    includes, world = Includes(xml), xml.root.find("world")
    world = xml.root if world is None else world
    includes.expand(xml, world)
    return tuple(robots_of(xml, includes, world))


def _opened(path: Path, search: SearchPath | None) -> XmlFile:
    text = read_bytes(path, BYTES_MAX, WorldError)
    search = SearchPath.of() if search is None else search
    if _STAGE.match(text):
        remedy = "the YAML of a map (image, resolution, origin) of its bitmap loads instead"
        raise WorldError(path, f"is a world of Stage, not SDF; {remedy}")
    if not has_macros(path, text):
        return XmlFile(path, "sdf", WorldError, text, search)
    try:
        expanded = expand(path, search, {})
    except RobotError as error:
        raise WorldError(error.path, error.problem, error.location) from error
    xml = XmlFile(path, "sdf", WorldError, expanded.text, search)
    xml.keep(*expanded.notes)
    return xml
