"""Manoeuvres: back onto the path where the controller has no way, without a touch."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from arjuna_core.config import load
from arjuna_core.grid import OccupancyGrid
from arjuna_core.se2 import SE2
from arjuna_core.twist import STILL
from arjuna_nav.controllers import ControlStatus
from arjuna_nav.controllers.follower import FollowerConfig, FollowResult, FollowState, PathFollower
from arjuna_nav.controllers.manoeuvre.manoeuvre import Manoeuvre, ManoeuvreConfig
from arjuna_nav.costmap import Costmap
from arjuna_nav.costmap.collision import collides
from arjuna_nav.costmap.footprint import Footprint
from tests.helpers.nav.controllers import PARAMETERS
from tests.nav.worlds import Unicycle, block, costmap_of, empty_grid, polyline

PATIENT = {"failure_tolerance": 0.3}  # as the shipped robot [s]

CORNERS = np.array([[0.3, 0.15], [-0.3, 0.15], [-0.3, -0.15], [0.3, -0.15]])
LONG = Footprint.polygon(CORNERS)
ORIGINS = [SE2(), SE2(5.0, -3.0, 0.8)]


def dead_end(origin: SE2) -> tuple[Costmap, SE2]:
    """Return a corridor too narrow to turn in, and a pose that looks to its closed end."""
    grid: OccupancyGrid = empty_grid(4.0, 3.0, origin)
    block(grid, 1.5, 0.0, 2.5, 1.25)
    block(grid, 1.5, 1.75, 2.5, 1.25)
    block(grid, 3.2, 1.25, 0.8, 0.5)
    return costmap_of(grid, footprint=str(CORNERS.tolist())), origin @ SE2(2.3, 1.5)


def drive(follower: PathFollower, robot: Unicycle, costmap: Costmap) -> FollowResult:
    """Follow to the end, for a minute at most, and never touch anything."""
    for k in range(1200):
        result = follower.tick(robot.pose, robot.velocity, costmap, k * robot.period)
        if result.state is not FollowState.RUNNING:
            return result
        robot.drive(result.velocity)
        assert not collides(costmap, LONG, robot.pose), f"it touches after {k * robot.period:.1f} s"
    return result


@pytest.mark.parametrize("origin", ORIGINS)
@pytest.mark.parametrize("name", ["pure pursuit", "graceful", "mppi"])
def test_backs_out_of_a_dead_end_under_any_controller(name: str, origin: SE2) -> None:
    costmap, start = dead_end(origin)
    out = polyline([(2.3, 1.5), (0.9, 1.5), (0.9, 2.5)], math.pi / 2.0)
    points = origin.apply(out[:, :2])
    path = np.column_stack((points, out[:, 2] + origin.theta))
    follower = PathFollower(load(FollowerConfig, {**PATIENT, "FollowPath": PARAMETERS[name]}), LONG)
    follower.start(path, 0.0)
    robot = Unicycle(start)
    result = drive(follower, robot, costmap)
    assert result.state is FollowState.SUCCEEDED, result.message
    assert robot.pose.distance(SE2.from_array(path[-1])) < 0.25


def test_without_it_following_fails_and_says_why() -> None:
    costmap, start = dead_end(SE2())
    values = {**PATIENT, "FollowPath": PARAMETERS["pure pursuit"], "manoeuvre": {"enabled": False}}
    follower = PathFollower(load(FollowerConfig, values), LONG)
    follower.start(polyline([(2.3, 1.5), (0.9, 1.5), (0.9, 2.5)], 0.0), 0.0)
    result = drive(follower, Unicycle(start), costmap)
    assert result.error is ControlStatus.PATIENCE_EXCEEDED
    assert "collision ahead" in result.message


def test_finds_none_where_there_is_none_and_stops_for_what_comes_up() -> None:
    costmap, start = dead_end(SE2())
    manoeuvre = Manoeuvre(ManoeuvreConfig(), LONG)
    out = polyline([(2.3, 1.5), (0.9, 1.5)], math.pi)
    assert manoeuvre.begin(start, out, costmap)
    command = manoeuvre.compute(start, costmap)
    assert command is not None
    assert command.x < 0.0
    grid = empty_grid(4.0, 3.0)
    block(grid, 1.85, 1.25, 0.1, 0.5)
    closed = costmap_of(grid, footprint=str(CORNERS.tolist()))
    assert manoeuvre.compute(start, closed) in (None, STILL)
    assert not manoeuvre.active
    block(grid, 1.5, 0.0, 2.5, 1.25)
    block(grid, 1.5, 1.75, 2.5, 1.25)
    closed = costmap_of(grid, footprint=str(CORNERS.tolist()))
    assert not manoeuvre.begin(start, out, closed)


@pytest.mark.parametrize("origin", ORIGINS)
@pytest.mark.parametrize(("gap", "waits"), [(0.2, True), (1.2, False)])
def test_what_moves_in_the_way_is_waited_for_and_not_driven_round(
    gap: float, waits: bool, origin: SE2
) -> None:
    grid = empty_grid(5.0, 3.0, origin)
    block(grid, 1.9, 1.25, 0.4, 0.5)
    costmap = costmap_of(grid, footprint=str(CORNERS.tolist()))
    costmap = replace(costmap, moving=np.array([[1.4 + 0.5 + 0.2 + gap, 1.5, 0.2]]))
    points = polyline([(1.4, 1.5), (4.0, 1.5)], 0.0)
    path = np.column_stack((origin.apply(points[:, :2]), points[:, 2] + origin.theta))
    follower = PathFollower(
        load(FollowerConfig, {**PATIENT, "FollowPath": PARAMETERS["pure pursuit"]}), LONG
    )
    follower.start(path, 0.0)
    start = origin @ SE2(1.4, 1.5)
    result = follower.tick(start, STILL, costmap, 0.0)
    assert result.state is FollowState.RUNNING
    assert (result.velocity == STILL) is waits
    assert ("collision ahead" in result.message) is waits
    for k in range(100):
        result = follower.tick(start, STILL, costmap, 0.05 * k)
        assert result.state is FollowState.RUNNING, result.message
    stuck = follower.tick(start, STILL, costmap, 60.0)
    assert stuck.error is ControlStatus.FAILED_TO_MAKE_PROGRESS


def test_the_controller_goes_on_once_it_drives_faster() -> None:
    footprint = str(CORNERS.tolist())
    grid = empty_grid(6.0, 3.0)
    block(grid, 2.0, 1.0, 0.2, 0.65)
    closed, open_ = (costmap_of(one, footprint=footprint) for one in (grid, empty_grid(6.0, 3.0)))
    far = {"rejoin_distance": 2.5, "reach": 2.5}
    values = {**PATIENT, "FollowPath": PARAMETERS["pure pursuit"], "manoeuvre": far}
    follower = PathFollower(load(FollowerConfig, values), LONG)
    follower.start(polyline([(0.8, 1.5), (5.0, 1.5)], 0.0), 0.0)
    robot, speeds, turned = Unicycle(SE2(0.8, 1.5)), [], False
    for k in range(300):
        turned = turned or abs(robot.pose.theta) > 0.3
        costmap = open_ if turned else closed
        result = follower.tick(robot.pose, robot.velocity, costmap, k * robot.period)
        assert result.state is FollowState.RUNNING, result.message
        robot.drive(result.velocity)
        speeds.append(robot.velocity.x if turned and robot.pose.x < 3.0 else 0.0)
    assert turned
    assert max(speeds) > 0.35, "it goes on as slowly as it gets round"


def test_it_goes_on_itself_where_the_outline_does_not_fit_along_the_path() -> None:
    grid = empty_grid(6.0, 3.0)
    block(grid, 3.0, 0.0, 0.2, 1.4)
    block(grid, 3.0, 1.6, 0.2, 1.4)
    narrow = costmap_of(grid, footprint=str(CORNERS.tolist()))
    path, start = polyline([(1.0, 1.5), (5.0, 1.5)], 0.0), SE2(1.6, 1.5)
    manoeuvre = Manoeuvre(ManoeuvreConfig(), LONG)
    assert manoeuvre.begin_to(start, SE2(2.6, 1.5), narrow)
    assert not manoeuvre.may_end(start, path, narrow)
    on = SE2(2.1, 1.5)
    assert not manoeuvre.may_end(on, path, narrow)
    free = costmap_of(empty_grid(6.0, 3.0), footprint=str(CORNERS.tolist()))
    assert manoeuvre.may_end(on, path, free)


def test_a_turn_is_looked_at_no_farther_than_to_its_end() -> None:
    costmap, start = dead_end(SE2())
    manoeuvre = Manoeuvre(ManoeuvreConfig(), LONG)
    assert manoeuvre.begin_to(start, start @ SE2(0.0, 0.0, 0.3), costmap)
    command = manoeuvre.compute(start, costmap)
    assert command is not None
    assert command.yaw_rate > 0.0


def test_a_stretch_is_driven_though_its_end_lies_behind_a_robot_that_turned_too_far() -> None:
    costmap = costmap_of(empty_grid(6.0, 4.0), footprint=str(CORNERS.tolist()))
    manoeuvre = Manoeuvre(ManoeuvreConfig(), LONG)
    assert manoeuvre.begin_to(SE2(2.0, 1.5, 1.2), SE2(3.5, 1.0, -0.5), costmap)
    command = manoeuvre.compute(SE2(2.0, 1.5, 1.5), costmap)
    assert command is not None
    assert command.x > 0.0


@pytest.mark.parametrize(("end", "goes_on"), [((0.3, 1.5), False), ((4.0, 1.4), True)])
def test_a_way_is_let_go_where_the_path_leads_elsewhere_now(
    end: tuple[float, float], goes_on: bool
) -> None:
    grid = empty_grid(5.0, 3.0)
    block(grid, 1.9, 1.25, 0.4, 0.5)
    costmap = costmap_of(grid, footprint=str(CORNERS.tolist()))
    follower = PathFollower(
        load(FollowerConfig, {**PATIENT, "FollowPath": PARAMETERS["pure pursuit"]}), LONG
    )
    follower.start(polyline([(1.4, 1.5), (4.0, 1.5)], 0.0), 0.0)
    robot, farthest = Unicycle(SE2(1.4, 1.5)), 0.0
    for k in range(140):
        if k == 10:
            follower.change(polyline([(1.4, 1.5), end], 0.0))
        result = follower.tick(robot.pose, robot.velocity, costmap, k * robot.period)
        robot.drive(result.velocity)
        farthest = max(farthest, robot.pose.x)
    assert (farthest > 1.6) is goes_on
