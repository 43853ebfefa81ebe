"""The area that a past submap has seen, and the likelihood of all else."""

from __future__ import annotations

import numpy as np
import pytest

from arjuna_slam.graph.rivals import SeenField
from arjuna_slam.matching.field import Field


def seen_field() -> SeenField:
    """Return a field of a wall along y = 0 from x = 0 to 2 m; its left half has been seen."""
    field = Field(0.1, 0.1)
    points = np.column_stack((np.linspace(0.0, 2.0, 41), np.zeros(41)))
    field.add(points, np.tile((0.0, 1.0), (41, 1)))
    seen = np.zeros(field.score.shape, np.bool_)
    seen[:, : seen.shape[1] // 2] = True
    return SeenField(field, seen)


def test_points_lie_on_seen_ground_where_its_cells_are() -> None:
    ground = seen_field()
    x, y = ground.field.origin
    width = 0.1 * ground.seen.shape[1]
    points = np.array([(x + 0.05, y + 0.05), (x + width - 0.05, y + 0.05), (x - 0.05, y + 0.05)])
    assert ground.field.at(points, ground.seen).tolist() == [True, False, False]
    assert not ground.field.at(
        np.array([(x + 0.05, y - 0.05), (x + 0.05, y + 50.0)]), ground.seen
    ).any()


@pytest.mark.parametrize("reach", [0.0, 0.25, 1.0])
def test_ground_that_was_not_seen_has_one_likelihood(reach: float) -> None:
    ground = seen_field()
    field = ground.neutral(0.5, reach)
    border = int(np.ceil(reach / 0.1))
    rows, columns = ground.seen.shape
    assert field.score.shape == (rows + 2 * border, columns + 2 * border)
    np.testing.assert_allclose(field.origin, ground.field.origin - 0.1 * border)
    inner = field.score[border : border + rows, border : border + columns]
    np.testing.assert_array_equal(inner[ground.seen], ground.field.score[ground.seen])
    assert set(inner[~ground.seen].tolist()) == {127}
    outside = np.ones(field.score.shape, np.bool_)
    outside[border : border + rows, border : border + columns] = False
    assert (field.score[outside] == 127).all()
