"""Limits of any controller's speed by what lies ahead; a loop's end is not its start."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from numpy.typing import NDArray

from arjuna_core.config import load
from arjuna_core.grid import OccupancyGrid
from arjuna_core.se2 import SE2
from arjuna_nav.controllers.follower import FollowerConfig, FollowState, PathFollower
from arjuna_nav.controllers.speed_limits import ForesightConfig, allowed_speed
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.costmap.inflation import clearances, cost_at_distance
from tests.nav.worlds import Unicycle, block, costmap_of, empty_grid, polyline

FAST = 2.0
STRAIGHT = polyline([(1.0, 2.0), (9.0, 2.0)], 0.0)


def allowed(
    x: float, grid: OccupancyGrid, path: NDArray[np.float64] = STRAIGHT, **values: float
) -> float:
    """Return the speed that is allowed on a path at an x of it."""
    ahead = path[int(np.argmin(np.abs(path[:, 0] - x))) :]
    pose = SE2.from_array(ahead[0])
    config = ForesightConfig(**values)  # type: ignore[arg-type]
    return allowed_speed(config, ahead, pose, costmap_of(grid), FAST)


def with_a_gap(width: float) -> OccupancyGrid:
    grid = empty_grid(10.0, 4.0)
    block(grid, 6.0, 0.0, 0.5, 2.0 - width / 2.0)
    block(grid, 6.0, 2.0 + width / 2.0, 0.5, 2.0 - width / 2.0)
    return grid


def test_costs_encode_the_clearance_they_were_made_of() -> None:
    room = clearances(5.0)
    for beyond in (0.02, 0.1, 0.3):
        assert room[cost_at_distance(0.25 + beyond, 0.25, 5.0)] == pytest.approx(beyond, abs=0.01)
    assert room[253] == room[254] == 0.0
    assert math.isinf(room[0])
    assert math.isinf(room[255])


def test_where_there_is_room_nothing_slows_it_down() -> None:
    assert allowed(1.0, empty_grid(10.0, 4.0)) == FAST


def test_it_is_slow_in_a_gap_and_brakes_before_it_in_time() -> None:
    grid = with_a_gap(0.8)
    speeds = [allowed(x, grid) for x in np.arange(1.0, 8.0, 0.1)]
    assert speeds[0] == FAST
    assert 0.3 <= min(speeds) < 1.2
    assert min(speeds) == pytest.approx(allowed(6.2, grid), abs=0.1)
    assert speeds[-1] == FAST
    for before, after in itertools.pairwise(speeds):
        assert after**2 >= before**2 - 2.0 * 1.5 * 0.11 - 1e-6, "no harder than it can brake"


def test_the_narrower_the_slower_but_never_below_the_least() -> None:
    speeds = [allowed(6.2, with_a_gap(width)) for width in (1.2, 0.9, 0.7, 0.5)]
    assert speeds == sorted(speeds, reverse=True)
    assert speeds[-1] == 0.3
    assert allowed(6.2, with_a_gap(0.5), enabled=False) == FAST


def test_a_bend_ahead_is_braked_for() -> None:
    angles = np.linspace(-math.pi / 2.0, 0.0, 40)
    bend = [(5.0 + 0.5 * math.cos(a), 2.5 + 0.5 * math.sin(a)) for a in angles]
    path = polyline([(1.0, 2.0), *bend, (5.5, 3.9)], math.pi / 2.0)
    grid = empty_grid(10.0, 8.0)
    assert allowed(1.0, grid, path) == FAST
    assert allowed(5.2, grid, path) == pytest.approx(math.sqrt(1.0 * 0.5), abs=0.12)
    assert allowed(4.0, grid, path) < FAST


def test_a_slow_robot_is_not_slowed_down() -> None:
    costmap = costmap_of(with_a_gap(0.6))
    pose = SE2.from_array(STRAIGHT[100])
    assert allowed_speed(ForesightConfig(), STRAIGHT[100:], pose, costmap, 0.2) == 0.2


def test_a_loop_is_driven_before_its_end_counts() -> None:
    corners = [(1.0, 1.0), (3.0, 1.0), (3.0, 3.0), (1.0, 3.0), (1.05, 1.05)]
    robot, costmap = Unicycle(SE2(1.0, 1.0)), costmap_of(empty_grid(5.0, 5.0))
    follower = PathFollower(load(FollowerConfig, {}), Footprint.circle(0.25))
    follower.start(polyline(corners, 0.0), 0.0)
    for k in range(1200):
        result = follower.tick(robot.pose, robot.velocity, costmap, k * robot.period)
        if result.state is not FollowState.RUNNING:
            break
        robot.drive(result.velocity)
    assert result.state is FollowState.SUCCEEDED
    assert max(pose.y for pose in robot.trace) > 2.8
    assert robot.pose.distance(SE2(1.05, 1.05)) < 0.02
