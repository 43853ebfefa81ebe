"""Costmap layers: map, marking and clearing, inflation, rolling."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import ndimage

from arjuna_core.grid import GridFrame
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_nav.costmap import Costmap, CostmapConfig, LayeredCostmap, PlacedScan
from arjuna_nav.costmap.costmap import LETHAL, occupancy_of
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.costmap.inflation import Inflation, cost_at_distance
from arjuna_nav.costmap.layers.static import interpret_map
from tests.helpers.nav.layers import costmap_config, scans, see
from tests.nav.worlds import empty_grid, grid_of, room, scan_from

ORIGINS = [SE2(), SE2(-2.0, 1.5), SE2(0.0, 0.0, math.pi / 2), SE2(3.0, -1.0, 0.7)]


def local(**values: object) -> LayeredCostmap:
    config = costmap_config(
        rolling_window=True,
        resolution=0.05,
        width=3,
        height=3,
        plugins=("obstacle_layer",),
        obstacle_layer=scans(values),
    )
    return LayeredCostmap(config)


def one_beam(distance: float, angle: float = 0.0) -> Scan:
    return Scan(np.array([distance]), angle, 0.01, 0.1, 12.0)


@pytest.mark.parametrize("origin", ORIGINS)
def test_inflates_by_nav2s_formula_wherever_the_grid_lies(origin: SE2) -> None:
    grid = empty_grid(1.5, 1.5, origin)
    grid.data[15, 15] = 100
    config = costmap_config(
        resolution=0.05,
        robot_radius=0.2,
        footprint_padding=0.0,
        plugins=("static_layer", "inflation_layer"),
        inflation_layer={"inflation_radius": 0.5, "cost_scaling_factor": 4.0},
    )
    layered = LayeredCostmap(config)
    layered.set_map(grid)
    for cells in range(11):
        x, y = grid.frame.to_point(15, 15 + cells)
        distance = cells * 0.05
        beyond = int(252 * math.exp(-4.0 * (distance - 0.2)))
        expected = 254 if cells == 0 else 253 if distance <= 0.2 + 1e-12 else beyond
        assert layered.costmap.cost_at(x, y) == expected, cells
    x, y = grid.frame.to_point(15, 15 + 11)
    assert layered.costmap.cost_at(x, y) == 0


def test_inflation_equals_a_distance_transform() -> None:
    rng = np.random.default_rng(3)
    data = np.where(rng.random((60, 70)) < 0.02, 254, 0).astype(np.uint8)
    data[20:30, 40:55] = 254
    distances = ndimage.distance_transform_edt(data != 254) * 0.05
    near = distances <= 0.6 + 1e-9
    expected = np.zeros_like(data)
    expected[near] = [cost_at_distance(d, 0.25, 3.0) for d in distances[near]]
    Inflation(0.6, 3.0, 0.25, 0.05).apply(data)
    np.testing.assert_array_equal(data, expected)


def test_a_maps_cells_become_costs() -> None:
    data = np.array([[-1, 0, 50, 100]], dtype=np.int8)
    assert list(interpret_map(data, CostmapConfig(track_unknown_space=True))[0]) == [255, 0, 0, 254]
    assert list(interpret_map(data, CostmapConfig())[0]) == [0, 0, 0, 254]
    scaled = CostmapConfig(track_unknown_space=True, trinary_costmap=False)
    assert list(interpret_map(data, scaled)[0]) == [255, 0, 127, 254]


@pytest.mark.parametrize("bad", [math.nan, -math.inf, 0.05])
def test_invalid_ranges_neither_mark_nor_clear(bad: float) -> None:
    layered = local()
    see(layered, SE2(), 0.0, [PlacedScan(one_beam(1.02), SE2())])
    see(layered, SE2(), 0.1, [PlacedScan(one_beam(bad), SE2())])
    row, column = layered.costmap.frame.to_cell(0.001, 0.001)
    assert np.flatnonzero(layered.costmap.data[row, column:]).tolist() == [20]


def test_a_rolling_window_keeps_obstacles_where_they_are() -> None:
    layered = local()
    see(layered, SE2(0.03, 0.01), 0.0, [PlacedScan(one_beam(1.02), SE2())])
    for k in range(40):
        layered.update(SE2(0.013 * k, -0.011 * k), 0.1 * k)
        marked = np.argwhere(layered.costmap.data == 254)
        assert len(marked) == 1
        x, y = layered.costmap.frame.to_point(*(int(v) for v in marked[0]))
        assert (x, y) == pytest.approx((1.025, 0.025), abs=1e-9)
    layered.update(SE2(-2.0, 0.0), 9.0)
    layered.update(SE2(), 9.1)
    assert not layered.costmap.data.any(), "what left the window is forgotten"


def test_an_inflation_within_the_footprint_is_told() -> None:
    """Students' files have radii of 0.32 m and inflation of 0.2 m; Nav2 logs it as an error."""
    layered = LayeredCostmap(
        costmap_config(
            rolling_window=True,
            robot_radius=0.32,
            plugins=("inflation_layer",),
            inflation_layer={"inflation_radius": 0.2},
        )
    )
    (warning,) = layered.warnings()
    assert warning.startswith("inflation_layer: inflation_radius 0.2 m is less than the inscribed")
    layered.set_footprint(Footprint.circle(0.15))
    assert layered.warnings() == []


