"""Claims: a field knows its surface however much of it there is, and is the same after a rest."""

from __future__ import annotations

import numpy as np
import pytest

from arjuna_slam.matching.field import Field
from arjuna_slam.matching.packed_field import PackedField

WALL = np.column_stack((np.arange(0.0, 40.0, 0.05), np.full(800, 0.02)))
UP = np.tile((0.0, 1.0), (800, 1))


@pytest.mark.parametrize(("walls", "planes_in_16_bits"), [(4, True), (16, False)])
def test_every_wall_is_found_again(walls: int, planes_in_16_bits: bool) -> None:
    field = Field(0.05, 0.05)
    for k in range(walls):
        field.add(WALL + np.array([0.0, float(k)]), UP)
    field.trim()
    assert (len(field.planes) < 1 << 16) is planes_in_16_bits
    points, normals = field.surface()
    found, counts = np.unique(np.round(points[:, 1]), return_counts=True)
    assert found.tolist() == list(range(walls))
    assert counts.min() == counts.max() >= 790
    assert np.allclose(normals, (0.0, 1.0), atol=1e-6)


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
