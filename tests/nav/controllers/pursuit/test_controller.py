"""Regulated pure pursuit: how it settles, slows down and says why it stands."""

from __future__ import annotations

import math

import numpy as np
import pytest

from arjuna_core.se2 import SE2, wrap
from arjuna_core.twist import Velocity
from arjuna_nav.controllers import (
    Controller,
    ControlStatus,
    RegulatedPurePursuit,
    RegulatedPurePursuitConfig,
)
from arjuna_nav.costmap.footprint import Footprint
from tests.nav.worlds import Unicycle, block, costmap_of, empty_grid, follow, polyline

XY_TOLERANCE, YAW_TOLERANCE = 0.20, 0.15


def pure_pursuit() -> RegulatedPurePursuit:
    config = RegulatedPurePursuitConfig(
        desired_linear_vel=0.4, rotate_to_heading_angular_vel=0.8, max_angular_accel=1.5
    )
    return RegulatedPurePursuit(config, Footprint.circle(0.25), XY_TOLERANCE)


@pytest.fixture
def controller() -> Controller:
    return pure_pursuit()


@pytest.mark.parametrize("delay", [0, 1, 3, 5])
def test_settles_the_heading_without_oscillation(controller: Controller, delay: int) -> None:
    robot = Unicycle(SE2(2.9, 3.0, 0.0), delay=delay)
    controller.set_path(polyline([(1.0, 3.0), (3.0, 3.0)], math.pi / 2))
    follow(controller, robot, costmap_of(empty_grid(6.0, 6.0)), 200)
    errors = np.array([wrap(math.pi / 2 - pose.theta) for pose in robot.trace])
    assert abs(errors[-1]) < YAW_TOLERANCE
    assert errors.min() > -YAW_TOLERANCE, "it overshot beyond the tolerance"
    far = np.sign(errors[np.abs(errors) > 0.02])
    assert np.count_nonzero(np.diff(far)) <= 2


def test_a_new_path_to_the_same_goal_does_not_undo_arrival(controller: Controller) -> None:
    costmap = costmap_of(empty_grid(6.0, 6.0))
    path = polyline([(1.0, 3.0), (3.0, 3.0)], math.pi / 2)
    robot = Unicycle(SE2(2.85, 3.0, 0.0))
    controller.set_path(path)
    follow(controller, robot, costmap, 5)
    drifted = SE2(2.75, 3.0, robot.pose.theta)  # localization moved it out of the tolerance
    controller.set_path(path)
    result = controller.compute(drifted, robot.velocity, costmap, 1.0)
    assert (result.status, result.velocity.x) == (ControlStatus.SUCCEEDED, 0.0)


@pytest.mark.parametrize("beside", [3.0, 0.34])
@pytest.mark.parametrize("bearing", [1.3, 2.6])
def test_a_turn_gets_on_as_soon_as_that_leads_nearer_and_has_room(
    bearing: float, beside: float
) -> None:
    grid = empty_grid(8.0, 8.0)
    for y in (4.0 - beside - 0.05, 4.0 + beside):
        block(grid, 0.0, y, 8.0, 0.05)
    controller, robot = pure_pursuit(), Unicycle(SE2(4.0, 4.0, -bearing))
    controller.set_path(polyline([(4.0, 4.0), (6.0, 4.0)], 0.0))
    commands = follow(controller, robot, costmap_of(grid), 10)
    while abs(robot.pose.theta) > 0.8:
        commands += follow(controller, robot, costmap_of(grid), 1)
    fast = max(result.velocity.x for result in commands)
    assert all(result.velocity.yaw_rate > 0.0 for result in commands)
    assert (bearing < 1.5) == (commands[0].velocity.x > 0.0)
    assert fast > 0.15 if beside > 1.0 else fast < 0.05


@pytest.mark.parametrize("turns", [True, False])
def test_turns_on_the_spot_where_no_arc_is_free(turns: bool) -> None:
    config = RegulatedPurePursuitConfig(
        rotate_to_heading_min_angle=1.2, use_rotate_to_heading=turns
    )
    controller = RegulatedPurePursuit(config, Footprint.circle(0.25), XY_TOLERANCE)
    grid = empty_grid(6.0, 6.0)
    controller.set_path(polyline([(3.0, 3.0), (4.0, 4.5)], 1.0))
    robot = Unicycle(SE2(3.0, 3.0, 0.0))
    free = controller.compute(robot.pose, robot.velocity, costmap_of(grid), 0.0)
    assert free.velocity.x > 0.0
    block(grid, 3.3, 2.0, 0.3, 1.6)
    result = controller.compute(robot.pose, robot.velocity, costmap_of(grid), 0.0)
    if turns:
        assert result.status is ControlStatus.SUCCEEDED
        assert (result.velocity.x, result.velocity.yaw_rate > 0.0) == (0.0, True)
    else:
        assert result.status is ControlStatus.NO_VALID_CONTROL