def test_obstacles_keep_their_position_when_the_map_grows() -> None:
    config = costmap_config(resolution=0.05, plugins=("static_layer", "obstacle_layer"))
    layered = LayeredCostmap(config)
    layered.set_map(empty_grid(3.0, 3.0, SE2(-1.5, -1.5)))
    layered.update(SE2(2.0, 0.0), 0.0)
    (warning,) = layered.warnings()
    assert warning.startswith("the robot is outside the costmap's grid, which spans x -1.50 to")
    layered.update(SE2(), 0.0)
    assert layered.warnings() == []
    see(layered, SE2(), 0.0, [PlacedScan(one_beam(1.02), SE2())])
    layered.set_map(empty_grid(6.0, 5.0, SE2(-3.5, -2.5)))
    assert layered.costmap.cost_at(1.02, 0.001) == 254
    assert np.count_nonzero(layered.costmap.data) == 1


def test_clearing_forgets_obstacles_but_never_the_map() -> None:
    grid = grid_of(6.0, 6.0, (5.0, 0.0, 0.1, 6.0), origin=SE2(-3.0, -3.0))
    config = costmap_config(resolution=0.05, plugins=("static_layer", "obstacle_layer"))

    def marked() -> LayeredCostmap:
        layered = LayeredCostmap(config)
        layered.set_map(grid)
        seen = [PlacedScan(one_beam(0.52), SE2()), PlacedScan(one_beam(1.52, math.pi), SE2())]
        see(layered, SE2(), 0.0, seen)
        return layered

    for clear, near, far in (
        (lambda c: c.clear_entirely(), 0, 0),
        (lambda c: c.clear_around(SE2(), 2.0), 0, 254),
        (lambda c: c.clear_except(SE2(), 2.0), 254, 0),
    ):
        layered = marked()
        clear(layered)
        assert layered.costmap.cost_at(0.52, 0.001) == near
        assert layered.costmap.cost_at(-1.52, 0.001) == far
        assert layered.costmap.cost_at(2.05, 0.001) == 254


def test_what_the_map_blocks_is_blocked_for_good_and_what_was_seen_is_not() -> None:
    grid = grid_of(6.0, 6.0, (5.0, 0.0, 0.1, 6.0), origin=SE2(-3.0, -3.0))
    layered = LayeredCostmap(costmap_config(robot_radius=0.2))
    layered.set_map(grid)
    see(layered, SE2(), 0.0, [PlacedScan(one_beam(0.52), SE2())])
    seen, beside_wall, outside = SE2(0.52), SE2(1.85), SE2(9.0)
    assert layered.costmap.cost_at(seen.x, 0.001) == 254
    assert layered.costmap.cost_at(beside_wall.x, 0.001) == 253
    forever = [layered.is_blocked_for_good(pose) for pose in (seen, beside_wall, outside)]
    assert forever == [False, True, False]


@pytest.mark.parametrize(
    ("away", "side", "cost"), [(1.0, 1, 0), (1.05, 1, 254), (1.0, -1, 0), (1.04, -1, 254)]
)
def test_a_square_is_cleared_to_its_last_cell(away: float, side: int, cost: int) -> None:
    config = costmap_config(resolution=0.05, plugins=("static_layer", "obstacle_layer"))
    layered, pose = LayeredCostmap(config), SE2(0.02, 0.02)
    layered.set_map(empty_grid(6.0, 6.0, SE2(-3.0, -3.0)))
    see(layered, pose, 0.0, [PlacedScan(one_beam(away, side * math.pi / 2), pose)])
    assert layered.costmap.cost_at(0.02, 0.02 + side * away) == 254
    layered.clear_around(pose, 2.0)
    assert layered.costmap.cost_at(0.02, 0.02 + side * away) == cost


