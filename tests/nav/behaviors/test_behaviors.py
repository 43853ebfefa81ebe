"""Recovery behaviours, driven through a simulated robot, and assisted teleoperation."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from arjuna_core.se2 import SE2, wrap
from arjuna_core.twist import STILL, Velocity
from arjuna_nav.behaviors.base import (
    Behavior,
    BehaviorConfig,
    BehaviorResult,
    BehaviorStatus,
    InvalidGoalError,
)
from arjuna_nav.behaviors.motions import AssistedTeleop, DriveConfig, DriveOnHeading, Spin, Wait
from arjuna_nav.costmap import Costmap
from arjuna_nav.costmap.collision import first_collision
from arjuna_nav.costmap.footprint import Footprint
from tests.nav.worlds import Unicycle, costmap_of, empty_grid, grid_of

CONFIG = BehaviorConfig(max_rotational_vel=0.8, rotational_acc_lim=1.5)
CIRCLE = Footprint.circle(0.25)
LONG = "[[0.6, 0.15], [-0.2, 0.15], [-0.2, -0.15], [0.6, -0.15]]"


def run(
    behavior: Behavior, robot: Unicycle, costmap: Costmap, duration: float = 30.0
) -> BehaviorResult:
    """Run a behaviour at 10 Hz to its end."""
    robot.period = 0.1
    result = BehaviorResult(BehaviorStatus.RUNNING)
    for k in range(round(duration / robot.period)):
        result = behavior.tick(robot.pose, costmap, k * robot.period)
        if result.status is not BehaviorStatus.RUNNING:
            break
        robot.drive(result.velocity)
    return result


@pytest.mark.parametrize("slowest", [0.4, -1.0])
@pytest.mark.parametrize("angle", [1.57, -1.57, 2.0 * math.pi, 0.2])
def test_spins_by_the_angle_asked_for(angle: float, slowest: float) -> None:
    robot = Unicycle(SE2(2.0, 2.0, 0.4), delay=0)
    config = replace(CONFIG, min_rotational_vel=slowest)
    result = run(Spin(angle, config, CIRCLE, 20.0), robot, costmap_of(empty_grid(4.0, 4.0)))
    assert result.status is BehaviorStatus.SUCCEEDED
    assert result.progress == pytest.approx(angle, abs=0.12)
    assert abs(wrap(robot.pose.theta - 0.4 - angle)) < 0.12


@pytest.mark.parametrize("rate", [0.8, 0.4])
def test_a_spin_that_would_hit_something_is_refused(rate: float) -> None:
    costmap = costmap_of(grid_of(4.0, 4.0, (1.8, 2.4, 0.4, 0.1)), footprint=LONG)
    robot = Unicycle(SE2(2.0, 2.0, 0.0), delay=0)
    footprint = Footprint.parse(LONG, 0.0, 0.0)
    config = replace(CONFIG, max_rotational_vel=rate, min_rotational_vel=0.1)
    result = run(Spin(1.57, config, footprint, 20.0), robot, costmap)
    assert result.status is BehaviorStatus.COLLISION_AHEAD
    assert "collision ahead at" in result.message
    turns = np.linspace(0.0, 1.57, 158)
    hit = first_collision(costmap, footprint, np.column_stack((*np.full((2, 158), 2.0), turns)))
    assert hit is not None
    ahead = max(0.0, turns[hit] - rate * config.simulate_ahead_time)
    assert robot.pose.theta == pytest.approx(ahead, abs=0.1)


def test_beyond_the_costmaps_grid_says_where_it_lies() -> None:
    robot = Unicycle(SE2(3.9, 2.0, 0.0), delay=0)
    result = run(
        DriveOnHeading(1.0, 0.4, CONFIG, CIRCLE, 10.0), robot, costmap_of(empty_grid(4, 4))
    )
    assert "outside the costmap's grid, which spans x 0.00 to 4.00 m" in result.message


@pytest.mark.parametrize(("distance", "speed"), [(0.3, 0.15), (1.0, 0.4)])
def test_drives_and_backs_up_the_distance(distance: float, speed: float) -> None:
    costmap = costmap_of(empty_grid(6.0, 6.0))
    ahead, behind = Unicycle(SE2(3.0, 3.0, 0.5), delay=0), Unicycle(SE2(3.0, 3.0, 0.5), delay=0)
    forward = run(DriveOnHeading(distance, speed, CONFIG, CIRCLE, 10.0), ahead, costmap)
    backward = run(DriveOnHeading(-distance, -speed, CONFIG, CIRCLE, 10.0), behind, costmap)
    for robot, result, sign in ((ahead, forward, 1.0), (behind, backward, -1.0)):
        moved = SE2(3.0, 3.0, 0.5).inverse() @ robot.pose
        assert result.status is BehaviorStatus.SUCCEEDED
        assert moved.x == pytest.approx(sign * distance, abs=0.1 * speed + 0.01)
        assert result.progress == pytest.approx(distance, abs=0.1 * speed + 0.01)


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize(
    ("ramp", "expected"),
    [
        ({}, lambda k, left: 0.3),
        ({"acceleration_limit": 0.5}, lambda k, left: min(0.05 * k, 0.3)),
        ({"deceleration_limit": -0.2}, lambda k, left: min(math.sqrt(0.4 * left), 0.3)),
        (
            {"acceleration_limit": 0.5, "minimum_speed": 0.12},
            lambda k, left: min(0.12 + 0.05 * k, 0.3),
        ),
        ({"minimum_speed": 0.4}, lambda k, left: 0.4),
    ],
)
def test_a_drive_gains_and_loses_speed_within_its_limits(
    sign: float, ramp: dict[str, float], expected: Callable[[int, float], float]
) -> None:
    limits = DriveConfig(**ramp)
    drive = DriveOnHeading(0.6 * sign, 0.3 * sign, CONFIG, CIRCLE, 0.0, limits)
    costmap, x = costmap_of(empty_grid(6.0, 6.0)), 0.0
    for k in range(100):
        result = drive.tick(SE2(3.0 + sign * x, 3.0), costmap, 0.1 * k)
        if result.status is not BehaviorStatus.RUNNING:
            break
        assert result.velocity.x == pytest.approx(sign * expected(k, 0.6 - x))
        x += 0.1 * abs(result.velocity.x)
    assert result.status is BehaviorStatus.SUCCEEDED


def test_backing_up_stops_before_a_wall() -> None:
    grid = grid_of(4.0, 4.0, (1.0, 0.0, 0.1, 4.0))
    robot = Unicycle(SE2(1.8, 2.0, 0.0), delay=0)
    result = run(DriveOnHeading(-1.0, -0.15, CONFIG, CIRCLE, 20.0), robot, costmap_of(grid))
    assert result.status is BehaviorStatus.COLLISION_AHEAD
    assert robot.pose.x - 0.25 > 1.1


def test_backing_up_of_nothing_or_with_two_signs_is_refused() -> None:
    for distance, speed in ((0.3, -0.1), (-0.3, 0.1), (0.0, 0.1), (math.nan, 0.1)):
        with pytest.raises(InvalidGoalError, match="must have one sign"):
            DriveOnHeading(distance, speed, CONFIG, CIRCLE, 1.0)


def test_gives_up_when_its_time_is_over() -> None:
    stuck = Unicycle(SE2(2.0, 2.0, 0.0))
    stuck.drive = lambda command: None  # type: ignore[method-assign]
    result = run(Spin(1.57, CONFIG, CIRCLE, 3.0), stuck, costmap_of(empty_grid(4.0, 4.0)))
    assert result.status is BehaviorStatus.TIMEOUT
    assert "3 s exceeded" in result.message


def test_moves_nothing_without_a_costmap() -> None:
    for behavior in (
        Spin(1.0, CONFIG, CIRCLE, 1.0),
        DriveOnHeading(-0.3, -0.1, CONFIG, CIRCLE, 1.0),
    ):
        result = behavior.tick(SE2(), None, 0.0)
        assert (result.status, result.velocity) == (BehaviorStatus.UNKNOWN, STILL)


def test_the_time_allowed_counts_from_the_first_tick() -> None:
    spin, costmap = Spin(1.57, CONFIG, CIRCLE, 20.0), costmap_of(empty_grid(4.0, 4.0))
    ends = [spin.tick(SE2(2.0, 2.0), costmap, now).status for now in (100.0, 120.0, 120.1)]
    assert ends == [BehaviorStatus.RUNNING, BehaviorStatus.RUNNING, BehaviorStatus.TIMEOUT]


def test_waits_as_long_as_asked() -> None:
    wait = Wait(5.0)
    assert wait.tick(SE2(), None, 10.0).progress == 5.0
    assert wait.tick(SE2(), None, 14.9).status is BehaviorStatus.RUNNING
    assert wait.tick(SE2(), None, 15.0).status is BehaviorStatus.SUCCEEDED
    assert wait.tick(SE2(), None, 15.1).progress == 0.0


def test_a_steered_robot_does_not_spin() -> None:
    config = replace(CONFIG, min_turning_radius=0.6)
    with pytest.raises(InvalidGoalError, match=r"cannot turn on the spot: it bends by .* 0\.6 m"):
        Spin(1.57, config, CIRCLE, 10.0)


TELEOP = BehaviorConfig(projection_time=1.0, simulation_time_step=0.1)
AHEAD = Velocity(0.5)


def teleop(allowance: float = 0.0) -> AssistedTeleop:
    return AssistedTeleop(TELEOP, CIRCLE, allowance)


def wall(x: float) -> Costmap:
    """Return the costmap of a hall with a wall at x."""
    return costmap_of(grid_of(6.0, 4.0, (x, 0.0, 0.1, 4.0)))


@pytest.mark.parametrize("velocity", [AHEAD, Velocity(-0.5), Velocity(0.2, yaw_rate=-0.6)])
def test_where_all_is_free_it_drives_as_commanded(velocity: Velocity) -> None:
    behavior = teleop()
    behavior.take(velocity, 0.0)
    result = behavior.tick(SE2(2.0, 2.0), wall(5.0), 0.5)
    assert (result.status, result.velocity) == (BehaviorStatus.RUNNING, velocity)


@pytest.mark.parametrize(("gap", "part"), [(0.45, 0.9), (0.3, 0.6), (0.15, 0.3), (0.02, 0.0)])
def test_the_nearer_a_wall_the_slower_up_to_where_it_stands(gap: float, part: float) -> None:
    behavior = teleop()
    behavior.take(Velocity(0.5, yaw_rate=0.2), 0.0)
    result = behavior.tick(SE2(4.0 - 0.25 - gap, 2.0), wall(4.0), 0.0)
    assert result.velocity.x == pytest.approx(0.5 * part, abs=0.075)
    assert result.velocity.yaw_rate == pytest.approx(0.4 * result.velocity.x)


def test_a_command_that_ceased_holds_no_longer_than_the_time_looked_ahead() -> None:
    behavior, free = teleop(), wall(5.0)
    assert behavior.tick(SE2(2.0, 2.0), free, 0.0).velocity == STILL
    behavior.take(AHEAD, 1.0)
    assert behavior.tick(SE2(2.0, 2.0), free, 1.9).velocity == AHEAD
    assert behavior.tick(SE2(2.0, 2.0), free, 2.1).velocity == STILL


def test_it_ends_when_somebody_is_done_or_its_time_is_over() -> None:
    behavior, free = teleop(), wall(5.0)
    assert behavior.tick(SE2(2.0, 2.0), free, 0.0).status is BehaviorStatus.RUNNING
    behavior.finish()
    assert behavior.tick(SE2(2.0, 2.0), free, 0.1).status is BehaviorStatus.SUCCEEDED
    late = teleop(2.0)
    late.tick(SE2(2.0, 2.0), free, 5.0)
    assert late.tick(SE2(2.0, 2.0), free, 6.9).status is BehaviorStatus.RUNNING
    assert late.tick(SE2(2.0, 2.0), free, 7.1).status is not BehaviorStatus.RUNNING
