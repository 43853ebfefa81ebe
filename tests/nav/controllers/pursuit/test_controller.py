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
    end = SE2.from_array(back[-1])
    there = [pose.distance(end) < XY_TOLERANCE for pose in robot.trace].index(True)
    speeds = np.array([command.velocity.x for command in commands[:there]])
    assert speeds.max() > 0.4
    assert speeds.min() < -0.2
    signs = np.sign(speeds[np.abs(speeds) > 0.01])
    assert np.count_nonzero(np.diff(signs)) == 1, "it changed its direction once"
    assert max(pose.x for pose in robot.trace) > 2.9
    assert robot.pose.distance(end) < XY_TOLERANCE
    at_goal = [command.velocity for command in commands[there:]]
    spins = any(one.x == 0.0 and one.yaw_rate != 0.0 for one in at_goal)
    assert spins == turns  # without leave it never turns on the spot, at the goal either
    assert not turns or abs(wrap(robot.pose.theta - back[-1, 2])) < 0.3


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
