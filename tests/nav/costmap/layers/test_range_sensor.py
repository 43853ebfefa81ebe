"""Sonars and infrared sensors: cones that mark, free and fade, by Nav2's range layer."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from arjuna_core.scan import RangeReading
from arjuna_core.se2 import SE2, wrap
from arjuna_nav.costmap import LETHAL, LayeredCostmap, PlacedRange
from arjuna_nav.costmap.costmap import UNKNOWN
from arjuna_nav.costmap.layers.range_sensor import _enter_cone
from tests.helpers.nav.layers import costmap_config, see

POSES = [SE2(), SE2(1.0, -0.5, 2.0)]
AHEAD = SE2(0.2, 0.0)


def costmap(track_unknown: bool = False, **values: Any) -> LayeredCostmap:
    config = costmap_config(
        rolling_window=True,
        track_unknown_space=track_unknown,
        width=6,
        height=6,
        resolution=0.05,
        plugins=("range_layer",),
        range_layer={"topics": ["sonar"], **values},
    )
    return LayeredCostmap(config)


def enter(
    layered: LayeredCostmap,
    pose: SE2,
    distance: float,
    times: int = 6,
    valid: tuple[float, float] = (0.1, 2.0),
) -> None:
    """Enter readings of a sonar whose cone has 0.4 rad."""
    reading = RangeReading(distance, 0.4, *valid, 0.0, AHEAD)
    see(layered, pose, 0.0, [PlacedRange(reading, pose)] * times)


def cost(layered: LayeredCostmap, pose: SE2, x: float, y: float = 0.0) -> int | None:
    at = pose @ SE2(x, y)
    return layered.costmap.cost_at(at.x, at.y)


@pytest.mark.parametrize("pose", POSES)
def test_a_thing_is_marked_where_it_is_and_freed_when_it_has_gone(pose: SE2) -> None:
    layered = costmap()
    enter(layered, pose, 1.0)
    assert cost(layered, pose, 1.2) == LETHAL
    assert [cost(layered, pose, x) for x in (0.6, 1.0, 1.5)] == [0, 0, 0]
    assert cost(layered, pose, 1.0, 0.4) == 0  # off the cone
    enter(layered, pose, 1.6, times=12)
    assert cost(layered, pose, 1.2) == 0
    assert cost(layered, pose, 1.8) == LETHAL


def test_one_reading_is_not_sure_enough() -> None:
    layered = costmap(mark_threshold=0.95)
    enter(layered, SE2(), 1.0, times=1)
    assert not (layered.costmap.data == LETHAL).any()


@pytest.mark.parametrize("inflate", [0.0, 0.3, 1.0])
@pytest.mark.parametrize("nothing", [False, True])
@pytest.mark.parametrize("heading", [0.4, 2.0, -2.5])
def test_each_cell_of_a_cone_takes_what_nav2_s_sensor_model_says(
    inflate: float, nothing: bool, heading: float
) -> None:
    cell, distance, half, fades = 0.05, 1.1, 0.35, 0.9
    sensor = np.array([1.6, 1.4, heading])
    data = np.random.default_rng(1).integers(1, LETHAL, (60, 64)).astype(np.uint8)
    rows, columns = np.indices(data.shape)
    x, y = (columns + 0.5) * cell - sensor[0], (rows + 0.5) * cell - sensor[1]
    at, off = np.hypot(x, y), wrap(np.arctan2(y, x) - heading)
    belief = np.where(np.abs(off) <= half, 1.0 - (off / half) ** 2, 0.0)
    belief *= 1.0 - 0.5 * (1.0 + np.tanh(2.0 * (at - fades)))
    gap = (at - distance) / (cell * distance)
    before, rises = 0.5 * (1.0 - belief), 0.5 * belief * (gap + 2.0) ** 2
    peak = 0.5 + belief * 0.5 * (1.0 - gap**2)
    says = np.select([gap < -2.0, gap < -1.0, gap < 1.0], [before, before + rises, peak], 0.5)
    if nothing:
        free = (np.abs(off) <= half) & (at <= distance * (1.0 + 2.0 * cell) + cell)
        says = np.where(free, 0.0, 0.5)
    prior = data / LETHAL
    after = says * prior / (says * prior + (1.0 - says) * (1.0 - prior))
    ends = 1.2 * distance * np.exp(1j * (heading + np.array([-half, half])))
    corners = np.array([0.0, *ends, 0.0])  # round to the left
    beside = x + 1j * y - corners[:3, None, None]
    sides = ((corners[1:] - corners[:3]).conj()[:, None, None] * beside).imag
    area = float((ends[0].conj() * ends[1]).imag)
    known = (sides >= -inflate * area).all(axis=0) if inflate < 1.0 else says != 0.5
    expected = np.where(known & (says != 0.5), after, prior) * LETHAL
    found = data.copy()
    _enter_cone(found, sensor, (distance, half, fades, inflate), nothing, cell)
    assert np.abs(found - expected).max() < 1.01  # it is rounded down
    assert (found != data).sum() > 100


@pytest.mark.parametrize("distance", [0.05, 2.5, math.nan, math.inf])
def test_invalid_readings_change_nothing(distance: float) -> None:
    layered = costmap()
    enter(layered, SE2(), 1.0)
    before = layered.costmap.data.copy()
    enter(layered, SE2(), distance)
    assert np.array_equal(layered.costmap.data, before)


@pytest.mark.parametrize("clears", [False, True])
def test_a_reading_of_nothing_frees_the_cone_where_it_is_asked_to(clears: bool) -> None:
    layered = costmap(clear_on_max_reading=clears)
    enter(layered, SE2(), 1.0, valid=(0.1, 1.0))
    assert (cost(layered, SE2(), 1.2) == LETHAL) is not clears
    assert cost(layered, SE2(), 0.8) == 0


def test_sensors_of_a_fixed_distance_mark_it_and_can_be_left_out() -> None:
    for kind, marks in (("ALL", True), ("FIXED", True), ("VARIABLE", False)):
        layered = costmap(input_sensor_type=kind)
        enter(layered, SE2(), -math.inf, valid=(0.8, 0.8))
        assert (layered.costmap.data == LETHAL).any() == marks
    layered = costmap(clear_on_max_reading=True)
    enter(layered, SE2(), -math.inf, valid=(0.8, 0.8))
    enter(layered, SE2(), math.inf, valid=(0.8, 0.8))
    assert not (layered.costmap.data == LETHAL).any()


def test_it_forgets_what_is_cleared_and_keeps_what_rolls_along() -> None:
    layered, pose = costmap(), SE2()
    enter(layered, pose, 1.0)
    layered.update(SE2(0.5, 0.0), 1.0)
    assert cost(layered, pose, 1.2) == LETHAL
    layered.clear_entirely()
    assert not layered.costmap.data.any()


def test_what_others_mark_stays_where_a_sonar_sees_through_it() -> None:
    layered = costmap(track_unknown=True)
    enter(layered, SE2(), 1.0)
    layer = layered.layers["range_layer"]
    for known, merged in ((UNKNOWN, 0), (LETHAL, LETHAL), (7, 7)):
        master = np.full((120, 120), known, np.uint8)
        layer.write(master, (slice(0, 120), slice(0, 120)))
        row, column = 60, 76  # 0.8 m ahead, seen free
        assert master[row, column] == merged
        assert master[60, 20] == known  # never seen
