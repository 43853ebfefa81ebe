"""The table of poses finds each again by its cell and heading, however many there are."""

from __future__ import annotations

import numpy as np

from arjuna_nav.planners.pose_table import (
    indexed,
    new_table,
    rows_to,
    slot_of,
    with_block,
    with_room,
)

_HEADINGS = 5


def test_an_index_finds_every_row_again() -> None:
    rng = np.random.default_rng(2)
    index = indexed(61, 40, _HEADINGS)
    known: dict[tuple[int, int, int], int] = {}
    for row in range(3000):
        key = int(rng.integers(61)), int(rng.integers(40)), int(rng.integers(_HEADINGS))
        index = with_block(index, *key[:2])
        slot = slot_of(index, *key)
        assert index.slots[slot] == known.get(key, -1)
        index.slots[slot] = known[key] = row
    for key, row in known.items():
        assert index.slots[slot_of(index, *key)] == row


def test_a_table_keeps_its_rows_when_it_grows() -> None:
    table = new_table(np.array([1.0, 2.0, 3.0]), 2)
    for row in range(1, 50):
        table = with_room(table, row, 1)
        table.poses[row] = row
        table.before[row] = row - 1
    np.testing.assert_array_equal(rows_to(table, 49), np.arange(50))
    np.testing.assert_array_equal(table.poses[0], (1.0, 2.0, 3.0))
    np.testing.assert_array_equal(table.poses[1:50, 0], np.arange(1, 50))
