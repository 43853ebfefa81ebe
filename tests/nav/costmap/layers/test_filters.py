"""Filters: zones, limits and states by masks of any size, resolution and frame."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest

from arjuna_core.grid import GridFrame, OccupancyGrid
from arjuna_core.se2 import SE2
from arjuna_core.transforms import TransformError
from arjuna_nav.costmap import LETHAL, UNKNOWN, LayeredCostmap
from arjuna_nav.costmap.layers.filters import BinaryFilter, FilterInfo, SpeedFilter, SpeedLimit
from arjuna_nav.costmap.layers.static import PlacedMap
from tests.helpers.nav.layers import costmap_config

FREE_MAP = OccupancyGrid(GridFrame(0.1, 60, 50, SE2(-3.0, -2.5)), np.zeros((50, 60), np.int8))


def filtered(cls: str, T_map_mask: SE2 | None = None, **values: Any) -> LayeredCostmap:
    """Return a costmap of a free map with one filter, whose mask is in a frame of its own."""

    def transform(target: str, source: str) -> SE2:
        if T_map_mask is None:
            raise TransformError(f"no transform connects '{target}' and '{source}'")
        return T_map_mask

    config = costmap_config(
        resolution=0.1,
        plugins=("static_layer", "inflation_layer"),
        filters=("zones",),
        zones={"plugin": f"nav2_costmap_2d::{cls}", "filter_info_topic": "info", **values},
    )
    layered = LayeredCostmap(config, transform)
    layered.set_map(FREE_MAP)
    return layered


def give(
    layered: LayeredCostmap, kind: int, grid: OccupancyGrid, frame: str = "", *weights: float
) -> None:
    layered.receive("zones", "info", FilterInfo(kind, "mask", *weights))
    layered.receive("zones", "mask", PlacedMap(grid, frame))
    layered.update(SE2(), 0.0)


def mask(*values: int, edge: float = 1.0) -> OccupancyGrid:
    """Return cells in a row along x, the first from the origin on."""
    frame = GridFrame(edge, len(values), 1, SE2(0.0, -0.5 * edge))
    return OccupancyGrid(frame, np.array([values], np.int8))


@pytest.mark.parametrize("seed", range(6))
def test_costs_are_those_of_the_mask_where_they_are_greater(seed: int) -> None:
    rng = np.random.default_rng(seed)
    x, y, yaw = rng.uniform((-2.0, -2.0, -3.0), (2.0, 2.0, 3.0)).tolist()
    frame = GridFrame(float(rng.uniform(0.04, 0.4)), 25, 15, SE2(-1.0, -0.5, 0.3))
    values = rng.choice([-1, 0, 30, 99, 100], frame.shape).astype(np.int8)
    layered = filtered("KeepoutFilter", SE2(x, y, yaw))
    before = layered.costmap.data.copy()
    give(layered, 0, OccupancyGrid(frame, values), "elsewhere")
    rows, columns = np.indices(before.shape)
    middles = FREE_MAP.frame.to_points(np.column_stack((rows.ravel(), columns.ravel())))
    spread = np.linspace(-0.0499, 0.0499, 11)
    zones = []
    for spot in [(0.0, 0.0), *itertools.product(spread, spread)]:
        cells = frame.to_cells(SE2(x, y, yaw).inverse().apply(middles + spot))
        inside = frame.inside(cells)
        value = np.full(len(cells), -1)
        value[inside] = values[tuple(cells[inside].T)]
        zones.append(np.maximum(np.round(value * 254 / 100), before.ravel()))
    found = layered.costmap.data.ravel()
    assert (zones[0] <= found).all()
    assert (found <= np.max(zones, axis=0)).all()
    assert layered.take_changed() is not None
    layered.update(SE2(0.1, 0.0), 0.1)
    assert layered.take_changed() is None, "nothing has moved"


@pytest.mark.parametrize(("shift", "cells"), [(0.0, 0), (0.3, 3)])
def test_zones_of_the_costmaps_own_cells_do_not_grow(shift: float, cells: int) -> None:
    layered, values = filtered("KeepoutFilter"), np.zeros((50, 60), np.int8)
    values[20:30, 10:40] = 100
    give(layered, 0, OccupancyGrid(GridFrame(0.1, 60, 50, SE2(shift - 3.0, -2.5)), values))
    lethal = np.roll(values, cells, axis=1) == 100
    np.testing.assert_array_equal(layered.costmap.data == LETHAL, lethal)


@pytest.mark.parametrize("seed", range(4))
def test_no_point_of_a_free_cell_lies_in_a_zone(seed: int) -> None:
    rng = np.random.default_rng(seed)
    T_map_mask = SE2(*rng.uniform((-1.0, -1.0, -3.0), (1.0, 1.0, 3.0)).tolist())
    size = int(rng.integers(20, 100))
    frame = GridFrame(6.0 / size, size, size, SE2(-3.0, -3.0))
    values = np.zeros((size, size), np.int8)
    values[size // 4 : size // 2, size // 3 : size // 2] = 100
    layered = filtered("KeepoutFilter", T_map_mask)
    give(layered, 0, OccupancyGrid(frame, values), "elsewhere")
    points = rng.uniform((-3.0, -2.5), (3.0, 2.5), (4000, 2))
    cells = frame.to_cells(T_map_mask.inverse().apply(points))
    inside = frame.inside(cells)
    zone = np.zeros(len(points), np.bool_)
    zone[inside] = values[tuple(cells[inside].T)] == 100
    costs = layered.costmap.data[tuple(FREE_MAP.frame.to_cells(points).T)]
    assert zone.sum() > 20
    # what a cell's corners and edges touch of a zone may be left out, but no more
    assert (costs[zone] < LETHAL).mean() < 0.01


def test_zones_are_kept_in_whatever_a_new_map_makes_of_the_grid() -> None:
    layered = filtered("KeepoutFilter")
    give(layered, 0, mask(100, 100))
    layered.set_map(OccupancyGrid(GridFrame(0.1, 60, 50, SE2(-1.0, -1.0)), FREE_MAP.data))
    assert layered.costmap.cost_at(1.55, 0.05) == LETHAL
    assert layered.costmap.cost_at(2.55, 0.05) == 0
    assert layered.costmap.circumscribed_cost == 0, "costs do not show how far off a zone is"


@pytest.mark.parametrize(
    ("overrides", "inside", "cost"), [(1, 1, 200), (1, 0, LETHAL), (0, 1, LETHAL)]
)
def test_a_robot_may_leave_a_zone_where_asked(overrides: int, inside: int, cost: int) -> None:
    values: dict[str, Any] = {"override_lethal_cost": bool(overrides), "lethal_override_cost": 200}
    layered = filtered("KeepoutFilter", **values)
    give(layered, 0, mask(100, 40))
    layered.update(SE2(0.5, 0.0) if inside else SE2(-0.5, 0.0), 0.1)
    assert layered.costmap.cost_at(0.75, 0.05) == cost
    assert layered.costmap.cost_at(1.55, 0.05) == round(40 * 2.54)


@pytest.mark.parametrize("size", [4, 9])
def test_a_zone_goes_with_its_mask_whatever_comes_in_between(size: int) -> None:
    layered = filtered("KeepoutFilter")
    give(layered, 0, mask(100, 100))
    layered.receive("zones", "mask", PlacedMap(mask(*[0] * size)))
    layered.set_map(
        OccupancyGrid(GridFrame(0.1, 40, 50, SE2(-2.0, -2.5)), np.zeros((50, 40), np.int8))
    )
    layered.update(SE2(), 0.1)
    assert not layered.costmap.data.any()
    give(layered, 0, mask(100, 100))
    assert layered.costmap.data.max() == LETHAL
    layered.receive("zones", "info", FilterInfo(0, "another_mask"))
    layered.clear_entirely()  # composes all
    layered.update(SE2(), 0.2)
    assert not layered.costmap.data.any()


def test_what_a_filter_lacks_is_said_and_it_has_no_effect() -> None:
    layered = filtered("KeepoutFilter")
    assert layered.group.warning() == "zones: no CostmapFilterInfo has come on /info"
    layered.receive("zones", "info", FilterInfo(1, "mask"))
    assert layered.group.warning() == "zones: /info says type 1; this filter takes 0"
    layered.receive("zones", "info", FilterInfo(0, "mask"))
    assert layered.group.warning() == "zones: no mask has come on /mask"
    assert [one.topic for one in layered.layers["zones"].inputs()] == ["info", "mask"]
    layered.receive("zones", "mask", PlacedMap(mask(100), "elsewhere"))
    layered.update(SE2(), 0.0)
    assert layered.group.warning() == ""
    assert layered.group.problem(0.0) == "no transform connects 'map' and 'elsewhere'"
    layered.receive("zones", "info", FilterInfo(0, "another"))
    layered.receive("zones", "mask", PlacedMap(mask(100)))
    layered.update(SE2(), 0.1)
    assert not layered.costmap.data.any(), "the mask of an earlier info"
    nameless = filtered("KeepoutFilter", filter_info_topic="")
    assert nameless.group.warning() == "zones: filter_info_topic is empty: the filter has no mask"


def test_speeds_are_limited_where_the_robot_is() -> None:
    layered = filtered("SpeedFilter")
    speed = layered.layers["zones"]
    assert isinstance(speed, SpeedFilter)
    give(layered, 1, mask(0, 30, -1, 100, 0), "", 100.0, -1.0)
    limits = []
    for k in range(-1, 6):
        layered.update(SE2(k + 0.5, 0.0), 0.1)
        limits.append(speed.take_change())
    lifted, slow = SpeedLimit(True, 0.0), SpeedLimit(True, 70.0)
    assert limits == [None, None, slow, None, lifted, None, None]
    assert not layered.costmap.data.any()


def test_limits_may_be_speeds_and_wrong_ones_are_none() -> None:
    for kind, base, multiplier, expected in (
        (2, 0.0, 0.01, SpeedLimit(False, 0.5)),
        (2, -1.0, 0.01, None),
        (1, 60.0, 1.0, None),
    ):
        layered = filtered("SpeedFilter")
        speed = layered.layers["zones"]
        assert isinstance(speed, SpeedFilter)
        give(layered, kind, mask(50), "", base, multiplier)
        layered.update(SE2(0.5, 0.0), 0.1)
        assert speed.take_change() == expected


@pytest.mark.parametrize("default", [False, True])
def test_a_state_is_another_where_the_mask_is_over_the_threshold(default: bool) -> None:
    layered = filtered("BinaryFilter", default_state=default, flip_threshold=40.0)
    binary = layered.layers["zones"]
    assert isinstance(binary, BinaryFilter)
    assert [binary.take_change(), binary.take_change()] == [default, None]
    give(layered, 3, mask(40, 41, -1, 0))
    states = []
    for k in range(6):
        layered.update(SE2(k + 0.5, 0.0), 0.1)
        states.append(binary.take_change())
    assert states == [None, not default, None, default, None, None]


def test_unknown_space_takes_a_masks_cost() -> None:
    config = costmap_config(
        plugins=("static_layer",),
        filters=("zones",),
        track_unknown_space=True,
        zones={"plugin": "nav2_costmap_2d::KeepoutFilter", "filter_info_topic": "info"},
    )
    layered = LayeredCostmap(config)
    layered.set_map(OccupancyGrid(GridFrame(1.0, 3, 1), np.full((1, 3), -1, np.int8)))
    give(layered, 0, OccupancyGrid(GridFrame(1.0, 3, 1), np.array([[0, 50, -1]], np.int8)))
    assert layered.costmap.data.tolist() == [[0, 127, UNKNOWN]]


@pytest.mark.parametrize("twice", [False, True])
def test_an_inflation_of_both_lists_spreads_from_zones_too(twice: bool) -> None:
    config = costmap_config(
        resolution=0.1,
        plugins=("static_layer", "inflation_layer"),
        filters=("zones", "inflation_layer") if twice else ("zones",),
        zones={"plugin": "nav2_costmap_2d::KeepoutFilter", "filter_info_topic": "info"},
    )
    layered = LayeredCostmap(config)
    layered.set_map(FREE_MAP)
    give(layered, 0, mask(100))
    beside = int(layered.costmap.data[FREE_MAP.frame.to_cell(-0.25, 0.0)])
    assert layered.costmap.data[FREE_MAP.frame.to_cell(0.5, 0.0)] == LETHAL
    assert (0 < beside < LETHAL) is twice


def value_under(placed: tuple[SE2, OccupancyGrid], pose: SE2) -> int | None:
    """Return a mask's value at a pose of the map; None outside the mask."""
    at = placed[0].inverse() @ pose
    cell = placed[1].frame.to_cell(at.x, at.y)
    return int(placed[1].data[cell]) if placed[1].frame.contains(*cell) else None


