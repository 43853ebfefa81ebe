"""Corridors about the likely path: as good a path leads through one as through the whole map."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from arjuna_nav.planners.waves.corridor import corridors, guided
from arjuna_nav.planners.waves.potential import reachable, traversal_costs, wavefront
from tests.helpers.nav.navfn_maps import maze

Cells = NDArray[np.uint8]
COSTS = traversal_costs()


def clutter(seed: int, size: int = 400) -> Cells:
    """Return random blocks with costly cells beside them; two opposite corners are free."""
    rng = np.random.default_rng(seed)
    data = np.zeros((size, size), np.uint8)
    for row, column in rng.integers(0, size - 20, (150, 2)):
        height, width = rng.integers(4, 30, 2)
        data[max(row - 6, 0) : row + height + 6, max(column - 6, 0) : column + width + 6] |= 100
    for row, column in rng.integers(0, size - 20, (150, 2)):
        height, width = rng.integers(4, 30, 2)
        data[row : row + height, column : column + width] = 254
    data[:10, :10] = data[-10:, -10:] = 0
    return data


@pytest.mark.parametrize("seed", range(6))
def test_a_corridor_holds_a_path_as_good_as_any(seed: int) -> None:
    data = clutter(seed)
    start, goal = (2, 2), (397, 397)
    seeds = np.array([[*start, 0.0]])
    best = wavefront(data, COSTS, seeds, goal)[goal]
    found = corridors(data, COSTS, start, goal, 0.01)
    assert found is not None
    assert [one.shift for one in found] == [2, 3]
    assert 0.01 < found[0].open.mean() < found[1].open.mean() < 0.7
    through = guided(
        lambda one: wavefront(data, COSTS, seeds, goal, one.open, one.shift),
        lambda potential: float(potential[goal]),
        found,
    )
    assert 0.999 * best <= through[goal] <= 1.02 * best  # which cell comes first counts a little
    assert np.isfinite(through).sum() < np.isfinite(wavefront(data, COSTS, seeds, goal)).sum()


@pytest.mark.parametrize("seed", range(12))
def test_a_corridor_says_that_no_path_is_where_none_is(seed: int) -> None:
    rng = np.random.default_rng(seed)
    data = np.zeros((300, 300), np.uint8)
    at = int(rng.integers(100, 180))
    data[at : at + int(rng.integers(1, 12))] = 254
    if seed % 2:
        data[at : at + 12, 40:43] = 0
    start, goal = (10, 10), (290, 290)
    open_ = bool(reachable(data, COSTS, np.array([[*start, 0.0]]))[goal])
    assert open_ == bool(seed % 2)
    if corridors(data, COSTS, start, goal, 0.0) is None:
        assert not open_
    data[goal] = 254
    assert corridors(data, COSTS, start, goal, 0.0) is None


def test_walls_too_thin_for_the_coarse_grid_make_no_corridor() -> None:
    data = maze(300, 4, 1, 0)
    assert corridors(data, COSTS, (2, 2), (292, 292), 0.0) == ()
