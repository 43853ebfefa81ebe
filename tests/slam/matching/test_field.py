"""Claims: a field knows its surface however much of it there is."""

from __future__ import annotations

import numpy as np
import pytest

from arjuna_slam.matching.field import Field

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