def test_a_whole_room_agrees_with_its_map() -> None:
    grid = room()
    config = costmap_config(
        resolution=0.05,
        track_unknown_space=True,
        plugins=("static_layer", "obstacle_layer"),
        obstacle_layer=scans({"obstacle_max_range": 12.0, "raytrace_max_range": 12.0}),
    )
    layered = LayeredCostmap(config)
    layered.set_map(grid)
    for x, y, yaw in ((0.0, 0.0, 0.0), (-3.0, 1.0, 1.0), (2.0, -4.0, 3.0)):
        pose = SE2(x, y, yaw)
        see(layered, pose, 0.0, [PlacedScan(scan_from(grid, pose), pose)])
    np.testing.assert_array_equal(layered.costmap.data == 254, grid.occupied())


def test_costs_become_nav2s_occupancy() -> None:
    costs = np.array([[0, 1, 126, 252, 253, 254, 255]], dtype=np.uint8)
    assert occupancy_of(costs).tolist() == [[0, 1, 49, 98, 99, 100, -1]]


def test_a_costmap_seen_from_another_frame_lies_where_it_did() -> None:
    costs = np.zeros((20, 20), dtype=np.uint8)
    costs[3, 7] = 200
    costmap = Costmap(GridFrame(0.1, 20, 20, SE2(-1.0, -1.0)), costs)
    T_map_odom = SE2(5.0, -2.0, 0.8)
    x, y = T_map_odom.apply(np.array([costmap.frame.to_point(3, 7)]))[0]
    assert costmap.seen_from(T_map_odom).cost_at(x, y) == 200


@pytest.mark.parametrize("unknown", [False, True])
@pytest.mark.parametrize("seed", range(4))
def test_what_changes_in_a_window_is_as_if_all_were_composed(seed: int, unknown: bool) -> None:
    rng = np.random.default_rng(seed)
    config = costmap_config(
        resolution=0.05,
        robot_radius=0.2,
        track_unknown_space=unknown,
        inflation_layer={"inflation_radius": 0.5},
    )
    layered = LayeredCostmap(config)
    layered.set_map(room())
    layered.take_changed()
    for k in range(12):
        x, y, yaw = rng.uniform((-5.4, -5.4, -3.0), (5.4, 5.4, 3.0)).tolist()
        pose = SE2(x, y, yaw)
        ranges = rng.uniform(0.1, 4.0, 40)
        ranges[rng.random(40) < 0.2] = math.inf
        seen = [PlacedScan(Scan(ranges, -math.pi, 0.16, 0.1, 12.0), pose)] if k % 4 else []
        before = layered.costmap.data.copy()
        see(layered, pose, 0.1 * k, seen)
        windowed = layered.costmap.data.copy()
        changed = layered.take_changed()
        if changed is not None:
            before[changed] = windowed[changed]
        np.testing.assert_array_equal(before, windowed, "nothing has changed elsewhere")
        layered.set_footprint(layered.footprint)
        np.testing.assert_array_equal(layered.costmap.data, windowed)
        layered.take_changed()


def test_a_scan_that_says_nothing_new_changes_nothing() -> None:
    layered = LayeredCostmap(costmap_config(resolution=0.05))
    layered.set_map(empty_grid(6.0, 6.0, SE2(-3.0, -3.0)))
    scan = PlacedScan(one_beam(1.02), SE2())
    see(layered, SE2(), 0.0, [scan])
    assert layered.take_changed() is not None
    see(layered, SE2(), 0.1, [scan])
    assert layered.take_changed() is None
    assert layered.costmap.stamp == 0.1
    see(layered, SE2(), 0.2, [PlacedScan(one_beam(1.07), SE2())])
    rows, columns = layered.take_changed() or (slice(0), slice(0))
    assert (rows.stop - rows.start, columns.stop - columns.start) == (23, 24)


@pytest.mark.parametrize("layers", [("obstacle_layer",), ("voxel_layer",)])
def test_other_parameters_count_at_once_and_what_was_seen_is_kept(layers: tuple[str]) -> None:
    def config(radius: float, **values: object) -> CostmapConfig:
        return costmap_config(
            rolling_window=True,
            resolution=0.05,
            width=3,
            height=3,
            plugins=(*layers, "inflation_layer"),
            inflation_layer={"inflation_radius": radius},
            **{layers[0]: scans(values)},
        )

    layered = LayeredCostmap(config(0.2))
    see(layered, SE2(), 0.0, [PlacedScan(one_beam(0.99), SE2(), 0.2)])
    near = layered.costmap.cost_at(0.99, 0.3)
    layered.reconfigure(config(0.5, obstacle_max_range=0.5))
    assert layered.costmap.cost_at(0.99, 0.01) == LETHAL
    assert near == 0 < (layered.costmap.cost_at(0.99, 0.3) or 0)
    see(layered, SE2(), 0.1, [PlacedScan(one_beam(0.79, math.pi / 2), SE2(), 0.2)])
    assert layered.costmap.cost_at(0.01, 0.79) != LETHAL, "farther than what marks now"
