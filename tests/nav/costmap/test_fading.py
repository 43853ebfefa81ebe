"""Costs of what moves: where it will be, and no more where it was."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from arjuna_core.grid import GridFrame
from arjuna_core.scan import Cloud
from arjuna_core.se2 import SE2
from arjuna_nav.costmap import LETHAL, LayeredCostmap, PlacedCloud, PlacedScan
from arjuna_nav.costmap.moving.trails import path_costs
from tests.helpers.nav.layers import SCAN, clouds, costmap_config, scans, see
from tests.helpers.nav.played import scan_of

ROOM = np.array([[-4.0, -4, 4, -4], [4, -4, 4, 4], [4, 4, -4, 4], [-4, 4, -4, -4]])


def person(x: float, y: float) -> NDArray[np.float64]:
    turns = np.arange(12) * math.pi / 6.0
    corners = np.array([x, y]) + 0.25 * np.column_stack((np.cos(turns), np.sin(turns)))
    return np.hstack((corners, np.roll(corners, -1, axis=0)))


class Watched:
    """A costmap of a robot that stands in a room where somebody walks."""

    def __init__(self, moving_time: float = 1.5, rolling: bool = False) -> None:
        source = {"obstacle_max_range": 3.0, "raytrace_max_range": 4.0}
        self.layered = LayeredCostmap(
            costmap_config(
                rolling_window=rolling,
                width=8,
                height=8,
                origin_x=-4.0,
                origin_y=-4.0,
                resolution=0.05,
                robot_radius=0.25,
                plugins=("obstacle_layer", "voxel_layer", "inflation_layer"),
                obstacle_layer={
                    **scans(source, moving_time=moving_time),
                    "observation_sources": "scan other",
                    "other": SCAN,
                },
                voxel_layer=clouds(),
            )
        )
        self.time, self.pose = 0.0, SE2()
        self._rng = np.random.default_rng(3)

    def see(self, *people: tuple[float, float], blind: bool = False) -> None:
        """Look round; blind where what is ahead is not seen."""
        walls = np.vstack([ROOM, *(person(*one) for one in people)])
        scan = scan_of(walls, self.pose, self._rng, 0.01, self.time)
        if blind:
            ranges = np.where(np.abs(scan.angles) < 1.3, np.nan, scan.ranges)
            scan = replace(scan, ranges=ranges)
        see(self.layered, self.pose, self.time, [PlacedScan(scan, self.pose)])
        self.time += 0.1

    def see_depth(self, x: float, y: float) -> None:
        """See one point high above the lidar."""
        cloud = Cloud(np.array([[x, y, 1.0]]), np.array([0.0, 0.0, 0.4]), self.time)
        see(self.layered, self.pose, self.time, [PlacedCloud(cloud, self.pose)])

    def cost(self, x: float, y: float) -> int:
        cost = self.layered.costmap.cost_at(x, y)
        assert cost is not None
        return cost

    def lethal_about(self, x: float, y: float) -> int:
        return len(self.layered.costmap.obstacles(x, y, 0.4))


@pytest.mark.parametrize("rolling", [False, True])
@pytest.mark.parametrize(("moving_time", "stays"), [(1.5, False), (0.0, True)])
def test_marks_of_who_has_gone_on_unseen_fade(
    rolling: bool, moving_time: float, stays: bool
) -> None:
    watched = Watched(moving_time, rolling)
    for k in range(12):
        watched.see((0.8, -0.9 + 0.1 * k))
    assert bool(watched.lethal_about(0.8, 0.2)) is (rolling or stays)
    watched.pose = SE2(0.02, 0.06, 0.0)
    for _ in range(3):
        watched.see((0.8, 3.0), blind=True)
    assert bool(watched.lethal_about(0.8, 0.2)) is stays


def test_who_walks_is_not_marked_again_where_another_source_brings_news() -> None:
    watched = Watched()
    for k in range(12):
        watched.see((0.8, -0.9 + 0.1 * k))
    scan = scan_of(ROOM, watched.pose, np.random.default_rng(0), 0.01, watched.time - 0.05)
    watched.layered.receive("obstacle_layer", "other", PlacedScan(scan, watched.pose))
    watched.layered.update(watched.pose, watched.time - 0.05)
    assert not watched.lethal_about(0.8, 0.2)


def test_marks_of_what_stands_stay_unseen() -> None:
    watched = Watched()
    for _ in range(12):
        watched.see((0.8, 0.2))
    for _ in range(12):
        watched.see(blind=True)
    assert watched.lethal_about(0.8, 0.2)


def test_what_a_camera_marked_of_who_walks_fades_and_a_table_beside_stays() -> None:
    watched = Watched()
    for k in range(12):
        watched.see((0.9, -0.9 + 0.1 * k))
    watched.see_depth(0.9, 0.3)
    watched.see_depth(1.8, 0.0)
    assert watched.lethal_about(0.9, 0.3)
    for k in range(12, 25):
        watched.see((0.9, -0.9 + 0.1 * k))
    assert not watched.lethal_about(0.9, 0.3)
    assert watched.lethal_about(1.8, 0.0)


def test_it_costs_to_be_where_somebody_will_be_and_less_the_later() -> None:
    watched = Watched()
    for k in range(12):
        watched.see((1.6, -1.6 + 0.08 * k))
    here, soon, later, never, behind = (watched.cost(1.6, y) for y in (-0.7, -0.2, 0.2, 1.2, -1.7))
    assert LETHAL > here > soon > later > 0
    assert never == behind == 0


@pytest.mark.parametrize(
    ("rolling", "distance", "lethal"), [(True, 0.7, True), (True, 1.8, False), (False, 0.7, False)]
)
def test_who_is_far_will_have_gone_and_is_no_obstacle_nor_to_plans_who_is_near(
    rolling: bool, distance: float, lethal: bool
) -> None:
    watched = Watched(rolling=rolling)
    for k in range(12):
        watched.see((distance, -0.5 + 0.06 * k))
    assert bool(watched.lethal_about(distance, 0.16)) is lethal


@pytest.mark.parametrize("T_map_odom", [SE2(), SE2(3.0, -2.0, 1.1)])
def test_moves_within_is_true_where_anything_moves_near_a_point(T_map_odom: SE2) -> None:
    watched = Watched()
    for k in range(12):
        watched.see((1.6, -1.6 + 0.08 * k), (-1.0, 0.0))
    costmap = watched.layered.costmap.seen_from(T_map_odom)
    (x, y), (beside_x, beside_y) = T_map_odom.apply(np.array([[1.6, -0.2], [-1.0, -0.8]]))
    assert costmap.moves_within(x, y, 0.4)
    assert not costmap.moves_within(x, y, 0.1)
    assert not costmap.moves_within(beside_x, beside_y, 1.0), "who stands does not move"


def test_what_is_laid_over_the_costs_is_taken_off_again() -> None:
    watched, untouched = Watched(), Watched()
    for k in range(40):
        watched.see((1.6, -2.5 + 0.12 * k))
        untouched.see()
        if k == 14:
            assert (watched.layered.costmap.data != untouched.layered.costmap.data).any()
    watched.layered.take_changed()
    for _ in range(20):
        watched.see()
        untouched.see()
    assert watched.layered.take_changed() is not None
    near = (slice(40, 120), slice(80, 136))  # the walls are noisy
    assert not watched.layered.costmap.data[near].any()


@pytest.mark.parametrize("origin", [SE2(), SE2(-3.0, 2.0, 0.6)])
def test_path_costs_lie_where_things_go_on_any_grid(origin: SE2) -> None:
    frame = GridFrame(0.05, 120, 100, origin)
    at, to = (origin.apply(np.array([end]))[0] for end in ([2.0, 2.0], [4.0, 2.0]))
    thing = np.array([[*at, *(to - at), 0.2]])
    patch = path_costs(thing, 0.0, 1.0, 0.25, frame)
    assert patch is not None
    costs = np.zeros(frame.shape, np.uint8)
    costs[patch.window] = patch.costs
    first, middle, last = costs[40, 40], costs[40, 60], costs[40, 78]
    assert first > middle > last > 0
    assert costs[40, 30] > 0
    assert not costs[[40, 62, 40], [20, 60, 100]].any()
    moved = path_costs(thing, 0.5, 1.0, 0.25, frame)
    assert moved is not None
    assert moved.window[1].start == pytest.approx(patch.window[1].start + 20, abs=1)


def test_paths_off_the_grid_cost_nothing() -> None:
    thing = np.array([[20.0, 20.0, 1.0, 0.0, 0.2]])
    assert path_costs(thing, 0.0, 1.5, 0.25, GridFrame(0.05, 40, 40, SE2())) is None