def test_refuses_to_drive_into_an_obstacle(controller: Controller) -> None:
    grid = empty_grid(6.0, 6.0)
    block(grid, 3.0, 0.0, 0.2, 6.0)
    costmap, robot = costmap_of(grid), Unicycle(SE2(1.0, 3.0, 0.0))
    controller.set_path(polyline([(1.0, 3.0), (5.0, 3.0)], 0.0))
    results = follow(controller, robot, costmap, 300)
    assert results[-1].status is ControlStatus.NO_VALID_CONTROL
    assert "collision ahead at" in results[-1].message
    assert max(pose.x for pose in robot.trace) + 0.25 < 3.0


def test_slows_down_near_obstacles_and_at_the_goal(controller: Controller) -> None:
    grid = empty_grid(6.0, 6.0)
    block(grid, 0.0, 3.4, 6.0, 0.2)
    path = polyline([(1.0, 3.0), (5.0, 3.0)], 0.0)
    controller.set_path(path)
    start = SE2(1.0, 3.0, 0.0)
    beside_wall = controller.compute(start, Unicycle(start).velocity, costmap_of(grid), 0.0)
    in_the_open = controller.compute(
        start, Unicycle(start).velocity, costmap_of(empty_grid(6.0, 6.0)), 0.0
    )
    close = SE2(4.7, 3.0, 0.0)
    controller.set_path(path[-10:])
    at_goal = controller.compute(
        close, Unicycle(close).velocity, costmap_of(empty_grid(6.0, 6.0)), 0.0
    )
    assert beside_wall.velocity.x < in_the_open.velocity.x == pytest.approx(0.4)
    assert 0.05 <= at_goal.velocity.x < 0.25


def test_takes_a_nearer_point_where_the_far_ones_arc_cuts_a_corner() -> None:
    grid = empty_grid(6.0, 6.0)
    block(grid, 0.0, 3.3, 2.7, 2.7)  # inside of the bend
    path = polyline([(1.0, 3.0), (3.0, 3.0), (3.0, 5.0)], math.pi / 2)
    costmap, start = costmap_of(grid), SE2(2.5, 3.0, 0.0)
    config = RegulatedPurePursuitConfig(
        lookahead_dist=0.9,
        rotate_to_heading_min_angle=1.5,
        max_allowed_time_to_collision_up_to_carrot=2.0,
    )
    controller = RegulatedPurePursuit(config, Footprint.circle(0.25), XY_TOLERANCE)
    controller.set_path(path)
    result = controller.compute(start, Unicycle(start).velocity, costmap, 0.0)
    assert result.status is ControlStatus.SUCCEEDED
    assert controller.carrot is not None
    assert math.hypot(controller.carrot.x, controller.carrot.y) < 0.85


def test_a_speed_limit_and_a_wall_do_not_slow_it_down_twice() -> None:
    grid = empty_grid(6.0, 6.0)
    block(grid, 0.0, 3.4, 6.0, 0.2)
    controller, start = pure_pursuit(), SE2(1.0, 3.0, 0.0)
    controller.set_path(polyline([(1.0, 3.0), (5.0, 3.0)], 0.0))
    speeds = []
    for limit in (math.inf, 0.3):
        controller.speed_limit = limit
        result = controller.compute(start, Unicycle(start).velocity, costmap_of(grid), 0.0)
        speeds.append(result.velocity.x)
    assert speeds[1] == pytest.approx(min(speeds[0], 0.3))


