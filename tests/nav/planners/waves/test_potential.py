"""Waves of costs over the grid, and within corridors."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray

from arjuna_nav.planners.waves.corridor import corridors, guided
from arjuna_nav.planners.waves.descent import descend
from arjuna_nav.planners.waves.potential import reachable, traversal_costs, wavefront
from tests.helpers.nav.navfn_maps import inflated, maze

Cells = NDArray[np.uint8]
COSTS = traversal_costs()
MAPS = range(24)


def random_map(seed: int) -> tuple[Cells, NDArray[np.int64]]:
    """Return a map of boxes, of unknown cells and of costs, and two of its open cells."""
    rng = np.random.default_rng(seed)
    height, width = rng.integers(30, 120, 2)
    data = np.zeros((height, width), np.uint8)
    for row, column in rng.integers(0, (height, width), (height // 3, 2)):
        rows, columns = rng.integers(1, 9, 2)
        data[row : row + rows, column : column + columns] = 254
    if seed % 2:
        inflated(data)
    if seed % 3 == 0:
        data[rng.random(data.shape) < 0.02] = 255
    free = np.argwhere(data < 253)
    return data, free[rng.integers(len(free), size=2)]


@cache
def formula(seed: int) -> NDArray[np.float64]:
    """Return the potential of a random map about its first cell by the formula alone."""
    data, (start, _) = random_map(seed)
    return plain_potential(data, COSTS, np.array([[*start, 0.0]]))


def cost_along(path: NDArray[np.float64], data: Cells) -> float:
    """Return what a path costs that is looked at every eighth of a cell."""
    parts = np.linspace(0.0, 1.0, 5)[:-1, None, None]
    points = (path[:-1] + parts * np.diff(path, axis=0)).reshape(-1, 2)
    costs = np.minimum(COSTS[data[tuple(np.floor(points + 0.5).astype(int).T)]], 252.0)
    lengths = np.hypot(*np.diff(path, axis=0).T)
    return float((np.tile(lengths / len(parts), len(parts)) * costs).sum())


@pytest.mark.parametrize("seed", MAPS[:8])
def test_a_wave_is_that_of_the_formula(seed: int) -> None:
    data, (start, goal) = random_map(seed)
    seeds = np.array([[*start, 0.0]])
    found, plain = wavefront(data, COSTS, seeds), formula(seed)
    np.testing.assert_array_equal(np.isfinite(found), np.isfinite(plain))
    np.testing.assert_array_equal(np.isfinite(found), reachable(data, COSTS, seeds))
    there = np.isfinite(plain) & (plain > 0.0)
    ratios = found[there] / plain[there]  # the fit falls by 0.5 % where its one neighbour counts
    assert 0.995 < ratios.min() <= ratios.max() < 1.05
    assert ratios.mean() < 1.01
    stopped = wavefront(data, COSTS, seeds, (int(goal[0]), int(goal[1])))
    if np.isfinite(plain[tuple(goal)]):
        settled = found <= found[tuple(goal)]
        np.testing.assert_array_equal(stopped[settled], found[settled])


def test_paths_cost_what_those_of_the_formula_cost() -> None:
    ratios_of_cost = []
    for seed in MAPS:
        data, (start, goal) = random_map(seed)
        seeds, end = np.array([[*start, 0.0]]), (int(goal[0]), int(goal[1]))
        plain = formula(seed).astype(np.float32)
        if np.isfinite(plain[end]) and np.hypot(*(start - goal)) > 20.0:
            paths = [descend(found, end) for found in (wavefront(data, COSTS, seeds, end), plain)]
            ratios_of_cost.append(cost_along(paths[0], data) / cost_along(paths[1], data))
    assert len(ratios_of_cost) > 8
    assert np.mean(ratios_of_cost) < 1.003
    assert max(ratios_of_cost) < 1.03


def test_several_seeds_keep_what_they_cost() -> None:
    data = np.zeros((40, 40), np.uint8)
    seeds = np.array([[5.0, 5.0, 0.0], [35.0, 35.0, 900.0]])
    found = wavefront(data, COSTS, seeds)
    plain = plain_potential(data, COSTS, seeds)
    np.testing.assert_allclose(found, plain, rtol=0.03)
    assert found[35, 35] == 900.0
    assert found[5, 5] == 0.0
    assert np.isfinite([COSTS[255], traversal_costs(False)[255]]).tolist() == [True, False]


def plain_potential(
    data: NDArray[np.uint8], costs: NDArray[np.float32], seeds: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return what `wavefront` returns, `(height, width) float64`, by the formula alone."""
    cost = np.pad(costs[data].astype(np.float64), 1, constant_values=np.inf)
    values = np.full(cost.shape, np.inf)
    rows, columns = seeds[:, :2].astype(int).T + 1
    values[rows, columns] = seeds[:, 2]
    middle, open_ = (slice(1, -1), slice(1, -1)), np.isfinite(cost[1:-1, 1:-1])
    while True:
        across = np.minimum(values[1:-1, :-2], values[1:-1, 2:])
        along = np.minimum(values[:-2, 1:-1], values[2:, 1:-1])
        low = np.minimum(across, along)
        with np.errstate(invalid="ignore"):
            ratio = np.abs(across - along) / cost[middle]
            fit = 0.7040 + 0.5307 * ratio - 0.2301 * ratio**2
            fitted = low + cost[middle] * np.where(ratio < 1.0, fit, 1.0)
        found = np.where(open_ & (fitted < values[middle] - 1e-9), fitted, values[middle])
        if (found == values[middle]).all():
            return found
        values[middle] = found


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


@pytest.mark.parametrize("seed", range(3))
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


@pytest.mark.parametrize("seed", range(6))
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
