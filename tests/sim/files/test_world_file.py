"""Maps as worlds: their walls, and the bounds on them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from arjuna_core.errors import WorldError
from arjuna_core.files.map_image import MapOptions
from arjuna_core.files.maps import save_map
from arjuna_core.grid import GridFrame, OccupancyGrid
from arjuna_core.se2 import IDENTITY, SE2
from arjuna_sim.files import world_file
from arjuna_sim.files.world_file import WALLS, load_map_world, rectangles


def occupied(*rows: str) -> NDArray[np.bool_]:
    """Return cells, the first row lowest; `#` is occupied."""
    return np.array([[cell == "#" for cell in row] for row in rows])


@pytest.mark.parametrize(
    ("rows", "boxes"),
    [
        (("...", "..."), []),
        (("###", "###"), [(0, 0, 2, 3)]),
        (("#.#",), [(0, 0, 1, 1), (0, 2, 1, 1)]),
        (("##.", "##.", ".##"), [(0, 0, 2, 2), (2, 1, 1, 2)]),
        (("#..", "#..", "###"), [(0, 0, 2, 1), (2, 0, 1, 3)]),
        ((".#.", "...", ".#."), [(0, 1, 1, 1), (2, 1, 1, 1)]),  # a gap ends a run
    ],
)
def test_equal_runs_above_each_other_are_one_box(
    rows: tuple[str, ...], boxes: list[tuple[int, ...]]
) -> None:
    assert list(map(tuple, rectangles(occupied(*rows)).tolist())) == boxes


def test_boxes_cover_what_is_occupied_once() -> None:
    rng = np.random.default_rng(5)
    for _ in range(30):
        cells = rng.random(tuple(rng.integers(1, 12, 2))) < rng.uniform(0.1, 0.9)
        count = np.zeros(cells.shape, int)
        for row, column, rows, columns in rectangles(cells):
            count[row : row + rows, column : column + columns] += 1
        assert (count == cells).all()


def saved(
    folder: Path, data: list[list[int]], origin: SE2 = IDENTITY, mode: str = "trinary"
) -> Path:
    grid = OccupancyGrid(GridFrame(0.5, len(data[0]), len(data), origin), np.array(data, np.int8))
    return save_map(grid, folder / "made", options=MapOptions(mode=mode))[0]


def test_walls_stand_where_the_map_has_them_on_the_floor(tmp_path: Path) -> None:
    path = saved(tmp_path, [[0, 100, 100], [-1, 0, 0]], SE2(1.0, 2.0, np.pi / 2))
    world = load_map_world(path)
    walls = [body for body in world.bodies if body.model == WALLS]
    assert [body.collides for body in walls] == [True, False]
    for body in walls:
        assert body.part.shape.size == pytest.approx((1.0, 0.5, 1.0))
        # The box's middle is 1 m along the map's x and 0.25 m along its y, a quarter turned.
        assert body.part.pose.position == pytest.approx((0.75, 3.0, 0.5))
        assert body.part.pose.planar().theta == pytest.approx(np.pi / 2)
    assert (world.path, world.name) == (path, "made")
    assert len(world.bodies) > len(walls)  # the floor


def test_a_map_of_too_many_walls_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = saved(tmp_path, [[100, 0, 100, 0, 100]])
    monkeypatch.setattr(world_file, "_BOXES_MAX", 3)
    load_map_world(path)
    monkeypatch.setattr(world_file, "_BOXES_MAX", 2)
    with pytest.raises(WorldError, match="has walls of 3 boxes; valid: up to 2"):
        load_map_world(str(path))


def test_a_map_that_is_none_is_the_worlds_error(tmp_path: Path) -> None:
    with pytest.raises(WorldError):
        load_map_world(tmp_path / "none.yaml")


def test_cells_are_walls_from_65_per_cent_on(tmp_path: Path) -> None:
    world = load_map_world(saved(tmp_path, [[64, 65, 0, 100]], mode="raw"))
    walls = [body for body in world.bodies if body.model == WALLS and body.collides]
    assert [body.part.pose.position[0] for body in walls] == [0.75, 1.75]
