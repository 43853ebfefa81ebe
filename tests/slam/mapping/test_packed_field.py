"""Claims: a field is the same after a rest, and takes little room in it."""

from __future__ import annotations

import numpy as np
import pytest

from arjuna_slam.mapping.submap import PackedField
from arjuna_slam.matching.field import Field

WALL = np.column_stack((np.arange(0.0, 40.0, 0.05), np.full(800, 0.02)))
UP = np.tile((0.0, 1.0), (800, 1))


@pytest.mark.parametrize("walls", [1, 4, 16])
def test_a_field_unpacked_is_the_field(walls: int) -> None:
    field = Field(0.05, 0.05)
    for k in range(walls):
        field.add(WALL + np.array([0.0, float(k)]), UP)
        field.add(WALL[:20] * 0.3 + np.array([1.0, k + 0.5]), np.zeros((20, 2)))  # no surface
    field.trim()
    packed = PackedField.of(field)
    unpacked = packed.unpacked()
    assert np.array_equal(unpacked.score, field.score)
    assert np.array_equal(unpacked.origin, field.origin)
    assert np.array_equal(unpacked.planes[unpacked.index], field.planes[field.index])
    assert np.array_equal(unpacked.surface(), field.surface())


def test_a_field_at_rest_takes_the_room_of_its_walls_alone() -> None:
    field = Field(0.05, 0.05)
    for k in (0.0, 39.0):
        field.add(WALL + np.array([0.0, k]), UP)
    field.trim()
    packed = PackedField.of(field)
    kept = sum(each.nbytes for each in vars(packed).values() if isinstance(each, np.ndarray))
    assert kept < 0.2 * (field.score.nbytes + field.index.nbytes)
