"""The made-up furnished room: one seed, one room, and less is seen than there is."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from arjuna_core.files.maps import load_map
from arjuna_core.grid import OCCUPIED
from tests.helpers.nav.furnished import make_room


def test_one_seed_makes_one_room_of_which_the_lidar_sees_a_part(tmp_path: Path) -> None:
    rooms = []
    for name in ("a", "b"):
        folder = tmp_path / name
        folder.mkdir()
        rooms.append(make_room(folder, np.random.default_rng(3)))
    assert rooms[0].world.read_bytes() == rooms[1].world.read_bytes()
    seen = load_map(rooms[0].seen).data == OCCUPIED
    whole = load_map(rooms[0].whole).data == OCCUPIED
    assert not (seen & ~whole).any()
    assert whole.sum() > 1.3 * seen.sum()


def test_its_map_lies_where_the_room_does(tmp_path: Path) -> None:
    grid = load_map(make_room(tmp_path, np.random.default_rng(3)).seen)
    walls = np.flatnonzero((grid.data == OCCUPIED).mean(axis=0) > 0.5)
    x = grid.frame.to_points(np.column_stack((walls, walls)))[:, 0]
    np.testing.assert_allclose(x, (-5.025, -4.975, 4.975, 5.025))
