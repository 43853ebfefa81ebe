"""The final approach: into the goal where there is room, tolerated where there is not."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from arjuna_core.config import load
from arjuna_core.grid import OccupancyGrid
from arjuna_core.se2 import SE2, wrap
from arjuna_core.twist import STILL, Velocity
from arjuna_nav.controllers.approach import ApproachConfig, Arrival, FinalApproach
from arjuna_nav.controllers.follower import FollowerConfig, FollowResult, FollowState, PathFollower
from arjuna_nav.controllers.tracker import TrackerConfig
from arjuna_nav.costmap import Costmap
from arjuna_nav.costmap.footprint import Footprint
from tests.nav.worlds import Unicycle, block, costmap_of, empty_grid, grid_of, polyline

ROBOT = Footprint.circle(0.25)
BODY = Footprint.polygon(np.array([[0.35, 0.2], [0.35, -0.2], [-0.35, -0.2], [-0.35, 0.2]]))
POSITION = "nav2_controller::PositionGoalChecker"


def drive(
    robot: Unicycle, goal: SE2, grid: OccupancyGrid, body: Footprint | None = None, /, **values: Any
) -> FollowResult:
    """Follow the straight path from where the robot is to a goal until following ends."""
    config = load(FollowerConfig, values)
    follower = PathFollower(config, ROBOT, body=body)
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


@pytest.mark.parametrize("delay", [0, 3])
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


@pytest.mark.parametrize(("blend", "turns"), [(0.05, False), (0.4, True)])
def test_the_turn_at_the_goal_begins_so_far_before_it(blend: float, turns: bool) -> None:
    robot, goal = Unicycle(SE2(1.0, 2.0)), SE2(4.0, 2.0, 1.2)
    values = {"arrival.curve_time": 0.0, "arrival.blend_distance": blend}
    drive(robot, goal, empty_grid(6.0, 4.0), **values)
    before = [abs(pose.theta) for pose in robot.trace if pose.x < 3.85]
    assert (max(before) > 0.03) is turns


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


def test_what_stands_out_of_the_footprint_is_kept_free() -> None:
    grid, goal = empty_grid(6.0, 4.0), SE2(4.0, 2.0)
    block(grid, 4.3, 1.5, 0.2, 1.0)
    fronts = []
    for body in (None, BODY):
        robot = Unicycle(SE2(1.0, 2.0))
        result = drive(robot, goal, grid, body)
        assert result.state is FollowState.SUCCEEDED
        fronts.append(max(pose.x for pose in robot.trace) + 0.35)
    assert fronts[0] > 4.3, "it is driven into the goal, as its footprint allows"
    assert 4.0 < fronts[1] < 4.3


def test_a_body_within_the_footprint_changes_nothing() -> None:
    traces = []
    for body in (None, BODY.scaled(0.3)):
        robot = Unicycle(SE2(1.0, 1.0, 1.0))
        drive(robot, SE2(3.0, 1.7, 0.6), empty_grid(5.0, 4.0), body)
        traces.append([pose.array().tolist() for pose in robot.trace])
    assert traces[0] == traces[1]


@pytest.mark.parametrize("speed", [0.2, 0.5, 1.0, 2.0])
def test_a_fast_robot_brakes_in_time(speed: float) -> None:
    robot = Unicycle(SE2(1.0, 2.0, 0.0))
    goal = SE2(6.0, 2.0, 0.0)
    grid = empty_grid(8.0, 4.0)
    assert drive(robot, goal, grid, **{"FollowPath.desired_linear_vel": speed})
    assert off(robot, goal)[0] < 0.02
    assert max(pose.x for pose in robot.trace) < 6.06


def test_a_heading_that_does_not_matter_is_not_turned_to() -> None:
    robot, goal = Unicycle(SE2(1.0, 2.0)), SE2(3.0, 2.0, 2.0)
    checker = {"general_goal_checker.plugin": POSITION}
    assert drive(robot, goal, empty_grid(5.0, 4.0), **checker).state is FollowState.SUCCEEDED
    assert off(robot, goal)[0] < 0.02
    assert abs(robot.pose.theta) < 0.1


GOAL = SE2(3.0, 2.0)


class Asked:
    """An approach to a goal that is asked at poses, by default of a free and straight path."""

    def __init__(self, goal: SE2 = GOAL, **values: Any) -> None:
        self.goal, self.free = goal, costmap_of(empty_grid(5.0, 4.0))
        self.approach = FinalApproach(ApproachConfig(**values), TrackerConfig(), ROBOT)

    def __call__(
        self,
        pose: SE2,
        now: float = 0.0,
        costmap: Costmap | None = None,
        velocity: Velocity = STILL,
        **values: Any,
    ) -> Velocity | None:
        own = {
            "remaining": pose.distance(self.goal),
            "speed": 0.5,
            "within": False,
            "heading": True,
        }
        given: dict[str, Any] = {**own, **values}
        costs = costmap or self.free
        return self.approach.compute(Arrival(pose, self.goal, velocity, costs, now, **given))


def before(distance: float, bearing: float = 0.0) -> SE2:
    """Return a pose so far from the goal, which it sees at a bearing."""
    return SE2(3.0 - distance * math.cos(bearing), 2.0 - distance * math.sin(bearing))


def blocked_behind(x: float) -> Costmap:
    return costmap_of(grid_of(5.0, 4.0, (x, 1.5, 0.2, 1.0)))


@pytest.mark.parametrize(
    ("pose", "values", "begins"),
    [
        (before(0.499), {}, True),
        (before(0.501), {}, False),
        (before(1.19), {"velocity": Velocity(1.0)}, True),  # a fifth more than it brakes in
        (before(1.21), {"velocity": Velocity(1.0)}, False),
        (before(0.4, 0.34), {}, True),
        (before(0.4, 0.36), {}, False),
        (before(0.4, -0.36), {}, False),
        (before(0.4), {"remaining": 0.469}, True),  # the path leads there straight
        (before(0.4), {"remaining": 0.471}, False),
        (before(0.9, 2.0), {"within": True}, True),
    ],
)
def test_takes_over_where_little_is_left(pose: SE2, values: dict[str, Any], begins: bool) -> None:
    assert (Asked(curve_time=0.0)(pose, **values) is not None) is begins
    assert Asked(enabled=False)(pose, **values) is None


@pytest.mark.parametrize(
    ("pose", "values", "curves"),
    [
        (before(1.9), {}, True),  # 4 s at 0.5 m/s
        (before(2.1), {}, False),
        (before(1.1), {"speed": 0.25}, False),
        (before(1.9), {"heading": False}, False),
        (before(1.5, 0.36), {}, False),
        (before(1.5), {"remaining": 1.64}, False),
        (before(1.5), {"remaining": 1.62}, True),
    ],
)
def test_a_curve_to_the_heading_is_sooner(pose: SE2, values: dict[str, Any], curves: bool) -> None:
    assert (Asked(curve_time=4.0)(pose, **values) is not None) is curves
    assert Asked(curve_time=0.0)(pose, **values) is None


@pytest.mark.parametrize(("room", "curves"), [(0.051, True), (0.049, False)])
def test_a_curve_needs_room_beside_it_all_along(room: float, curves: bool) -> None:
    costs = Asked().free
    clearances = np.full(256, math.inf)
    clearances[0] = room
    narrow = replace(costs, clearances=clearances)
    assert (Asked(SE2(3.0, 2.0, 0.5))(before(1.5), costmap=narrow) is not None) is curves


def test_a_curve_that_leaves_the_map_is_not_driven() -> None:
    for y, drives in ((2.0, True), (0.02, False)):
        asked = Asked(SE2(3.0, y, 0.8))  # it swings to the right
        assert (asked(SE2(1.0, y)) is not None) is drives


@pytest.mark.parametrize("bearing", [0.5, -2.0, 3.0])
def test_turns_to_a_goal_that_lies_aside_and_then_drives(bearing: float) -> None:
    asked = Asked(curve_time=0.0)
    turning = asked(before(0.15, bearing), within=True)
    assert turning is not None
    assert turning.x == 0.0
    assert math.copysign(1.0, turning.yaw_rate) == math.copysign(1.0, bearing)
    at = before(0.15, bearing)
    driving = asked(SE2(at.x, at.y, bearing), now=0.1, within=True)
    assert driving is not None
    assert driving.x > 0.0


def test_without_room_it_leaves_the_rest_to_the_controller() -> None:
    asked, pose, closed = Asked(), before(0.4), blocked_behind(3.15)
    assert asked(pose, costmap=closed) is None
    assert asked(pose) is not None, "what blocked it has gone"
    assert asked(pose, costmap=closed, within=True) is None
    assert asked(pose, within=True) is None, "what is tolerated was enough"
    asked.approach.reset()
    assert asked(pose, within=True) is not None


def test_where_only_the_turn_at_the_goal_has_no_room_it_drives_there() -> None:
    box = Footprint.polygon(np.array([[0.5, 0.1], [0.5, -0.1], [-0.2, -0.1], [-0.2, 0.1]]))
    grid = grid_of(5.0, 4.0, (3.25, 2.3, 0.1, 0.1))
    costmap = costmap_of(grid, footprint=str(box.points.tolist()))
    for heading, turns in ((-0.9, True), (0.9, False)):
        asked = Asked(SE2(3.0, 2.0, heading), curve_time=0.0)
        asked.approach = FinalApproach(ApproachConfig(curve_time=0.0), TrackerConfig(), box)
        command = asked(before(0.4), costmap=costmap)
        assert command is not None
        assert command.x > 0.0
        ended = asked(asked.goal @ SE2(0.0, 0.0, -heading), now=0.1, costmap=costmap)
        assert (ended is not None) is turns


def test_a_turn_that_the_costmap_did_not_hold_from_afar_is_made_at_the_goal() -> None:
    box = Footprint.polygon(np.array([[0.1, 0.1], [0.1, -0.1], [-0.4, -0.1], [-0.4, 0.1]]))
    asked = Asked(SE2(3.0, 2.0, -2.0))
    asked.approach = FinalApproach(ApproachConfig(curve_time=0.0), TrackerConfig(), box)
    outline, arrived = str(box.points.tolist()), SE2(3.0, 2.0)
    far = costmap_of(empty_grid(3.15, 4.0), inflation_radius=0.2, footprint=outline)
    assert asked(before(0.4), costmap=far) is not None
    turning = asked(arrived, now=0.1, within=True)
    assert turning is not None
    assert turning.yaw_rate < 0.0
    assert asked(SE2(3.0, 2.0, -2.0), now=2.0, within=True) is None
    asked.approach.begin()
    assert asked(before(0.4), costmap=far) is not None
    assert asked(arrived, now=0.1) is None, "it is not where the goal's tolerance is met"


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
        """Turns about a point ahead of its own centre."""

        def drive(self, command: Velocity) -> None:
            super().drive(command)
            self.pose = self.pose @ SE2(0.0, -0.015 * self.velocity.yaw_rate * self.period)

    robot, goal = Lopsided(SE2(1.0, 2.0)), SE2(3.0, 2.0, heading)
    drive(robot, goal, empty_grid(5.0, 4.0))
    ahead = robot.pose.inverse() @ goal
    assert abs(ahead.x) < 0.01
    assert off(robot, goal)[1] < 0.03


def test_pushed_away_in_its_last_turn_it_leaves_the_return_to_the_controller() -> None:
    asked = Asked(SE2(3.0, 2.0, 2.0))
    turning = asked(SE2(3.0, 2.0), within=True)
    assert turning is not None
    assert turning.yaw_rate > 0.0
    assert asked(SE2(1.0, 2.0, 1.5)) is None
    back = asked(SE2(2.8, 2.0), within=True)
    assert back is not None
    assert back.x > 0.0, "it drives into the goal again"


def test_pushed_away_after_it_was_over_it_approaches_again() -> None:
    asked, held = Asked(), SE2(2.9, 2.0)  # somebody blocks its path
    assert asked(held, 0.0, within=True) is not None
    assert asked(held, 3.0, within=True) is None
    assert asked(held, 3.1, within=True) is None, "what is tolerated was enough"
    assert not asked.approach.retry(), "only a steered robot drives another curve"
    assert asked(SE2(1.0, 2.0, 1.5), 4.0) is None
    assert asked(SE2(2.6, 2.0), 8.0) is not None


def test_its_patience_counts_from_when_the_path_is_free_again() -> None:
    asked, pose = Asked(), before(0.4)
    assert asked(pose, 0.0, heading=False) is not None
    assert asked(pose, 0.1, blocked_behind(3.15), heading=False) is None
    assert asked(pose, 5.0, heading=False) is not None


def test_who_gets_no_nearer_for_too_long_hands_over() -> None:
    asked = Asked(curve_time=0.0)
    for now in (0.0, 1.9, 2.0):
        assert asked(before(0.3), now) is not None
    for now in (2.1, 4.0):
        assert asked(before(0.298), now) is not None
    assert asked(before(0.2975), 4.2) is None, "by less than a millimetre does not count"
    assert asked(before(0.2), 4.3) is None


CAR = {
    "FollowPath": {
        "plugin": "nav2_regulated_pure_pursuit_controller::RegulatedPurePursuitController",
        "use_rotate_to_heading": False,
        "allow_reversing": True,
    },
    "min_turning_radius": 0.5,
}


@pytest.mark.parametrize("start", [0.0, 1.0, 2.5])
@pytest.mark.parametrize("heading", [0.0, 1.2, -2.0, 3.1])
def test_a_steered_robot_arrives_on_bends_that_it_can_drive(start: float, heading: float) -> None:
    robot = Unicycle(SE2(2.0, 2.5, start), delay=3, steered=True)
    goal = SE2(3.0, 2.7, heading)
    assert drive(robot, goal, empty_grid(5.0, 5.0), **CAR).state is FollowState.SUCCEEDED
    distance, angle = off(robot, goal)
    assert distance < 0.03
    assert angle < 0.25
    steps = [a.inverse() @ b for a, b in itertools.pairwise(robot.trace)]
    assert max(abs(step.theta) - abs(step.x) / 0.5 for step in steps) < 1e-4


@pytest.mark.parametrize("room", [True, False])
def test_a_steered_robots_curve_leads_round_obstacles(room: bool) -> None:
    grid = grid_of(5.0, 5.0, (2.6, 2.4, 0.1, 0.2))
    if not room:
        block(grid, 3.4, 0.0, 0.2, 5.0)
    costmap, start, goal = costmap_of(grid), SE2(1.6, 2.5), SE2(3.3, 2.5)
    approach = FinalApproach(ApproachConfig(), TrackerConfig(), ROBOT, 0.5)
    around: dict[str, Any] = {"remaining": 1.7, "speed": 0.5, "within": False, "heading": True}
    for at, later in ((goal, {"remaining": 9.0}), (SE2(4.9, 2.5), {})):  # far, or off the map
        assert approach.compute(Arrival(start, at, STILL, costmap, 0.0, **around | later)) is None
    command = approach.compute(Arrival(start, goal, STILL, costmap, 0.0, **around))
    assert (command is not None) is room
    assert approach.steers(9.0, 0.5) is room
    assert approach.steers(1.7, 0.5)


def test_a_steered_robot_that_has_not_arrived_drives_as_many_curves_as_it_may() -> None:
    config = ApproachConfig(attempts=2)
    approach = FinalApproach(config, TrackerConfig(), ROBOT, 0.5)
    around: dict[str, Any] = {"remaining": 1.0, "speed": 0.5, "within": True, "heading": True}
    goal, costmap = SE2(3.0, 2.0), costmap_of(empty_grid(5.0, 4.0))
    for again in (True, False):
        assert (
            approach.compute(Arrival(SE2(2.0, 2.0), goal, STILL, costmap, 0.0, **around))
            is not None
        )
        beside = SE2(3.0, 2.2)  # as though it had slid there
        assert approach.compute(Arrival(beside, goal, STILL, costmap, 1.0, **around)) is None
        assert approach.retry() is again


RPP = "nav2_regulated_pure_pursuit_controller::RegulatedPurePursuitController"
SLOW_TURNS: dict[str, dict[str, Any]] = {
    RPP: {"rotate_to_heading_angular_vel": 0.3, "max_angular_accel": 0.5},
    "nav2_graceful_controller::GracefulController": {
        "v_angular_max": 0.3,
        "max_angular_accel": 0.5,
    },
    "dwb_core::DWBLocalPlanner": {
        "max_vel_x": 0.3,
        "max_vel_theta": 0.3,
        "acc_lim_theta": 0.5,
        "decel_lim_theta": -0.5,
        "critics": ["RotateToGoal", "PathDist", "GoalDist"],
    },
    "nav2_mppi_controller::MPPIController": {"wz_max": 0.3, "az_max": 0.5},
    "nav2_rotation_shim_controller::RotationShimController": {
        "primary_controller": RPP,
        "rotate_to_heading_angular_vel": 0.3,
        "max_angular_accel": 0.5,
    },
}


def driven_by(controller: str, goal: SE2, **own: Any) -> np.ndarray:
    """Return the speeds and yaw rates that lead straight into a goal."""
    robot, costmap = Unicycle(SE2(1.0, 2.0)), costmap_of(empty_grid(5.0, 4.0))
    below = {f"FollowPath.{key}": value for key, value in {"plugin": controller, **own}.items()}
    follower = PathFollower(load(FollowerConfig, {**below, "arrival.curve_time": 0.0}), ROBOT)
    follower.start(polyline([(1.0, 2.0), (goal.x, goal.y)], goal.theta), 0.0)
    commands, result = [STILL], FollowResult(FollowState.RUNNING)
    while result.state is FollowState.RUNNING and len(commands) < 600:
        result = follower.tick(robot.pose, robot.velocity, costmap, 0.05 * len(commands))
        robot.drive(result.velocity)
        commands.append(result.velocity)
    assert result.state is FollowState.SUCCEEDED
    assert off(robot, goal) < (0.03, 0.05)
    return np.array([(one.x, one.yaw_rate) for one in commands])


@pytest.mark.parametrize("controller", SLOW_TURNS)
def test_it_turns_no_faster_than_its_controller_may(controller: str) -> None:
    x, rate = driven_by(controller, SE2(2.0, 2.0, 2.0), **SLOW_TURNS[controller]).T
    assert 0.25 < rate.max() <= 0.3 + 1e-9
    assert np.diff(rate)[x[1:] == 0.0].max() <= 0.5 * 0.05 + 1e-9


def test_it_speeds_up_and_brakes_no_harder_than_its_controller_may() -> None:
    own = {"ax_max": 0.2, "ax_min": -0.3}
    speeds = driven_by("nav2_mppi_controller::MPPIController", SE2(1.5, 2.0), **own)[:, 0]
    assert speeds.max() > 0.15
    steps = np.diff(speeds) / 0.05
    assert steps.max() <= 0.2 + 1e-9
    assert steps[:-2].min() >= -2.0 * 0.3