@pytest.mark.parametrize(("fixed", "speed"), [(False, 0.5), (True, 0.447)])
def test_a_bend_beyond_the_lookahead_may_slow_it_down(fixed: bool, speed: float) -> None:
    """By hand: 1.2 m off lies (0.8, 0.894), on an arc of 0.805 m, of 0.9 m that are free."""
    config = RegulatedPurePursuitConfig(
        lookahead_dist=0.4,
        use_fixed_curvature_lookahead=fixed,
        curvature_lookahead_dist=1.2,
        rotate_to_heading_min_angle=1.5,
    )
    controller = RegulatedPurePursuit(config, Footprint.circle(0.25))
    controller.set_path(polyline([(1.0, 1.0), (1.8, 1.0), (1.8, 4.0)], math.pi / 2))
    costmap = costmap_of(empty_grid(6.0, 6.0))
    result = controller.compute(SE2(1.0, 1.0), Velocity(0.5), costmap, 0.0)
    assert result.velocity.x == pytest.approx(speed, abs=0.003)
    bend = speed / 0.805 if fixed else 0.0
    assert result.velocity.yaw_rate == pytest.approx(bend, abs=0.005), "it steers by that point too"


def test_turns_begin_by_the_fixed_point() -> None:
    config = RegulatedPurePursuitConfig(
        lookahead_dist=0.4, use_fixed_curvature_lookahead=True, curvature_lookahead_dist=1.2
    )
    controller = RegulatedPurePursuit(config, Footprint.circle(0.25))
    controller.set_path(polyline([(1.0, 1.0), (1.8, 1.0), (1.8, 4.0)], math.pi / 2))
    result = controller.compute(SE2(1.0, 1.0), Velocity(), costmap_of(empty_grid(6.0, 6.0)), 0.0)
    assert result.velocity.yaw_rate > 0.0


@pytest.mark.parametrize("stateful", [True, False])
def test_it_may_drive_on_where_it_was_carried_off_the_goal(stateful: bool) -> None:
    controller = RegulatedPurePursuit(
        RegulatedPurePursuitConfig(stateful=stateful), Footprint.circle(0.25)
    )
    controller.set_path(polyline([(1.0, 1.0), (3.0, 1.0)], 1.5))
    costmap = costmap_of(empty_grid(6.0, 6.0))
    for x in (2.8, 2.74):  # within 0.25 m of it, and just without
        result = controller.compute(SE2(x, 1.0), Velocity(), costmap, 0.0)
    assert (result.velocity.x == 0.0) is stateful


@pytest.mark.parametrize("turns", [True, False])
def test_a_path_that_inverts_is_driven_forward_and_in_reverse(turns: bool) -> None:
    config = RegulatedPurePursuitConfig(allow_reversing=True, use_rotate_to_heading=turns)
    controller = RegulatedPurePursuit(config, Footprint.circle(0.25), XY_TOLERANCE)
    angles = np.linspace(0.0, 1.0, 21)
    forward = polyline([(1.0, 3.0), (3.0, 3.0)], 0.0)
    back = np.column_stack((3.0 - 1.5 * np.sin(angles), 1.5 + 1.5 * np.cos(angles), angles))
    controller.set_path(np.vstack((forward, back[1:])))
    robot = Unicycle(SE2(1.0, 3.0, 0.0))
    commands = follow(controller, robot, costmap_of(empty_grid(6.0, 6.0)), 300)
    speeds = np.array([command.velocity.x for command in commands])
    assert speeds.max() > 0.4
    assert speeds.min() < -0.2
    signs = np.sign(speeds[np.abs(speeds) > 0.01])
    assert np.count_nonzero(np.diff(signs)) == 1, "it changed its direction once"
    assert max(pose.x for pose in robot.trace) > 2.9
    assert robot.pose.distance(SE2.from_array(back[-1])) < XY_TOLERANCE
    assert abs(wrap(robot.pose.theta - back[-1, 2])) < 0.3


@pytest.mark.parametrize("extends", [True, False])
def test_the_bend_beyond_the_end_of_a_path_is_that_of_its_last_step(extends: bool) -> None:
    config = RegulatedPurePursuitConfig(
        use_fixed_curvature_lookahead=True,
        curvature_lookahead_dist=1.0,
        interpolate_curvature_after_goal=extends,
        use_rotate_to_heading=False,
        approach_velocity_scaling_dist=0.0,
    )
    controller = RegulatedPurePursuit(config, Footprint.circle(0.25), 0.01)
    controller.set_path(polyline([(3.0, 3.0), (3.3, 3.0)], 0.0))
    result = controller.compute(SE2(3.0, 2.9), Velocity(0.3), costmap_of(empty_grid(6.0, 6.0)), 0.0)
    bend = 2.0 * 0.1 / (1.0 if extends else 0.1**2 + 0.3**2)
    assert result.velocity.x == pytest.approx(0.5 * min(1.0, 1.0 / bend / 0.9), abs=1e-6)