@pytest.mark.parametrize("seed", range(5))
def test_several_filters_each_keep_to_their_own_mask(seed: int) -> None:
    rng = np.random.default_rng(seed)
    kinds = {"KeepoutFilter": 0, "SpeedFilter": 1, "BinaryFilter": 3}
    classes = [str(one) for one in rng.choice(list(kinds), rng.integers(2, 6))]
    names = [f"f{k}" for k in range(len(classes))]
    placed: dict[str, tuple[SE2, OccupancyGrid]] = {}
    for name in names:
        size = int(rng.integers(5, 40))
        frame = GridFrame(5.0 / size, size, size, SE2(-2.5, -2.5, float(rng.uniform(-1.0, 1.0))))
        pose = SE2(*rng.uniform((-1.0, -1.0, -3.0), (1.0, 1.0, 3.0)).tolist())
        values = rng.choice([-1, 0, 30, 60, 100], frame.shape).astype(np.int8)
        placed[name] = pose, OccupancyGrid(frame, values)
    config = costmap_config(
        resolution=0.1,
        plugins=("static_layer",),
        filters=names,
        **{
            name: {"plugin": f"nav2_costmap_2d::{cls}", "filter_info_topic": f"{name}_info"}
            for name, cls in zip(names, classes, strict=True)
        },
    )
    layered = LayeredCostmap(config, lambda target, source: placed[source][0])
    layered.set_map(FREE_MAP)
    for name, cls in zip(names, classes, strict=True):
        weights = (100.0, -1.0) if cls == "SpeedFilter" else ()
        layered.receive(name, "info", FilterInfo(kinds[cls], name, *weights))
        layered.receive(name, name, PlacedMap(placed[name][1], name))
    limits, states = dict.fromkeys(names, SpeedLimit(False, 0.0)), dict.fromkeys(names, False)
    for k in range(20):
        robot = SE2(*rng.uniform((-3.0, -2.5, -3.0), (3.0, 2.5, 3.0)).tolist())
        layered.update(robot, float(k))
        cell = FREE_MAP.frame.to_cell(robot.x, robot.y)
        middle = SE2(*FREE_MAP.frame.to_point(*cell))
        least = 0
        for name in names:
            layer = layered.layers[name]
            value = value_under(placed[name], robot)
            if isinstance(layer, SpeedFilter):
                before = limits[name]
                if value is not None and value >= 0:
                    limits[name] = SpeedLimit(True, 100.0 - value if value else 0.0)
                changed = limits[name].limit != before.limit
                assert layer.take_change() == (limits[name] if changed else None)
            elif isinstance(layer, BinaryFilter):
                before_it, first = states[name], k == 0
                if value != -1:
                    states[name] = value is not None and value > 50
                changed = states[name] != before_it or first
                assert layer.take_change() == (states[name] if changed else None)
            else:
                least = max(least, round((value_under(placed[name], middle) or 0) * 254 / 100))
        assert int(layered.costmap.data[cell]) >= least
        if "KeepoutFilter" not in classes:
            assert not layered.costmap.data.any()
