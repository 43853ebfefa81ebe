"""Clouds of points: what no planar scan sees is marked, and cleared where it is gone."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from arjuna_core.scan import Cloud, Scan
from arjuna_core.se2 import SE2
from arjuna_nav.costmap import LETHAL, LayeredCostmap, PlacedCloud, PlacedScan
from tests.helpers.nav import layers
from tests.helpers.nav.layers import costmap_config

EYE = np.array([0.1, 0.0, 0.5])
HERE = SE2()


def costmap(
    rolling: bool = True, layer: dict[str, Any] | None = None, **values: float
) -> LayeredCostmap:
    config = costmap_config(
        rolling_window=rolling,
        resolution=0.05,
        width=6,
        height=6,
        origin_x=-3.0,
        origin_y=-3.0,
        plugins=("obstacle_layer", "voxel_layer"),
        voxel_layer=layers.clouds(values, min_obstacle_height=0.05, **(layer or {})),
    )
    return LayeredCostmap(config)


def cloud(*points: tuple[float, float, float]) -> Cloud:
    return Cloud(np.array(points, np.float64).reshape(-1, 3), EYE, 0.0)


def see(layered: LayeredCostmap, seen: Cloud, pose: SE2 = HERE) -> None:
    layers.see(layered, pose, 0.0, [PlacedCloud(seen, pose)])


def marked(layered: LayeredCostmap) -> set[tuple[int, int]]:
    """Return the cells that are lethal, as (x, y) in cells of 5 cm from the world's origin."""
    frame = layered.costmap.frame
    rows, columns = np.nonzero(layered.costmap.data == LETHAL)
    x0, y0 = round(frame.origin.x / 0.05), round(frame.origin.y / 0.05)
    return {(int(c) + x0, int(r) + y0) for r, c in zip(rows, columns, strict=True)}


def cell(x: float, y: float) -> tuple[int, int]:
    return math.floor(x / 0.05), math.floor(y / 0.05)


TABLE = (1.02, 0.02, 0.7)


def test_a_lidar_that_looks_through_below_does_not_clear_a_table() -> None:
    layered = costmap()
    see(layered, cloud(TABLE))
    beams = Scan(np.full(360, 2.9), -math.pi, math.tau / 360, 0.1, 12.0)
    layers.see(layered, HERE, 0.1, [PlacedScan(beams, HERE)])
    assert cell(*TABLE[:2]) in marked(layered)


@pytest.mark.parametrize(
    ("behind", "gone"),
    [
        ((2.02, 0.02, 0.9), True),  # the ray to it crosses where the table was
        ((2.02, 0.02, 0.5), False),  # this one passes below
        ((1.02, 0.02, 0.1), False),  # and this one ends below
    ],
)
def test_only_rays_through_it_clear_it(behind: tuple[float, float, float], gone: bool) -> None:
    layered = costmap()
    see(layered, cloud(TABLE))
    see(layered, cloud(behind))
    assert (cell(*TABLE[:2]) not in marked(layered)) is gone


@pytest.mark.parametrize("height", [0.0, 0.04, 2.1, -0.3])
def test_floor_and_ceiling_are_no_obstacles(height: float) -> None:
    layered = costmap()
    see(layered, cloud((1.0, 0.5, height)))
    assert marked(layered) == set()


@pytest.mark.parametrize("seed", range(4))
def test_marked_are_the_cells_of_the_points_within_range_wherever_the_robot_is(seed: int) -> None:
    rng = np.random.default_rng(seed)
    x, y, theta = rng.uniform((-20.0, -20.0, -3.0), (20.0, 20.0, 3.0)).tolist()
    pose = SE2(x, y, theta)
    points: NDArray[np.float64] = rng.uniform((-3.0, -3.0, 0.06), (3.0, 3.0, 1.9), (200, 3))
    points = points[np.hypot(points[:, 0], points[:, 1]) > 0.3]
    layered = costmap(obstacle_max_range=2.0, raytrace_max_range=0.0)
    see(layered, cloud(*map(tuple, points.tolist())), pose)
    near = points[np.linalg.norm(points - EYE, axis=1) <= 2.0]
    assert marked(layered) == {cell(x, y) for x, y in pose.apply(near[:, :2]).tolist()}


def test_marks_stay_where_they_are_while_the_window_rolls() -> None:
    layered = costmap()
    see(layered, cloud(TABLE))
    layered.update(SE2(0.83, 0.4, 1.0), 0.1)
    assert cell(*TABLE[:2]) in marked(layered)
    see(layered, cloud((1.17, 0.02, 0.9)), SE2(0.83, 0.0))  # 17 cm beyond it, and above
    assert cell(*TABLE[:2]) in marked(layered)
    layered.update(SE2(9.0, 0.0), 0.2)
    layered.update(HERE, 0.3)
    assert marked(layered) == set()


@pytest.mark.parametrize("rolling", [True, False])
def test_clearing_forgets_what_clouds_showed(rolling: bool) -> None:
    layered = costmap(rolling)
    see(layered, cloud(TABLE, (-1.0, -1.0, 0.4)))
    layered.clear_except(HERE, 2.5)
    assert len(marked(layered)) == 2
    layered.clear_around(SE2(1.0, 0.0), 0.5)
    assert marked(layered) == {cell(-1.0, -1.0)}
    layered.clear_entirely()
    see(layered, cloud((0.5, 0.5, 0.02)))
    assert marked(layered) == set()


def test_cells_under_the_robot_are_free() -> None:
    layered = costmap()
    see(layered, cloud((0.02, 0.0, 0.3)))
    assert marked(layered) == set()


def test_a_column_may_hold_as_many_marks_as_asked_for() -> None:
    for points, expected in ((1, 0), (2, 1)):
        column = [(1.02, 0.02, 0.1 + 0.2 * k) for k in range(points)]
        layered = costmap(layer={"mark_threshold": 1})
        see(layered, cloud(*column))
        assert len(marked(layered)) == expected


@pytest.mark.parametrize("asked", [32, 40])
def test_more_voxels_than_a_column_holds_are_as_many_as_it_holds(asked: int) -> None:
    layered = costmap(layer={"z_voxels": asked, "z_resolution": 0.05})
    see(layered, cloud((1.02, 0.02, 1.55), (1.52, 0.02, 1.65)))
    assert len(marked(layered)) == 1
