"""Grids that move, and sensed layers that are cleared and merged."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from arjuna_core.grid import GridFrame, OccupancyGrid
from arjuna_core.se2 import SE2
from arjuna_nav.costmap import LayeredCostmap
from arjuna_nav.costmap.costmap import FREE, LETHAL, UNKNOWN
from arjuna_nav.costmap.layers.base import SensedLayer, combine, moved
from tests.helpers.nav.layers import costmap_config

OLD = GridFrame(0.5, 6, 4, SE2(1.0, 2.0, 0.3))


def obstacles(track_unknown: bool = False) -> SensedLayer:
    plugins = ("static_layer", "obstacle_layer")
    layered = LayeredCostmap(costmap_config(plugins=plugins, track_unknown_space=track_unknown))
    layered.set_map(OccupancyGrid(OLD, np.zeros(OLD.shape, np.int8)))
    layer = layered.layers["obstacle_layer"]
    assert isinstance(layer, SensedLayer)
    return layer


def numbered() -> NDArray[np.uint8]:
    return np.arange(24, dtype=np.uint8).reshape(4, 6)


@pytest.mark.parametrize("seed", range(8))
def test_what_both_grids_cover_is_kept_where_it_lies(seed: int) -> None:
    rng = np.random.default_rng(seed)
    by = OLD.origin @ SE2(0.5 * int(rng.integers(-8, 9)), 0.5 * int(rng.integers(-6, 7)))
    new = GridFrame(0.5, int(rng.integers(1, 9)), int(rng.integers(1, 9)), by)
    kept = moved(numbered(), OLD, new, 99)
    expected = np.full(new.shape, 99)
    for cell in np.ndindex(*new.shape):
        row, column = OLD.to_cell(*new.to_point(*cell))
        if OLD.contains(row, column):
            expected[cell] = numbered()[row, column]
    np.testing.assert_array_equal(kept, expected)
    assert kept.dtype == np.uint8


def test_a_grid_that_stays_is_the_same_and_one_that_turned_or_is_coarser_is_new() -> None:
    data = numbered()
    assert moved(data, OLD, OLD, 99) is data
    hardly = GridFrame(0.5, 6, 4, OLD.origin @ SE2(0.0, 0.0, 0.08))  # half a cell at its end
    np.testing.assert_array_equal(moved(data, OLD, hardly, 99), data)
    for other in (
        GridFrame(0.5, 6, 4, OLD.origin @ SE2(0.0, 0.0, 0.09)),
        GridFrame(0.5, 6, 4, OLD.origin @ SE2(0.0, 0.0, -0.09)),
        GridFrame(0.25, 6, 4, OLD.origin),
    ):
        assert (moved(data, OLD, other, 99) == 99).all()


@pytest.mark.parametrize("unknown", [False, True])
def test_what_was_seen_is_forgotten_within_a_window_or_outside_it(unknown: bool) -> None:
    window, untouched = (slice(1, 3), slice(2, 5)), 255 if unknown else 0
    inside = np.zeros((4, 6), np.bool_)
    inside[window] = True
    for arguments, forgotten in (
        ((), np.ones((4, 6), np.bool_)),
        ((window,), inside),
        ((window, True), ~inside),
    ):
        layer = obstacles(track_unknown=unknown)
        assert (layer.data == untouched).all()
        layer.data[:] = 254
        layer.clear(*arguments)
        np.testing.assert_array_equal(layer.data, np.where(forgotten, untouched, 254))


@pytest.mark.parametrize("method", [0, 1, 2])
def test_two_layers_combine_by_the_method(method: int) -> None:
    def combined(below: int, own: int) -> int:
        if own == UNKNOWN:
            return below
        if below == UNKNOWN:
            return below if method == 2 else own
        return own if method == 0 else max(own, below)

    known = [FREE, 1, 100, LETHAL, UNKNOWN]
    costs, own = (grid.astype(np.uint8) for grid in np.meshgrid(known, known))
    expected = np.vectorize(combined)(costs, own)
    combine(costs, own, method)
    np.testing.assert_array_equal(costs, expected)


def test_a_layer_keeps_its_cells_on_another_grid() -> None:
    layer = obstacles()
    layer.data[:] = numbered()
    layer.move(GridFrame(0.5, 3, 3, OLD.origin @ SE2(2.0, 1.0)))
    assert layer.data.tolist() == [[16, 17, 0], [22, 23, 0], [0, 0, 0]]
