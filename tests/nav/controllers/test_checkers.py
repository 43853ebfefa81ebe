"""Goal and progress checkers, limits of the speed."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from numpy.typing import NDArray

from arjuna_core.config import load
from arjuna_core.grid import OccupancyGrid
from arjuna_core.se2 import SE2
from arjuna_core.twist import Velocity
from arjuna_nav.controllers.checkers import (
    GoalConfig,
    PoseProgressChecker,
    PoseProgressConfig,
    PositionGoalChecker,
    PositionGoalConfig,
    ProgressConfig,
    SimpleGoalChecker,
    SimpleProgressChecker,
    StoppedGoalChecker,
    StoppedGoalConfig,
)
from arjuna_nav.controllers.follower import FollowerConfig, FollowState, PathFollower
from arjuna_nav.controllers.speed_limits import ForesightConfig, allowed_speed
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.costmap.inflation import clearances, cost_at_distance
from tests.nav.worlds import Unicycle, block, costmap_of, empty_grid, polyline

GOAL = SE2(1.0, 0.0, 3.1)


def test_arrives_with_position_and_heading() -> None:
    checker = SimpleGoalChecker(GoalConfig(xy_goal_tolerance=0.2, yaw_goal_tolerance=0.15))
    assert not checker.reached(SE2(0.7, 0.0, 3.1), GOAL)
    assert not checker.reached(SE2(0.9, 0.0, 2.9), GOAL)
    assert checker.reached(SE2(0.9, 0.0, -3.12), GOAL), "headings wrap"


@pytest.mark.parametrize(
    ("x", "yaw", "arrives"),
    [(0.75, 0.5, True), (0.749, 0.5, False), (0.75, 0.501, False), (0.75, -0.5, True)],
)
def test_a_tolerance_is_tolerated_to_its_edge(x: float, yaw: float, arrives: bool) -> None:
    config = GoalConfig(xy_goal_tolerance=0.25, yaw_goal_tolerance=0.5)
    assert SimpleGoalChecker(config).reached(SE2(x, 0.0, yaw), SE2(1.0)) is arrives
    at_any = PositionGoalChecker(PositionGoalConfig(0.25))
    assert at_any.reached(SE2(x), SE2(1.0)) is (x == 0.75)


@pytest.mark.parametrize("stateful", [True, False])
@pytest.mark.parametrize("heading", [True, False])
def test_a_position_reached_stays_reached_where_stateful(heading: bool, stateful: bool) -> None:
    simple = SimpleGoalChecker(GoalConfig(xy_goal_tolerance=0.2, stateful=stateful))
    checker = simple if heading else PositionGoalChecker(PositionGoalConfig(0.2, stateful))
    assert not checker.reached(SE2(0.7, 0.0, 3.1), GOAL)
    assert checker.reached(SE2(0.9, 0.0, 1.0), GOAL) is not heading
    assert checker.reached(SE2(0.7, 0.0, 3.1), GOAL) is stateful
    checker.reset()
    assert not checker.reached(SE2(0.7, 0.0, 3.1), GOAL)


@pytest.mark.parametrize(
    "checker",
    [
        SimpleGoalChecker(GoalConfig(0.2, yaw_goal_tolerance=3.2)),
        PositionGoalChecker(PositionGoalConfig(0.2)),
    ],
)
def test_a_pushed_robot_has_to_return(checker: SimpleGoalChecker | PositionGoalChecker) -> None:
    assert checker.reached(SE2(0.9, 0.0, 0.0), GOAL)
    assert not checker.reached(SE2(0.4, 0.0, 0.0), GOAL)
    assert not checker.reached(SE2(0.7, 0.0, 0.0), GOAL), "it has to come back"
    assert checker.reached(SE2(0.9, 0.0, 0.0), GOAL)


def test_arrives_backwards_too_where_that_is_as_good() -> None:
    for symmetric in (True, False):
        checker = SimpleGoalChecker(GoalConfig(symmetric_yaw_tolerance=symmetric))
        assert checker.reached(SE2(1.0, 0.0, 0.1), GOAL) is symmetric
        assert checker.reached(SE2(1.0, 0.0, -3.1), GOAL)
        assert not checker.reached(SE2(1.0, 0.0, 1.6), GOAL)


@pytest.mark.parametrize(
    ("velocity", "stands"),
    [
        (Velocity(0.25, yaw_rate=-0.25), True),
        (Velocity(-0.25, yaw_rate=0.25), True),
        (Velocity(0.3), False),
        (Velocity(-0.3), False),
        (Velocity(yaw_rate=-0.3), False),
    ],
)
def test_arrives_only_once_it_stands(velocity: Velocity, stands: bool) -> None:
    checker = StoppedGoalChecker(StoppedGoalConfig())
    assert checker.reached(GOAL, GOAL, velocity) is stands
    assert not checker.reached(SE2(0.0, 0.0, 0.0), GOAL, velocity)


def test_turning_is_progress_where_the_pose_counts() -> None:
    config = PoseProgressConfig(0.5, 10.0, required_movement_angle=0.5)
    checker = PoseProgressChecker(config)
    assert checker.check(SE2(0.0, 0.0, 3.1), 0.0)
    assert checker.check(SE2(0.0, 0.0, -2.6), 9.0), "headings wrap"
    assert not checker.check(SE2(0.0, 0.0, -2.2), 19.1)
    assert "turned less than 0.5 rad and" in checker.failure_message()
    assert checker.check(SE2(0.6, 0.0, -2.2), 19.2)


def test_asks_for_movement_within_the_time_allowed() -> None:
    config = ProgressConfig(required_movement_radius=0.5, movement_time_allowance=10.0)
    checker = SimpleProgressChecker(config)
    assert checker.check(SE2(), 0.0)
    assert checker.check(SE2(0.4, 0.0), 10.0)
    assert not checker.check(SE2(0.4, 0.0), 10.1)
    assert checker.check(SE2(0.6, 0.0), 10.2)
    assert checker.check(SE2(0.6, 0.0), 20.2)
    assert not checker.check(SE2(0.6, 0.0), 20.3)
    checker.reset()
    assert checker.check(SE2(0.6, 0.0), 20.4)


@pytest.mark.parametrize("pose", [SE2(0.5, 0.0, 0.0), SE2(0.0, 0.0, -0.5), SE2(0.3, 0.4, 0.5)])
def test_just_as_far_as_is_required_is_not_yet_progress(pose: SE2) -> None:
    checker = PoseProgressChecker(PoseProgressConfig(0.5, 10.0, required_movement_angle=0.5))
    assert checker.check(SE2(), 0.0)
    assert checker.check(pose, 10.0)
    assert not checker.check(pose, 10.1)
    assert checker.failure_message() == "turned less than 0.5 rad and moved less than 0.5 m in 10 s"


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
    values = {"arrival.enabled": False, "general_goal_checker.path_length_tolerance": 1e6}
    follower = PathFollower(load(FollowerConfig, values), Footprint.circle(0.25))
    follower.start(polyline(corners, 0.0), 0.0)  # as Nav2: by its pose alone
    assert follower.tick(SE2(1.0, 1.0), Velocity(), costmap, 0.0).state is FollowState.SUCCEEDED
