"""The end of a path: driven into where there is room, tolerated where there is not."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from arjuna_core.config import load
from arjuna_core.grid import OccupancyGrid
from arjuna_core.se2 import SE2, wrap
from arjuna_core.twist import Velocity
from arjuna_nav.controllers.arrival import Arrival, ArrivalConfig
from arjuna_nav.controllers.arrival_curve import ArrivalCurve
from arjuna_nav.controllers.follower import FollowerConfig, FollowResult, FollowState, PathFollower
from arjuna_nav.costmap.footprint import Footprint
from tests.nav.worlds import Unicycle, block, costmap_of, empty_grid, polyline

ROBOT = Footprint.circle(0.25)
POSITION = "nav2_controller::PositionGoalChecker"


def drive(robot: Unicycle, goal: SE2, grid: OccupancyGrid, **values: Any) -> FollowResult:
    """Follow the straight path from where the robot is to a goal until following ends."""
    follower = PathFollower(load(FollowerConfig, values), ROBOT)
    corners = [(robot.pose.x, robot.pose.y), (goal.x, goal.y)]
    costmap, now = costmap_of(grid), 0.0
    follower.start(polyline(corners, goal.theta), now)
    result = FollowResult(FollowState.RUNNING)
    while result.state is FollowState.RUNNING and now < 30.0:
        result = follower.tick(robot.pose, robot.velocity, costmap, now)
        robot.drive(result.velocity)
        now += robot.period
    return result


def off(robot: Unicycle, goal: SE2) -> tuple[float, float]:
    return robot.pose.distance(goal), abs(wrap(robot.pose.theta - goal.theta))


@pytest.mark.parametrize("delay", [0, 1, 3])
@pytest.mark.parametrize("heading", [0.0, 0.6, -2.0, 3.1])
@pytest.mark.parametrize("start", [0.0, 1.0, 2.5])
def test_it_drives_into_the_goal(delay: int, heading: float, start: float) -> None:
    robot = Unicycle(SE2(1.0, 1.0, start), delay=delay)
    goal = SE2(3.0, 1.7, heading)
    assert drive(robot, goal, empty_grid(5.0, 4.0)).state is FollowState.SUCCEEDED
    distance, angle = off(robot, goal)
    assert distance < 0.02
    assert angle < 0.03


@pytest.mark.parametrize("heading", [0.0, 0.5, -1.2, 2.4])
def test_a_curve_into_the_goal_is_sooner_there_and_as_exact(heading: float) -> None:
    times = []
    for curve_time in (0.0, 4.5):
        robot, goal = Unicycle(SE2(1.0, 2.0)), SE2(4.0, 2.0, heading)
        drive(robot, goal, empty_grid(6.0, 4.0), **{"arrival.curve_time": curve_time})
        distance, angle = off(robot, goal)
        assert distance < 0.02
        assert angle < 0.05
        times.append(len(robot.trace) * robot.period)
    straight, curved = times
    assert curved <= straight + 0.05
    assert heading == 0.0 or curved < straight - 0.3


def test_beside_an_obstacle_it_drives_straight_into_the_goal() -> None:
    grid, goal = empty_grid(6.0, 4.0), SE2(4.0, 2.0, 1.2)
    swings = []
    for blocked in (False, True):
        if blocked:
            block(grid, 2.2, 1.5, 1.6, 0.2)  # on the side to which the curve would swing
        robot = Unicycle(SE2(1.0, 2.0))
        drive(robot, goal, grid)
        assert off(robot, goal)[0] < 0.02
        swings.append(2.0 - min(pose.y for pose in robot.trace))
    assert swings[0] > 0.06
    assert swings[1] < 0.03


@pytest.mark.parametrize("speed", [0.2, 0.5, 1.0, 2.0])
def test_a_fast_robot_brakes_in_time(speed: float) -> None:
    robot = Unicycle(SE2(1.0, 2.0, 0.0))
    goal = SE2(6.0, 2.0, 0.0)
    grid = empty_grid(8.0, 4.0)
    assert drive(robot, goal, grid, **{"FollowPath.desired_linear_vel": speed})
    assert off(robot, goal)[0] < 0.02
    assert max(pose.x for pose in robot.trace) < 6.06


def test_where_it_is_switched_off_the_tolerance_is_the_end() -> None:
    robot, goal = Unicycle(SE2(1.0, 2.0)), SE2(3.0, 2.0)
    drive(robot, goal, empty_grid(5.0, 4.0), **{"arrival.enabled": False})
    assert 0.1 < off(robot, goal)[0] < 0.26


def test_a_heading_that_does_not_matter_is_not_turned_to() -> None:
    robot, goal = Unicycle(SE2(1.0, 2.0)), SE2(3.0, 2.0, 2.0)
    checker = {"general_goal_checker.plugin": POSITION}
    assert drive(robot, goal, empty_grid(5.0, 4.0), **checker).state is FollowState.SUCCEEDED
    assert off(robot, goal)[0] < 0.02
    assert abs(robot.pose.theta) < 0.1


def test_without_room_it_leaves_the_rest_to_the_controller() -> None:
    arrival = Arrival(ArrivalConfig(), ROBOT)
    pose, goal, grid = SE2(2.6, 2.0), SE2(3.0, 2.0), empty_grid(5.0, 4.0)

    def asked(grid: OccupancyGrid, within: bool) -> Velocity | None:
        told: dict[str, Any] = {"left": 0.4, "speed": 0.5, "within": within, "heading": True}
        return arrival.compute(pose, goal, Velocity(), costmap_of(grid), 0.0, **told)

    blocked = empty_grid(5.0, 4.0)
    block(blocked, 3.15, 1.5, 0.2, 1.0)
    assert asked(blocked, within=False) is None
    assert asked(grid, within=False) == Velocity(0.5), "what was in the way has gone"
    assert asked(blocked, within=True) is None
    assert asked(grid, within=True) is None, "what is tolerated was enough"
    arrival.reset()
    assert asked(grid, within=True) is not None


def test_a_robot_that_cannot_get_nearer_has_arrived() -> None:
    class Stuck(Unicycle):
        def drive(self, command: Velocity) -> None:
            super().drive(command if self.pose.x < 2.9 else Velocity())

    robot, goal = Stuck(SE2(1.0, 2.0)), SE2(3.0, 2.0, 1.0)
    tolerant = {"general_goal_checker.yaw_goal_tolerance": 1.5}
    assert drive(robot, goal, empty_grid(5.0, 4.0), **tolerant).state is FollowState.SUCCEEDED
    assert len(robot.trace) < 15.0 / robot.period


def test_it_goes_no_faster_than_the_limit_and_never_far_past_the_goal() -> None:
    robot, goal = Unicycle(SE2(1.0, 2.0, 0.3)), SE2(4.0, 2.0, 0.0)
    drive(robot, goal, empty_grid(6.0, 4.0))
    xs = np.array([pose.x for pose in robot.trace])
    assert np.abs(np.diff(xs)).max() <= 0.5 * robot.period + 1e-9
    assert xs.max() < 4.02
    assert math.isclose(robot.velocity.x, 0.0, abs_tol=0.05)


@pytest.mark.parametrize("heading", [2.9, -2.9])
def test_what_turning_on_the_spot_moves_it_along_the_heading_is_driven_back(heading: float) -> None:
    class Lopsided(Unicycle):
        """Turns about a place ahead of its own."""

        def drive(self, command: Velocity) -> None:
            super().drive(command)
            self.pose = self.pose @ SE2(0.0, -0.015 * self.velocity.yaw_rate * self.period)

    robot, goal = Lopsided(SE2(1.0, 2.0)), SE2(3.0, 2.0, heading)
    drive(robot, goal, empty_grid(5.0, 4.0))
    ahead = robot.pose.inverse() @ goal
    assert abs(ahead.x) < 0.01
    assert off(robot, goal)[1] < 0.03


def test_pushed_far_away_in_its_last_turn_it_leaves_the_way_back_to_the_controller() -> None:
    arrival, goal = Arrival(ArrivalConfig(), ROBOT), SE2(3.0, 2.0, 2.0)
    costmap = costmap_of(empty_grid(5.0, 4.0))

    def asked(pose: SE2, within: bool) -> Velocity | None:
        left = pose.distance(goal)
        told: dict[str, Any] = {"left": left, "speed": 0.5, "within": within, "heading": True}
        return arrival.compute(pose, goal, Velocity(), costmap, 0.0, **told)

    turning = asked(SE2(3.0, 2.0), within=True)
    assert turning is not None
    assert turning.yaw_rate > 0.0
    assert asked(SE2(1.0, 2.0, 1.5), within=False) is None
    back = asked(SE2(2.8, 2.0), within=True)
    assert back is not None
    assert back.x > 0.0, "it drives into the goal anew"


def test_pushed_away_after_it_was_over_it_arrives_anew() -> None:
    arrival, goal = Arrival(ArrivalConfig(), ROBOT), SE2(3.0, 2.0)
    costmap = costmap_of(empty_grid(5.0, 4.0))

    def asked(pose: SE2, within: bool, now: float) -> Velocity | None:
        left = pose.distance(goal)
        told: dict[str, Any] = {"left": left, "speed": 0.5, "within": within, "heading": True}
        return arrival.compute(pose, goal, Velocity(), costmap, now, **told)

    held = SE2(2.9, 2.0)  # somebody stands in its way
    assert asked(held, True, 0.0) is not None
    assert asked(held, True, 3.0) is None
    assert asked(held, True, 3.1) is None, "what is tolerated was enough"
    assert asked(SE2(1.0, 2.0, 1.5), False, 4.0) is None
    assert asked(SE2(2.6, 2.0), False, 8.0) is not None


def test_its_patience_counts_from_when_the_way_is_free_again() -> None:
    arrival, pose, goal = Arrival(ArrivalConfig(), ROBOT), SE2(2.6, 2.0), SE2(3.0, 2.0)
    grid, blocked = empty_grid(5.0, 4.0), empty_grid(5.0, 4.0)
    block(blocked, 3.15, 1.5, 0.2, 1.0)

    def asked(grid: OccupancyGrid, now: float) -> Velocity | None:
        told: dict[str, Any] = {"left": 0.4, "speed": 0.5, "within": False, "heading": False}
        return arrival.compute(pose, goal, Velocity(), costmap_of(grid), now, **told)

    assert asked(grid, 0.0) is not None
    assert asked(blocked, 0.1) is None
    assert asked(grid, 5.0) is not None


def test_a_curve_that_leaves_the_map_is_not_driven() -> None:
    curve = ArrivalCurve(ROBOT, 1.2, 0.8, 0.12)
    for y, drives in ((2.0, True), (0.02, False)):
        pose, goal = SE2(1.0, y), SE2(3.0, y, 0.8)  # it swings to the right
        curve.reset()
        got = curve.compute(pose, goal, Velocity(), costmap_of(empty_grid(5.0, 4.0)), 0.5)
        assert (got is not None) == drives
