"""The map's layer: in a window that rolls, by transforms, in parts, and under the robot."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from arjuna_core.grid import GridFrame, OccupancyGrid
from arjuna_core.se2 import SE2
from arjuna_core.transforms import TransformError
from arjuna_nav.costmap import FREE, LETHAL, UNKNOWN, LayeredCostmap
from arjuna_nav.costmap.layers.static import MapUpdate, PlacedMap
from tests.helpers.nav.layers import costmap_config


class Frames:
    """The map's pose in odom; unknown while it is None."""

    T_odom_map: SE2 | None = SE2()

    def lookup(self, target: str, source: str) -> SE2:
        assert (target, source) == ("odom", "map")
        if self.T_odom_map is None:
            raise TransformError("no transform connects 'odom' and 'map'")
        return self.T_odom_map


def random_map(rng: np.random.Generator) -> OccupancyGrid:
    frame = GridFrame(float(rng.choice([0.05, 0.08])), 90, 70, SE2(-2.0, -1.5, 0.4))
    return OccupancyGrid(frame, rng.choice([-1, 0, 100], frame.shape).astype(np.int8))


def rolling(frames: Frames, **values: Any) -> LayeredCostmap:
    config = costmap_config(
        global_frame="odom",
        rolling_window=True,
        width=3,
        height=2,
        resolution=0.05,
        track_unknown_space=True,
        plugins=("static_layer",),
        **values,
    )
    return LayeredCostmap(config, frames.lookup)


