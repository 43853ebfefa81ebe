"""Escapes: back onto the path where the controller has no valid control, without a touch."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from arjuna_core.config import load
from arjuna_core.grid import OccupancyGrid
from arjuna_core.se2 import SE2
from arjuna_core.twist import STILL
from arjuna_nav.controllers import ControlStatus
from arjuna_nav.controllers.escape import Escape, EscapeConfig
from arjuna_nav.controllers.follower import FollowerConfig, FollowResult, FollowState, PathFollower
from arjuna_nav.controllers.tracker import TrackerConfig
from arjuna_nav.costmap import Costmap
from arjuna_nav.costmap.collision import collides
from arjuna_nav.costmap.footprint import Footprint
from tests.helpers.nav.controllers import PARAMETERS
from tests.nav.worlds import Unicycle, block, costmap_of, empty_grid, grid_of, polyline

PATIENT = {"failure_tolerance": 0.3}  # as the shipped robot [s]

CORNERS = np.array([[0.3, 0.15], [-0.3, 0.15], [-0.3, -0.15], [0.3, -0.15]])
LONG = Footprint.polygon(CORNERS)
ORIGINS = [SE2(), SE2(5.0, -3.0, 0.8)]


def dead_end(origin: SE2) -> tuple[Costmap, SE2]:
    """Return a corridor too narrow to turn in, and a pose that faces its closed end."""
    grid: OccupancyGrid = empty_grid(4.0, 3.0, origin)
    block(grid, 1.5, 0.0, 2.5, 1.25)
    block(grid, 1.5, 1.75, 2.5, 1.25)
    block(grid, 3.2, 1.25, 0.8, 0.5)
    return costmap_of(grid, footprint=str(CORNERS.tolist())), origin @ SE2(2.3, 1.5)


def made(**values: Any) -> Escape:
    return Escape(EscapeConfig(**values), TrackerConfig(), LONG, LONG)


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
    values = {**PATIENT, "FollowPath": PARAMETERS["pure pursuit"], "escape": {"enabled": False}}
    follower = PathFollower(load(FollowerConfig, values), LONG)
    follower.start(polyline([(2.3, 1.5), (0.9, 1.5), (0.9, 2.5)], 0.0), 0.0)
    result = drive(follower, Unicycle(start), costmap)
    assert result.error is ControlStatus.PATIENCE_EXCEEDED
    assert "collision ahead" in result.message


def test_finds_no_escape_where_there_is_none_and_waits_for_newcomers() -> None:
    costmap, start = dead_end(SE2())
    escape, out = made(patience=1.0), polyline([(2.3, 1.5), (0.9, 1.5)], math.pi)
    assert escape.begin(start, out, costmap)
    command = escape.compute(start, STILL, out, costmap, 0.0)
    assert command is not None
    assert command.x < 0.0
    grid = grid_of(4.0, 3.0, (1.85, 1.25, 0.1, 0.5), (1.5, 0.0, 2.5, 1.25), (1.5, 1.75, 2.5, 1.25))
    closed = costmap_of(grid, footprint=str(CORNERS.tolist()))
    assert escape.compute(start, STILL, out, closed, 0.1) == STILL
    assert escape.compute(start, STILL, out, closed, 1.0) == STILL
    assert escape.compute(start, STILL, out, costmap, 1.05) == command, "it has gone"
    assert escape.compute(start, STILL, out, closed, 1.1) == STILL
    assert escape.compute(start, STILL, out, closed, 2.2) is None
    assert not escape.active
    assert not escape.begin(start, out, closed)
    assert not made(enabled=False).begin(start, out, costmap)


@pytest.mark.parametrize("origin", ORIGINS)
@pytest.mark.parametrize(("gap", "waits"), [(0.2, True), (1.2, False)])
def test_crossing_people_are_waited_for(gap: float, waits: bool, origin: SE2) -> None:
    grid = grid_of(5.0, 3.0, (1.9, 1.25, 0.4, 0.5), origin=origin)
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


def test_the_controller_continues_once_it_drives_faster() -> None:
    footprint = str(CORNERS.tolist())
    grid = grid_of(6.0, 3.0, (2.0, 1.0, 0.2, 0.65))
    closed, open_ = (costmap_of(one, footprint=footprint) for one in (grid, empty_grid(6.0, 3.0)))
    far = {"rejoin_distance": 2.5, "reach": 2.5}
    values = {**PATIENT, "FollowPath": PARAMETERS["pure pursuit"], "escape": far}
    follower = PathFollower(load(FollowerConfig, values), LONG)
    follower.start(polyline([(0.8, 1.5), (5.0, 1.5)], 0.0), 0.0)
    robot, speeds, turned = Unicycle(SE2(0.8, 1.5)), [], False
    for k in range(300):
        turned = turned or abs(robot.pose.theta) > 0.3
        costmap = open_ if turned else closed
        result = follower.tick(robot.pose, robot.velocity, costmap, k * robot.period)
        assert result.state is FollowState.RUNNING, result.message
        robot.drive(result.velocity)
        speeds.append(robot.velocity.x if turned and robot.pose.x < 3.3 else 0.0)
    assert turned
    assert max(speeds) > 0.35, "it drives as slowly as it gets round"


AT = SE2(2.0, 1.5)
AHEAD = polyline([(2.0, 1.5), (5.0, 1.5)], 0.0)
FREE = costmap_of(empty_grid(6.0, 3.0), footprint=str(CORNERS.tolist()))


def with_blocks(*blocks: tuple[float, float, float, float]) -> Costmap:
    grid = empty_grid(6.0, 3.0)
    for one in blocks:
        block(grid, *one)
    return costmap_of(grid, footprint=str(CORNERS.tolist()))


BOX = with_blocks((2.4, 1.35, 0.2, 0.3))


def driven(escape: Escape, costmap: Costmap, pose: SE2 = AT, speed: float = math.inf) -> list[SE2]:
    """Return the poses of a robot that drives exactly what is commanded."""
    poses, now = [pose], 0.0
    while now < 60.0:
        command = escape.compute(poses[-1], STILL, AHEAD, costmap, now, speed)
        if command is None:
            return poses
        now += 0.02
        poses.append(poses[-1] @ SE2.exp((0.02 * command.x, 0.0, 0.02 * command.yaw_rate)))
    raise AssertionError("it does not end")


def test_it_leads_beyond_what_blocks_it_and_no_farther_than_it_reaches() -> None:
    escape = made()
    assert escape.begin(AT, AHEAD, BOX)
    assert 2.9 < driven(escape, BOX)[-1].x < 4.6
    assert not made(reach=0.8).begin(AT, AHEAD, BOX), "all within its reach is blocked"
    for least, most in ((0.5, 0.8), (1.5, 1.7)):
        bounded = made(rejoin_distance=least, reach=most)
        assert bounded.begin(AT, AHEAD, FREE)
        gone = driven(bounded, FREE)[-1].x - AT.x
        assert least - 0.12 < gone < most + 0.1


def test_it_drives_no_faster_than_it_may() -> None:
    for limit, fastest in ((math.inf, 0.3), (0.1, 0.1)):
        escape = made()
        assert escape.begin(AT, AHEAD, FREE)
        poses = driven(escape, FREE, speed=limit)
        steps = [a.distance(b) for a, b in itertools.pairwise(poses)]
        assert max(steps) == pytest.approx(0.02 * fastest)


def test_a_controller_takes_over_where_only_driving_ahead_is_left_and_some_is_done() -> None:
    ahead = made()
    assert ahead.begin(AT, AHEAD, FREE)
    assert not ahead.can_hand_over(SE2(2.29, 1.5), AHEAD, FREE)
    assert ahead.can_hand_over(SE2(2.31, 1.5), AHEAD, FREE)
    for x, free in ((3.0, False), (4.2, True)):  # a metre of the path has to be free
        blocked = with_blocks((x, 1.2, 0.1, 0.6))
        assert ahead.can_hand_over(SE2(2.31, 1.5), AHEAD, blocked) is free
    costmap, start = dead_end(SE2())
    out = polyline([(2.3, 1.5), (0.9, 1.5)], math.pi)
    back = made()
    assert back.begin(start, out, costmap)
    assert not back.can_hand_over(start @ SE2(-0.5, 0.0), out, costmap), "it backs"


@pytest.mark.parametrize(("aside", "near"), [(0.45, True), (0.65, False)])
def test_it_leads_to_a_path_near_its_end(aside: float, near: bool) -> None:
    escape = made(rejoin_distance=0.5, reach=0.5)
    assert escape.leads_to(AHEAD, FREE), "there is none to lead elsewhere"
    assert escape.begin(AT, AHEAD, FREE)
    path = polyline([(0.5, 1.5 + aside), (2.6, 1.5 + aside)], 0.0)
    assert escape.leads_to(path, FREE) is near


def test_it_drives_in_the_frame_in_which_the_costmap_is_kept() -> None:
    """The pose on a map jumps: the driven path has not moved for that."""
    escape, jump = made(), SE2(0.3, -0.2, 0.1)
    assert escape.begin(AT, AHEAD, BOX)
    before = escape.compute(AT, STILL, AHEAD, BOX, 0.0)
    points = np.column_stack((jump.apply(AHEAD[:, :2]), AHEAD[:, 2] + jump.theta))
    after = escape.compute(jump @ AT, STILL, points, BOX.seen_from(jump), 0.05)
    assert before is not None
    assert after is not None
    assert (after.x, after.yaw_rate) == pytest.approx((before.x, before.yaw_rate))


WALL = with_blocks((0.0, 0.8, 6.0, 0.2))
ALONG = polyline([(2.0, 1.2), (5.0, 1.2)], 0.0)


@pytest.mark.parametrize(("heading", "sign"), [(0.9, 1.0), (-0.9, -1.0)])
def test_it_leaves_an_obstacle_straight_before_it_turns(heading: float, sign: float) -> None:
    start, escape = SE2(2.0, 1.2, heading), made()
    assert collides(WALL, LONG, start)
    assert escape.begin(start, ALONG, WALL)
    command = escape.compute(start, STILL, ALONG, WALL, 0.0)
    assert command is not None
    assert command.x * sign > 0.0
    assert command.yaw_rate == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("turns", [True, False])
def test_a_controller_that_turns_a_robot_that_touches_something_is_not_obeyed(turns: bool) -> None:
    """It would scrape along; what drives on more than it turns is let through."""
    start = SE2(2.0, 1.2, 0.9 if turns else 0.35)
    assert collides(WALL, LONG, start)
    follower = PathFollower(
        load(FollowerConfig, {**PATIENT, "FollowPath": PARAMETERS["pure pursuit"]}), LONG
    )
    path = polyline([(2.0, 1.2), (2.0, 2.8)] if turns else [(2.0, 1.2), (5.0, 2.4)], 0.0)
    path = polyline([(2.0, 1.2), (0.5, 2.4)], 0.0) if turns else path
    follower.start(path, 0.0)
    result = follower.tick(start, STILL, WALL, 0.0)
    assert result.state is FollowState.RUNNING
    if turns:
        assert abs(result.velocity.yaw_rate) < 1e-6
    assert result.velocity.x > 0.0


@pytest.mark.parametrize(("end", "continues"), [((0.3, 1.5), False), ((4.0, 1.4), True)])
def test_an_old_trajectory_is_dropped(end: tuple[float, float], continues: bool) -> None:
    costmap = costmap_of(grid_of(5.0, 3.0, (1.9, 1.25, 0.4, 0.5)), footprint=str(CORNERS.tolist()))
    follower = PathFollower(
        load(FollowerConfig, {**PATIENT, "FollowPath": PARAMETERS["pure pursuit"]}), LONG
    )
    follower.start(polyline([(1.4, 1.5), (4.0, 1.5)], 0.0), 0.0)
    robot, farthest = Unicycle(SE2(1.4, 1.5)), 0.0
    for k in range(200):
        if k == 10:
            follower.change(polyline([(1.4, 1.5), end], 0.0))
        result = follower.tick(robot.pose, robot.velocity, costmap, k * robot.period)
        robot.drive(result.velocity)
        farthest = max(farthest, robot.pose.x)
    assert (farthest > 1.6) is continues


@pytest.mark.parametrize("strayed", [SE2(0.0, 0.2), SE2(0.0, 0.0, 0.7)])
def test_a_robot_that_was_pushed_off_its_trajectory_gets_another(strayed: SE2) -> None:
    costmap = costmap_of(empty_grid(4.0, 3.0), footprint=str(CORNERS.tolist()))
    path = polyline([(0.5, 1.5), (3.5, 1.5)], 0.0)
    escape, pose = made(), SE2(1.0, 1.5)
    assert escape.begin(pose, path, costmap)
    kept = escape._tracker.pieces[0]
    escape.compute(pose @ SE2(0.02, 0.02, 0.1), STILL, path, costmap, 0.0)
    assert escape._tracker.pieces[0] is kept
    escape.compute(pose @ strayed, STILL, path, costmap, 0.05)
    assert escape._tracker.pieces[0].start.distance(pose @ strayed) < 1e-6
    assert escape._tracker.pieces[0].start.theta == pytest.approx(strayed.theta)


@pytest.mark.parametrize("radius", [0.4, 0.8])
def test_a_steered_robot_backs_out_of_a_dead_end_on_bends_that_it_can_drive(radius: float) -> None:
    costmap, start = dead_end(SE2())
    path = polyline([(2.3, 1.5), (0.8, 1.5), (0.8, 2.6)], math.pi / 2.0)
    path[path[:, 1] < 1.6, 2] = 0.0  # driven back as far as the bend
    escape = Escape(EscapeConfig(reach=1.5), TrackerConfig(), LONG, LONG, radius)
    assert escape.begin(start, path, costmap)
    robot = Unicycle(start, steered=True)
    for k in range(400):
        command = escape.compute(robot.pose, robot.velocity, path, costmap, k * robot.period)
        if command is None:
            break
        assert abs(command.yaw_rate) <= abs(command.x) / radius + 1e-9
        robot.drive(command)
        assert not collides(costmap, LONG, robot.pose)
    assert not escape.active
    assert robot.pose.x < 1.85, "half a metre of the path at the least"
    assert abs(robot.pose.theta) < 0.1, "as the path leads back"
