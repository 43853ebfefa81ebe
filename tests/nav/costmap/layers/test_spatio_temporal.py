"""Voxels that fade: after their time, sooner where a sensor looks, never where one still sees."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from arjuna_core.pose3 import Pose3
from arjuna_core.scan import Cloud, Scan
from arjuna_core.se2 import SE2
from arjuna_nav.costmap import FREE, LETHAL, LayeredCostmap, PlacedCloud, PlacedScan
from arjuna_nav.costmap.layers.spatio_temporal import SpatioTemporalVoxelLayer
from tests.helpers.nav.layers import costmap_config

HERE = SE2()
AHEAD = Pose3((0.1, 0.0, 0.5), (0.5, -0.5, 0.5, -0.5))  # a camera's z axis is the robot's x axis
BACK = Pose3.from_rpy((0.0, 0.0, 0.0), (0.0, 0.0, math.pi)) @ AHEAD
LIDAR = Pose3((0.1, 0.0, 0.5))
BEHIND = Pose3.from_rpy((0.1, 0.0, 0.5), (0.0, 0.0, math.pi))
BOX = (1.02, 0.02, 0.7)


def costmap(source: dict[str, Any], **layer: Any) -> LayeredCostmap:
    """Return a costmap that follows the robot, whose marks last 5 s."""
    values = {"plugin": "spatio_temporal_voxel_layer/SpatioTemporalVoxelLayer", "voxel_decay": 5.0}
    values |= {"observation_sources": "eye", "eye": {"clearing": True, **source}, **layer}
    config = costmap_config(
        rolling_window=True, resolution=0.05, width=6, height=6, plugins=("fading",), fading=values
    )
    return LayeredCostmap(config)


def see(
    layered: LayeredCostmap,
    now: float,
    *points: tuple[float, float, float],
    mount: Pose3 = AHEAD,
    pose: SE2 = HERE,
) -> None:
    cloud = Cloud(np.array(points).reshape(-1, 3), np.array(mount.position), now)
    layered.receive("fading", "eye", PlacedCloud(cloud, pose, mount))
    layered.update(pose, now)


def cost(layered: LayeredCostmap, x: float = BOX[0], y: float = BOX[1]) -> int:
    row, column = layered.costmap.frame.to_cell(x, y)
    return int(layered.costmap.data[row, column])


FAST = {"decay_acceleration": 10.0}  # a mark of 5 s that is 2 s old: 3 < 10 / 6 * 2 ** 3
FADING: dict[str, tuple[dict[str, Any], dict[str, Any], Pose3, float, int]] = {
    "within its time": ({}, {}, AHEAD, 4.9, LETHAL),
    "after it": ({}, {}, AHEAD, 5.1, FREE),
    "never by itself": ({}, {"decay_model": -1}, AHEAD, 99.0, LETHAL),
    "exponentially: never by itself": ({}, {"decay_model": 1}, AHEAD, 99.0, LETHAL),
    "mapping: not at all": (FAST, {"mapping_mode": True}, AHEAD, 99.0, LETHAL),
    "looked at": (FAST, {}, AHEAD, 2.0, FREE),
    "looked at, slowly": ({"decay_acceleration": 2.0}, {}, AHEAD, 2.0, LETHAL),
    "looked at, persistent": (FAST, {"decay_model": -1}, AHEAD, 2.0, FREE),
    "looked at, exponentially": (FAST, {"decay_model": 1}, AHEAD, 2.0, FREE),
    "looking another way": (FAST, {}, BACK, 2.0, LETHAL),
    "only marking": ({**FAST, "clearing": False}, {}, AHEAD, 2.0, LETHAL),
    "too far": ({**FAST, "max_z": 0.8}, {}, AHEAD, 2.0, LETHAL),
    "too near": ({**FAST, "min_z": 1.5}, {}, AHEAD, 2.0, LETHAL),
    "from behind itself on": ({**FAST, "min_z": -0.5}, {}, AHEAD, 2.0, FREE),
    "not behind itself": ({**FAST, "min_z": -9.0}, {}, BACK, 2.0, LETHAL),
    "above what is seen": ({**FAST, "vertical_fov_angle": 0.3}, {}, AHEAD, 2.0, LETHAL),
    "a lidar": ({**FAST, "model_type": 1}, {}, LIDAR, 2.0, FREE),
    "a lidar that looks back": ({**FAST, "model_type": 1}, {}, BEHIND, 2.0, LETHAL),
    "a lidar all round": (
        {**FAST, "model_type": 1, "horizontal_fov_angle": 6.29},
        {},
        BEHIND,
        2.0,
        FREE,
    ),
    "within a lidar's padding": (
        {**FAST, "model_type": 1, "vertical_fov_padding": 0.2},
        {},
        LIDAR,
        2.0,
        LETHAL,
    ),
}
"""What is set of the source and of the layer, where it looks, after what time [s], what is left."""


@pytest.mark.parametrize(("source", "layer", "mount", "after", "left"), FADING.values(), ids=FADING)
def test_a_mark_fades(
    source: dict[str, Any], layer: dict[str, Any], mount: Pose3, after: float, left: int
) -> None:
    layered = costmap(source, **layer)
    see(layered, 0.0, BOX)
    assert cost(layered) == LETHAL
    see(layered, after, mount=mount)
    assert cost(layered) == left


def test_what_is_looked_at_again_and_again_fades_the_sooner() -> None:
    layered, times = costmap({"decay_acceleration": 2.0}), np.arange(0.2, 5.0, 0.2)
    see(layered, 0.0, BOX)
    gone = []
    for now in times.tolist():
        see(layered, now)
        gone.append(cost(layered) == FREE)
    assert 1.0 < times[gone.index(True)] < 2.0
    for now in (6.0, 8.0, 10.0, 12.0):
        see(layered, now, BOX)
        assert cost(layered) == LETHAL, "what is still seen stays"


MARKING: dict[str, tuple[dict[str, Any], dict[str, Any], list[tuple[float, float, float]], int]] = {
    "one voxel": ({}, {}, [BOX], LETHAL),
    "fewer voxels than asked for": ({}, {"mark_threshold": 2}, [BOX, BOX], FREE),
    "as many": ({}, {"mark_threshold": 2}, [BOX, (1.02, 0.02, 0.8)], LETHAL),
    "too low": ({"min_obstacle_height": 0.8}, {}, [BOX], FREE),
    "too high": ({"max_obstacle_height": 0.6}, {}, [BOX], FREE),
    "without a filter heights do not count": (
        {"max_obstacle_height": 0.6, "filter": "none"},
        {},
        [BOX],
        LETHAL,
    ),
    "too few points": ({"filter": "voxel", "voxel_min_points": 2}, {}, [BOX], FREE),
    "enough points": ({"filter": "voxel", "voxel_min_points": 2}, {}, [BOX, BOX], LETHAL),
    "too far": ({"obstacle_range": 0.9}, {}, [BOX], FREE),
    "only clearing": ({"marking": False}, {}, [BOX], FREE),
    "switched off": ({"enabled": False}, {}, [BOX], FREE),
}
"""What is set of the source and of the layer, what is seen, and the cost there."""


@pytest.mark.parametrize(("source", "layer", "points", "expected"), MARKING.values(), ids=MARKING)
def test_points_mark(
    source: dict[str, Any],
    layer: dict[str, Any],
    points: list[tuple[float, float, float]],
    expected: int,
) -> None:
    layered = costmap(source, **layer)
    see(layered, 0.0, *points)
    assert cost(layered) == expected


@pytest.mark.parametrize(("once", "left"), [(False, LETHAL), (True, FREE)])
def test_the_latest_counts_until_another_comes_or_once(once: bool, left: int) -> None:
    layered = costmap({"clear_after_reading": once})
    see(layered, 0.0, BOX)
    layered.update(HERE, 9.0)
    assert cost(layered) == left


def test_marks_stay_in_the_world_while_the_robot_drives_away_and_back() -> None:
    layered = costmap({})
    pose = SE2(20.0, -7.0, 1.0)
    see(layered, 0.0, BOX, pose=pose)
    at = pose.apply(np.array([BOX[:2]]))[0].tolist()
    assert cost(layered, *at) == LETHAL
    see(layered, 1.0, pose=SE2(30.0, -7.0))
    see(layered, 2.0, mount=BACK, pose=pose)
    assert cost(layered, *at) == LETHAL


def test_scans_mark_and_under_the_robot_it_is_free() -> None:
    layered = costmap({"data_type": "LaserScan"})
    beams = Scan(np.array([1.02, 0.05]), 0.0, 0.1, 0.01, 12.0)
    layered.receive("fading", "eye", PlacedScan(beams, HERE, 0.3))
    layered.update(HERE, 0.0)
    assert (cost(layered, 1.02, 0.0), cost(layered, 0.05, 0.0)) == (LETHAL, FREE)


@pytest.mark.parametrize(("away", "left"), [(False, [FREE, LETHAL]), (True, [LETHAL, FREE])])
def test_clearing_a_region_forgets_its_voxels(away: bool, left: list[int]) -> None:
    layered = costmap({"clear_after_reading": True, "decay_acceleration": 0.0})
    see(layered, 0.0, BOX, (2.52, 0.02, 0.7), mount=Pose3((0.5, 0.0, 0.5)))
    (layered.clear_except if away else layered.clear_around)(HERE, 3.0)
    layered.update(HERE, 0.1)
    assert [cost(layered, x) for x in (1.02, 2.52)] == left


def test_a_source_that_is_switched_off_forgets_and_one_switched_on_sees_again() -> None:
    layered = costmap({})
    layer = layered.layers["fading"]
    assert isinstance(layer, SpatioTemporalVoxelLayer)
    see(layered, 0.0, BOX)
    np.testing.assert_allclose(layer.voxels(), [(1.025, 0.025, 0.7)], atol=0.03)
    for on, expected in ((False, FREE), (True, LETHAL)):
        layer.switch("eye", on)
        see(layered, 0.1, BOX)
        assert cost(layered) == expected