@pytest.mark.parametrize("seed", range(6))
def test_a_window_that_rolls_shows_the_map_where_its_frame_is(seed: int) -> None:
    rng = np.random.default_rng(seed)
    frames, grid = Frames(), random_map(rng)
    layered = rolling(frames)
    layered.receive("static_layer", "map", PlacedMap(grid, "map"))
    for k in range(4):
        x, y, yaw = rng.uniform((-2.0, -2.0, -3.0), (2.0, 2.0, 3.0)).tolist()
        frames.T_odom_map = SE2(x, y, yaw)
        x, y = rng.uniform(-2.0, 2.0, 2).tolist()
        layered.update(SE2(x, y, yaw), float(k))
        costs, T_map_odom = layered.costmap, frames.T_odom_map.inverse()
        points = costs.frame.to_points(np.argwhere(np.ones(costs.frame.shape)))
        cells = grid.frame.to_cells(T_map_odom.apply(points))
        inside = grid.frame.inside(cells)
        expected = np.full(len(cells), UNKNOWN)
        rows, columns = cells[inside].T
        expected[inside] = np.choose(grid.data[rows, columns] // 50 + 1, (UNKNOWN, FREE, 0, LETHAL))
        np.testing.assert_array_equal(costs.data.ravel(), expected)
        assert layered.group.problem(float(k)) == ""


def test_what_does_not_move_is_not_composed_again() -> None:
    layered = rolling(Frames())
    layered.receive("static_layer", "map", PlacedMap(random_map(np.random.default_rng(1)), "map"))
    layered.update(SE2(), 0.0)
    layered.take_changed()
    layered.update(SE2(0.001, 0.001), 0.1)
    assert layered.take_changed() is None


def test_a_map_that_cannot_be_placed_is_left_out_and_said() -> None:
    frames = Frames()
    layered = rolling(frames)
    assert layered.group.missing() == "no map has come on /map"
    grid = OccupancyGrid(GridFrame(0.05, 200, 200, SE2(-5.0, -5.0)), np.zeros((200, 200), np.int8))
    layered.receive("static_layer", "map", PlacedMap(grid, "map"))
    assert layered.group.missing() == ""
    for known in (False, True, False):
        frames.T_odom_map = SE2() if known else None
        layered.update(SE2(), 0.0)
        assert (layered.group.problem(0.0) == "") is known
        assert (layered.costmap.data == (FREE if known else UNKNOWN)).all()


def test_what_a_map_showed_goes_with_it() -> None:
    frames, rng = Frames(), np.random.default_rng(1)
    layered = rolling(frames)
    for k, placed in enumerate((True, False)):
        frames.T_odom_map = SE2() if placed else None
        layered.receive("static_layer", "map", PlacedMap(random_map(rng), "map"))
        layered.update(SE2(), float(k))
        assert (layered.costmap.data != UNKNOWN).any() == placed


@pytest.mark.parametrize("frame_id", ["odom", ""])
def test_a_map_in_the_costmaps_own_frame_needs_no_transform(frame_id: str) -> None:
    frames = Frames()
    frames.T_odom_map = None
    layered = rolling(frames)
    grid = OccupancyGrid(GridFrame(0.05, 99, 99, SE2(-2.0, -2.0)), np.zeros((99, 99), np.int8))
    layered.receive("static_layer", "map", PlacedMap(grid, frame_id))
    layered.update(SE2(), 0.0)
    assert (layered.costmap.data == FREE).all()


def fixed(**layer: Any) -> LayeredCostmap:
    layered = LayeredCostmap(
        costmap_config(
            resolution=0.1, robot_radius=0.3, plugins=("static_layer",), static_layer=layer
        )
    )
    layered.set_map(OccupancyGrid(GridFrame(0.1, 40, 30), np.full((30, 40), 100, np.int8)))
    return layered


@pytest.mark.parametrize("rolls", [False, True])
def test_parts_of_a_map_are_taken_where_they_lie_in_it(rolls: bool) -> None:
    layered = rolling(Frames()) if rolls else fixed()
    grid = OccupancyGrid(GridFrame(0.05, 60, 40, SE2(-1.5, -1.0)), np.zeros((40, 60), np.int8))
    layered.set_map(grid, "map")
    layered.update(SE2(), 0.0)
    before = layered.costmap.data.copy()
    for row, column in ((38, 0), (0, 58), (-1, 0), (0, -1)):
        layered.receive("static_layer", "updates", MapUpdate(row, column, np.full((3, 3), 100)))
    layered.update(SE2(), 0.1)
    np.testing.assert_array_equal(layered.costmap.data, before)
    layered.receive("static_layer", "updates", MapUpdate(10, 20, np.full((2, 3), 100)))
    layered.update(SE2(), 0.2)
    assert np.argwhere(layered.costmap.data != before).tolist() == [
        [row, column] for row in (10, 11) for column in (20, 21, 22)
    ]


def test_a_part_of_a_large_map_composes_no_more_than_itself() -> None:
    layered = fixed(footprint_clearing_enabled=True)
    layered.update(SE2(3.0, 1.0), 0.0)
    layered.take_changed()
    layered.receive("static_layer", "updates", MapUpdate(0, 5, np.full((2, 3), -1)))
    layered.update(SE2(3.0, 1.0), 0.1)
    assert layered.costmap.data[0, 5] == layered.costmap.cost_at(3.0, 1.0) == FREE
    rows, columns = layered.take_changed() or (slice(0), slice(0))
    assert (rows.start, columns.start) == (0, 5)
    assert rows.stop < 20
    layered.update(SE2(1.0, 2.0), 0.2)
    windowed = layered.costmap.data.copy()
    layered.compose_again()
    np.testing.assert_array_equal(layered.costmap.data, windowed)
    assert windowed[10, 30] == LETHAL, "where the robot was before"


@pytest.mark.parametrize("restores", [False, True])
def test_the_map_is_free_under_the_robot_and_after_it_if_that_is_asked(restores: bool) -> None:
    layered = fixed(footprint_clearing_enabled=True, restore_cleared_footprint=restores)
    layered.update(SE2(1.0, 1.0), 0.0)
    assert layered.costmap.cost_at(1.01, 1.01) == FREE
    layered.update(SE2(3.0, 1.0), 0.1)
    assert layered.costmap.cost_at(3.01, 1.01) == FREE
    assert layered.costmap.cost_at(1.01, 1.01) == (LETHAL if restores else FREE)
    assert layered.costmap.cost_at(2.0, 2.0) == LETHAL
    still = fixed()
    still.update(SE2(1.0, 1.0), 0.0)
    assert (still.costmap.data == LETHAL).all()


def test_costs_of_a_map_are_scaled_and_its_unknown_value_can_be_another() -> None:
    data = np.array([[-1, 0, 40, 80, 100]], np.int8)
    for values, expected in (
        ({}, [UNKNOWN, FREE, FREE, FREE, LETHAL]),
        ({"lethal_cost_threshold": 80}, [UNKNOWN, FREE, FREE, LETHAL, LETHAL]),
        ({"lethal_cost_threshold": 254}, [UNKNOWN, FREE, FREE, FREE, LETHAL]),
        (
            {"trinary_costmap": False, "lethal_cost_threshold": -5},
            [UNKNOWN, LETHAL, LETHAL, LETHAL, LETHAL],
        ),
        ({"unknown_cost_value": -1}, [UNKNOWN, FREE, FREE, FREE, LETHAL]),
        ({"unknown_cost_value": 40}, [LETHAL, FREE, UNKNOWN, FREE, LETHAL]),
        (
            {"trinary_costmap": False, "lethal_cost_threshold": 80},
            [UNKNOWN, FREE, 127, LETHAL, LETHAL],
        ),
    ):
        config = costmap_config(plugins=("static_layer",), track_unknown_space=True, **values)
        layered = LayeredCostmap(config)
        layered.set_map(OccupancyGrid(GridFrame(1.0, 5, 1), data))
        assert layered.costmap.data[0].tolist() == expected
