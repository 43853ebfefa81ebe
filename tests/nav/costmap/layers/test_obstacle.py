"""Sources of obstacle and voxel layers: heights, tilts, starts of rays, what is kept, silence."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from arjuna_core.pose3 import Pose3
from arjuna_core.scan import Cloud, Scan
from arjuna_core.se2 import SE2
from arjuna_nav.costmap import FREE, LETHAL, UNKNOWN, LayeredCostmap, PlacedCloud, PlacedScan
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.costmap.layers.voxel import VoxelLayer
from tests.helpers.nav.layers import CLOUD, SCAN, costmap_config

LAYERS = ("ObstacleLayer", "VoxelLayer")


def costmap(cls: str, layer: dict[str, Any], **values: Any) -> LayeredCostmap:
    config = costmap_config(
        rolling_window=True,
        resolution=0.05,
        width=6,
        height=6,
        plugins=("seen",),
        seen={"plugin": f"nav2_costmap_2d::{cls}", "moving_time": 0.0, **layer},
        **values,
    )
    return LayeredCostmap(config)


def one_lidar(cls: str, source: dict[str, Any] | None = None, **layer: Any) -> LayeredCostmap:
    return costmap(cls, {"observation_sources": "s", "s": {**SCAN, **(source or {})}, **layer})


def beam(distance: float, height: float = 0.3, stamp: float = 0.0, **mounting: Any) -> PlacedScan:
    scan = Scan(np.array([distance]), 0.0, 0.01, 0.1, 12.0, stamp)
    return PlacedScan(scan, SE2(), height, **mounting)


def see(layered: LayeredCostmap, now: float, *seen: PlacedScan | PlacedCloud) -> None:
    for one in seen:
        layered.receive("seen", "s", one)
    layered.update(SE2(), now)


def marked(layered: LayeredCostmap) -> list[float]:
    """Return how far ahead cells are lethal [m]."""
    frame = layered.costmap.frame
    row, column = frame.to_cell(0.001, 0.001)
    found = np.flatnonzero(layered.costmap.data[row, column:] == LETHAL)
    assert len(found) == (layered.costmap.data == LETHAL).sum()
    return [round(0.05 * int(k), 2) for k in found]


BODY = "[[0.3, 0.2], [0.3, -0.2], [-0.3, -0.2], [-0.3, 0.2]]"


@pytest.mark.parametrize("cls", LAYERS)
@pytest.mark.parametrize(
    ("body", "at", "kept"),
    [
        (BODY, 0.299, []),  # its own front edge, in a cell that is not under it as a whole
        (BODY, 0.31, []),
        (BODY, 0.32, [0.3]),
        ("", 0.42, [0.4]),
    ],
)
def test_a_camera_s_view_of_the_body_s_edge_marks_nothing(
    cls: str, body: str, at: float, kept: list[float]
) -> None:
    """A robot that saw its own bumper from above stood before it for ever."""
    layer = {"observation_sources": "s", "s": {**CLOUD, "clearing": False}}
    layered = costmap(cls, layer, robot_radius=0.4, body=body)
    points = np.array([[at, 0.001, 0.2], [at, 0.002, 0.2]])
    see(layered, 0.1, PlacedCloud(Cloud(points, np.array([0.1, 0.0, 0.6]), 0.1), SE2()))
    assert marked(layered) == kept


@pytest.mark.parametrize("cls", LAYERS)
@pytest.mark.parametrize("axle", [0.0, -0.25])
@pytest.mark.parametrize(
    ("body", "kept"), [("", []), (BODY, [0.3, 0.35])], ids=["footprint", "body"]
)
def test_what_stands_beside_the_body_is_kept(
    cls: str, body: str, kept: list[float], axle: float
) -> None:
    layer = {"observation_sources": "s", "s": {**SCAN, "clearing": False}}
    layered = costmap(cls, layer, robot_radius=0.4, body=body, axle=axle)
    for k, distance in enumerate((0.13, 0.22, 0.31, 0.36)):
        see(layered, 0.1 * k, beam(distance, stamp=0.1 * k))
    assert marked(layered) == kept
    layered.set_footprint(Footprint.circle(0.45))
    see(layered, 1.0, beam(0.36, stamp=1.0))
    assert marked(layered) == [], "another outline has another body"


@pytest.mark.parametrize("cls", LAYERS)
@pytest.mark.parametrize(
    ("source", "layer", "height", "marks", "clears"),
    [
        ((0.0, 2.0), (0.0, 2.0), 0.3, True, True),
        ((0.0, 0.0), (0.0, 2.0), 0.3, False, False),
        ((0.4, 2.0), (0.0, 2.0), 0.3, False, False),
        ((0.0, 2.0), (0.0, 0.2), 0.3, False, True),
        ((0.0, 2.0), (0.4, 2.0), 0.3, False, True),
        ((-1.0, 2.0), (-1.0, 2.0), -0.1, True, False),  # the voxels begin above its rays
    ],
)
def test_a_scan_counts_by_its_height(
    cls: str,
    source: tuple[float, float],
    layer: tuple[float, float],
    height: float,
    marks: bool,
    clears: bool,
) -> None:
    def names(bounds: tuple[float, float]) -> dict[str, float]:
        return {"min_obstacle_height": bounds[0], "max_obstacle_height": bounds[1]}

    layered = one_lidar(cls, names(source), **names(layer))
    see(layered, 0.0, beam(1.02, height))
    assert marked(layered) == ([1.0] if marks else [])
    layered = costmap(
        cls,
        {
            "observation_sources": "s all",
            "s": {**SCAN, **names(source), "marking": False},
            "all": {**SCAN, "clearing": False},
        },
    )
    layered.receive("seen", "all", beam(1.02))
    see(layered, 0.0)
    layered.receive("seen", "all", beam(3.02))  # too far to mark
    see(layered, 0.1, beam(2.02, 0.3 if height > 0.0 else height))
    clears = clears or (height < 0.0 and cls == "ObstacleLayer")
    assert marked(layered) == ([] if clears else [1.0])


@pytest.mark.parametrize("cls", LAYERS)
def test_a_lidar_that_leans_marks_where_its_beams_end_at_their_height(cls: str) -> None:
    down = Pose3.from_rpy((0.0, 0.0, 0.6), (0.0, math.radians(30.0), 0.0))
    for distance, ends in ((1.0, [0.85]), (1.3, [])):  # 0.1 m above the ground, and below it
        layered = one_lidar(cls)
        see(layered, 0.0, beam(distance, 0.6, mount=down))
        assert marked(layered) == ends


@pytest.mark.parametrize("cls", LAYERS)
def test_rays_start_where_the_sensors_frame_is(cls: str) -> None:
    layered = one_lidar(cls, {"raytrace_max_range": 5.0, "obstacle_max_range": 5.0})
    see(layered, 0.0, beam(1.02))
    see(layered, 0.1, beam(2.02, start=(1.5, 0.0, 0.3)))
    assert marked(layered) == [1.0, 2.0], "the ray begins behind the first"
    see(layered, 0.2, beam(2.52, start=(0.0, 0.0, 0.3)))
    assert marked(layered) == [2.5]


@pytest.mark.parametrize("cls", LAYERS)
def test_what_is_kept_marks_again_until_it_is_too_old(cls: str) -> None:
    layered = one_lidar(cls, {"observation_persistence": 0.5})
    see(layered, 0.0, beam(1.02, stamp=0.0))
    see(layered, 0.3, beam(2.02, stamp=0.3))
    assert marked(layered) == [1.0, 2.0]
    layered.clear_entirely()
    see(layered, 0.5)
    assert marked(layered) == [1.0, 2.0]
    see(layered, 0.6)
    assert marked(layered) == [2.0], "the ray of the second clears"
    see(layered, 0.9)
    layered.clear_entirely()
    see(layered, 1.0)
    assert marked(layered) == []


@pytest.mark.parametrize("cls", LAYERS)
def test_what_one_source_alone_sees_stays_though_rays_of_another_cross_it(cls: str) -> None:
    sources = {"s": SCAN, "slow": SCAN}
    layered = costmap(cls, {"observation_sources": "slow s", **sources})
    layered.receive("seen", "slow", beam(1.02))
    for k in range(5):
        see(layered, 0.1 * k, beam(2.02))
        assert marked(layered) == [1.0, 2.0]
    layered.receive("seen", "slow", beam(3.02))
    see(layered, 0.5, beam(2.02))
    assert marked(layered) == [2.0]
    layered.group.start(0.6)
    see(layered, 0.6, beam(1.52))
    assert marked(layered) == [1.5, 2.0], "the ray ends before it, and nothing of before counts"


@pytest.mark.parametrize("cls", LAYERS)
def test_of_several_scans_the_latest_counts_or_each_where_things_are_followed(cls: str) -> None:
    for moving_time, expected in ((0.0, [1.0]), (1.5, [1.0, 1.5])):
        layered = one_lidar(cls, {"clearing": False}, moving_time=moving_time)
        see(layered, 0.2, beam(1.52, stamp=0.1), beam(1.02, stamp=0.2))
        assert marked(layered) == expected


def test_any_source_that_is_silent_is_said() -> None:
    sources = {
        "front": {**SCAN, "topic": "/a/front", "expected_update_rate": 0.5},
        "eyes": {**CLOUD, "expected_update_rate": 1.0},
        "rear": SCAN,
    }
    layered = costmap("ObstacleLayer", {"observation_sources": "front eyes rear", **sources})
    layered.group.start(0.0)
    assert layered.group.problem(0.5) == ""
    assert layered.group.problem(0.6) == "no scan on /a/front for 0.60 s"
    layered.receive("seen", "front", beam(1.0))
    layered.update(SE2(), 0.7)
    assert layered.group.problem(1.0) == ""
    assert layered.group.problem(1.1) == "no cloud on /eyes for 1.10 s"


def points(*corners: tuple[float, float, float]) -> PlacedCloud:
    return PlacedCloud(Cloud(np.array(corners), np.array([0.0, 0.0, 0.5]), 0.0), SE2())


def test_a_cloud_in_an_obstacle_layer_clears_and_marks_in_the_plane() -> None:
    heights = {"min_obstacle_height": 0.05, "max_obstacle_height": 1.0}
    cloud = {**CLOUD, **heights}
    layered = costmap("ObstacleLayer", {"observation_sources": "s", "s": cloud})
    see(layered, 0.0, points((1.02, 0.01, 0.2)))
    see(layered, 0.1, points((2.02, 0.01, 0.01)))
    assert marked(layered) == [1.0], "a point outside the heights does not clear either"
    see(layered, 0.2, points((2.02, 0.02, 0.9), (1.52, 0.02, 1.1)))
    assert marked(layered) == [2.0]
    see(layered, 0.3, points((2.9, 0.02, 0.9)))
    assert marked(layered) == [], "too far to mark, and its ray clears"


@pytest.mark.parametrize("cls", LAYERS)
def test_ranges_that_mark_are_measured_in_space(cls: str) -> None:
    cloud = {**CLOUD, "clearing": False, "obstacle_max_range": 2.0, "obstacle_min_range": 0.6}
    layered = costmap(cls, {"observation_sources": "s", "s": cloud})
    see(layered, 0.0, points((1.62, 0.01, 1.5), (1.92, 0.01, 1.5)))  # 1.0 m above the sensor
    assert marked(layered) == [1.6]
    see(layered, 0.1, points((0.42, 0.01, 0.5), (0.52, 0.01, 1.5)))
    assert marked(layered) == [0.5, 1.6]


@pytest.mark.parametrize("cls", LAYERS)
@pytest.mark.parametrize("nothing", [math.inf, 12.0])
@pytest.mark.parametrize(("distance", "stays"), [(1.32, []), (1.72, [1.7])])
def test_a_beam_without_return_clears_as_far_as_rays_do(
    cls: str, nothing: float, distance: float, stays: list[float]
) -> None:
    layered = one_lidar(cls, {"raytrace_max_range": 1.5})
    see(layered, 0.0, beam(distance))
    see(layered, 0.1, beam(nothing))
    assert marked(layered) == stays


@pytest.mark.parametrize("height", [0.25, 1.0])
def test_points_at_the_very_bounds_of_the_heights_are_used(height: float) -> None:
    cloud = {**CLOUD, "min_obstacle_height": 0.25, "max_obstacle_height": 1.0}
    layered = costmap("ObstacleLayer", {"observation_sources": "s", "s": cloud})
    see(layered, 0.0, points((1.02, 0.01, height)))
    assert marked(layered) == [1.0]


@pytest.mark.parametrize(("threshold", "cost"), [(15, FREE), (9, FREE), (8, UNKNOWN), (0, UNKNOWN)])
def test_a_column_is_unknown_while_more_of_its_voxels_are(threshold: int, cost: int) -> None:
    layer = {"observation_sources": "s", "s": CLOUD, "unknown_threshold": threshold}
    layered = costmap("VoxelLayer", layer, track_unknown_space=True)
    see(layered, 0.0, points((2.02, 0.02, 0.5)))  # one voxel of ten in each cell
    assert layered.costmap.cost_at(1.02, 0.02) == cost
    assert layered.costmap.cost_at(1.02, 1.02) == UNKNOWN


def test_voxels_are_what_a_message_of_nav2_holds() -> None:
    layered = costmap("VoxelLayer", {"observation_sources": "s", "s": CLOUD})
    see(layered, 0.0, points((2.02, 0.02, 0.5)))
    layer = layered.layers["seen"]
    assert isinstance(layer, VoxelLayer)
    frame = layered.costmap.frame
    columns = layer.columns()
    hit, free, unseen = (columns[frame.to_cell(*at)] for at in ((2.02, 0.02), (1.02, 0.02), (1, 1)))
    assert (hit >> 16, free >> 16, unseen >> 16) == (0b100, 0, 0)
    assert (hit & 0xFFFF, free & 0xFFFF, unseen & 0xFFFF) == (0xFFFF, 0xFFFF & ~0b100, 0xFFFF)


def test_scans_that_are_too_high_are_said() -> None:
    layered = one_lidar("ObstacleLayer", {"max_obstacle_height": 0.25})
    see(layered, 0.0, beam(1.02, 0.2))
    assert layered.group.warning() == ""
    see(layered, 0.1, beam(1.02, 0.3))
    warning = layered.group.warning()
    assert warning.startswith("seen: scans of 's', 0.3 m high, are not used: min_obstacle_height")
    see(layered, 0.2, beam(1.02, 0.25))
    assert layered.group.warning() == ""


def test_scans_that_are_too_high_for_the_layer_mark_nothing_and_that_is_said() -> None:
    for height, cost, said in (
        (0.25, LETHAL, ""),
        (0.3, FREE, "seen: scans of 's', 0.3 m high, mark nothing: the layer's min_obst"),
    ):
        layered = one_lidar("ObstacleLayer", {"max_obstacle_height": 0.5}, max_obstacle_height=0.25)
        see(layered, 0.0, beam(1.02, height))
        assert layered.costmap.cost_at(1.02, 0.0) == cost
        assert layered.group.warning()[: len(said) or None] == said


def test_a_layer_that_is_off_changes_nothing_and_is_never_silent() -> None:
    layered = one_lidar("ObstacleLayer", {"expected_update_rate": 0.5}, enabled=False)
    see(layered, 0.0, beam(1.02))
    assert marked(layered) == []
    assert layered.group.problem(9.0) == ""
