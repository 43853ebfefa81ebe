"""The drive's controller: limits, ramps, and how long a command holds."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from arjuna_core.twist import Velocity
from arjuna_sim.devices.drive import DriveConfig
from arjuna_sim.devices.driving.controller import Drive, HoldLimits, Ramp, limited
from arjuna_sim.model.settings import DriveKind, DriveSettings

_WHEELS = DriveSettings(("l",), ("r",), 0.0, 0.05, 1.0, 0.5, 0.05, plugin="p")


def _drive(settings: DriveSettings = _WHEELS, **config: float) -> Drive:
    return Drive(limited(DriveConfig(**config), settings))


def test_ramp_stays_within_the_accelerations_and_ends_at_the_command() -> None:
    drive = _drive(max_linear_acceleration=1.0)
    drive.command(Velocity(0.05), now=0.0)
    speeds = [drive.velocity(0.02 * i, 0.02).x for i in range(4)]
    assert speeds == pytest.approx([0.02, 0.04, 0.05, 0.05])


def test_without_limits_a_command_is_taken_at_once() -> None:
    drive = _drive()
    drive.command(Velocity(3.0, y=2.0, yaw_rate=-7.0), now=0.0)
    assert drive.velocity(0.0, 0.02) == Velocity(3.0, y=2.0, yaw_rate=-7.0)
    assert drive.take_cuts() == ()


def test_a_command_is_cut_to_the_limits_and_holds_until_its_time_is_out() -> None:
    drive = _drive(max_linear_velocity=1.0, max_angular_velocity=2.0, command_timeout=2.0)
    for asked, held in (
        (Velocity(1.0, y=1.0, yaw_rate=2.0), Velocity(1.0, y=1.0, yaw_rate=2.0)),
        (Velocity(5.0, y=0.25, yaw_rate=0.5), Velocity(1.0, y=0.25, yaw_rate=0.5)),
        (Velocity(0.5, y=0.25, yaw_rate=-9.0), Velocity(0.5, y=0.25, yaw_rate=-2.0)),
        (Velocity(-0.5, y=7.0, yaw_rate=9.0), Velocity(-0.5, y=1.0, yaw_rate=2.0)),
        (Velocity(-7.0, y=-7.0), Velocity(-1.0, y=-1.0)),
    ):
        drive.command(asked, now=3.0)
        assert drive.velocity(4.98, 0.1) == held
    assert drive.velocity(5.0, 0.1) == Velocity()  # the time is out
    drive.command(Velocity(0.5), now=6.0)
    drive.velocity(6.0, 0.1)
    drive.reset()
    assert drive.velocity(6.0, 0.1) == Velocity()


def test_what_is_cut_is_said_once_with_the_limit_and_its_source() -> None:
    given = DriveSettings(
        *(("l",), ("r",), 0.0, 0.05, 1.0, 0.5, 0.05), plugin="p", max_velocity=0.4, max_reverse=0.2
    )
    drive = _drive(given, max_angular_velocity=2.0)
    drive.command(Velocity(1.5, yaw_rate=3.0), now=0.0)
    first, second = drive.take_cuts()
    assert first == ("a command of 1.5 m/s is cut to 0.4 m/s, by plugin 'p' of the robot's file")
    assert second == (
        "a command of 3 rad/s is cut to 2 rad/s, by the parameter drive.max_angular_velocity"
    )
    drive.command(Velocity(9.0, yaw_rate=-9.0), now=1.0)
    assert drive.take_cuts() == ()
    drive.command(Velocity(-0.3), now=1.0)
    assert drive.velocity(1.0, 9.0).x == -0.2


@pytest.mark.parametrize(
    ("asked", "braking"),
    [
        (Velocity(0.5), 0.2),
        (Velocity(y=-0.25), 0.1),
        (Velocity(0.25, yaw_rate=0.48), 0.15),
        (Velocity(1.0), 0.2),  # not sooner, though it is not long enough
    ],
)
def test_who_hears_no_more_brakes_so_as_to_stand_when_the_time_is_out(
    asked: Velocity, braking: float
) -> None:
    drive = _drive(max_linear_acceleration=2.5, max_angular_acceleration=3.2)
    given = []
    for k in range(101):
        if k <= 50:
            drive.command(asked, now=0.01 * k)
        given.append(drive.velocity(0.01 * k, 0.01))
    brakes = next(k for k, each in enumerate(given) if k > 50 and each != given[k - 1])
    assert brakes == round(100 - 100 * braking)
    assert (given[-1] == Velocity()) == (asked.x < 1.0)


def test_time_out_of_zero_holds_for_ever() -> None:
    drive = _drive(command_timeout=0.0)
    drive.command(Velocity(0.2), now=0.0)
    assert drive.velocity(1e6, 0.02) == Velocity(0.2)


def test_each_speed_ramps_by_its_own_limit_in_both_directions() -> None:
    drive = _drive(max_linear_acceleration=1.0, max_angular_acceleration=3.0)
    drive.command(Velocity(0.15, y=-0.15, yaw_rate=-0.5), now=0.0)
    given = [drive.velocity(0.1 * i, 0.1) for i in range(2)]
    flat = [speed for each in given for speed in (each.x, each.yaw_rate, each.y)]
    assert flat == pytest.approx([0.1, -0.3, -0.1, 0.15, -0.5, -0.15])
    stopping = drive.velocity(9.0, 0.1)
    assert (stopping.x, stopping.yaw_rate, stopping.y) == pytest.approx((0.05, -0.2, -0.05))
    assert math.isfinite(stopping.x)


_WHEELS_1 = DriveSettings(("l",), ("r",), 0.5, 0.05, 1.0, 0.5, 0.05, plugin="p")


def test_nothing_is_bounded_but_by_what_physics_can_step() -> None:
    free = limited(DriveConfig(), _WHEELS_1)
    assert {b.value for b in (free.forward, free.reverse, free.turn)} == {50.0}
    assert "physics" in free.turn.source
    assert free.linear == free.angular == Ramp(math.inf, math.inf)
    assert free.hold == HoldLimits(0.5, 3.0)


def test_the_robots_file_bounds_what_it_names() -> None:
    given = replace(
        _WHEELS_1, max_velocity=0.4, max_turn=1.5, max_acceleration=0.2, max_turn_acceleration=0.7
    )
    limits = limited(DriveConfig(), given)
    assert (limits.forward.value, limits.reverse.value, limits.turn.value) == (0.4, 0.4, 1.5)
    assert "plugin 'p'" in limits.forward.source
    assert (limits.linear, limits.angular) == (Ramp(0.2, 0.2), Ramp(0.7, 0.7))
    assert limited(DriveConfig(), replace(given, max_reverse=0.1)).reverse.value == 0.1


@pytest.mark.parametrize(("parameter", "bound"), [(0.3, 0.3), (9.0, 9.0), (0.0, 0.0), (1e3, 50.0)])
def test_parameters_replace_what_the_file_says(parameter: float, bound: float) -> None:
    config = DriveConfig(max_linear_velocity=parameter, max_angular_velocity=2.0)
    limits = limited(config, replace(_WHEELS_1, max_velocity=0.4))
    assert (limits.forward.value, limits.turn.value) == (bound, 2.0)
    assert "drive.max_angular_velocity" in limits.turn.source


def test_a_robot_turns_up_as_its_wheels_grip_at_half_its_track() -> None:
    slippery = limited(DriveConfig(), _WHEELS_1, steady=0.1)
    assert slippery.linear == Ramp(0.1, 0.1)
    assert slippery.angular.up == pytest.approx(0.1 / 0.25)
    balanced = limited(DriveConfig(), replace(_WHEELS_1, separation=0.0), steady=0.1)
    assert balanced.angular.up == math.inf
    config = DriveConfig(max_linear_acceleration=0.05, max_angular_acceleration=0.1)
    lower = limited(config, _WHEELS_1, steady=0.1)
    assert (lower.linear.up, lower.angular.down) == (0.05, 0.1)


def test_time_out_is_the_parameters_else_that_of_the_robots_controllers() -> None:
    own = replace(_WHEELS_1, command_timeout=0.25)
    assert limited(DriveConfig(), own).hold == HoldLimits(0.25, is_fixed=True)
    config = DriveConfig(command_timeout=0.0, command_timeout_max=9.0)
    assert limited(config, own).hold == HoldLimits(0.0, 9.0)


def test_speeds_fall_as_files_say_and_their_changes_are_no_sharper() -> None:
    given = replace(_WHEELS, max_acceleration=1.0, max_deceleration=0.5, max_turn_jerk=8.0)
    drive = _drive(replace(given, max_turn_acceleration=2.0))
    seen = []
    for now, speed in ((0.0, 0.4), (1.0, -0.4), (2.2, -0.4), (3.0, 0.0)):
        drive.command(Velocity(speed, yaw_rate=2.0 * speed), now)
        ticks = round(((3.6 if speed == 0.0 else 1.0) - 0.0) / 0.02)
        seen += [drive.velocity(now, 0.02) for _ in range(ticks)]
    steps = np.diff([0.0, *(v.x for v in seen)]) / 0.02
    assert (steps.max(), steps.min()) == pytest.approx((1.0, -0.5))
    turns = np.array([0.0, *(v.yaw_rate for v in seen)])
    rates = np.diff(turns) / 0.02
    assert np.abs(rates).max() == pytest.approx(2.0, abs=0.2)
    assert np.abs(np.diff(rates)).max() <= 8.0 * 0.02 + 1e-9
    assert (turns.max(), turns.min(), turns[-1]) == pytest.approx((0.8, -0.8, 0.0), abs=1e-3)


@pytest.mark.parametrize(
    ("speed", "ramp", "time"),
    [
        (1.0, Ramp(2.0, 0.5), 2.0),
        (-1.0, Ramp(2.0, 0.5), 0.5),
        (1.0, Ramp(1.0, 1.0, 4.0), 1.25),
        (1.0, Ramp(9.0, 9.0, 4.0), 1.0),
        (0.0, Ramp(1.0, 1.0, 4.0), 0.0),
        (0.0, Ramp(math.inf, math.inf), 0.0),
    ],
)
def test_how_long_it_brakes(speed: float, ramp: Ramp, time: float) -> None:
    assert ramp.braking(speed) == pytest.approx(time)
    rate, left = 0.0, time
    while left > 1e-9:
        speed, rate = ramp.step(speed, 0.0, rate, 0.01)
        left -= 0.01
    assert speed == pytest.approx(0.0, abs=0.03)


def test_a_steered_base_ramps_its_speed_along_the_commands_arc() -> None:
    settings = replace(_WHEELS, separation=0.4, kind=DriveKind.STEERED)
    drive = Drive(limited(DriveConfig(max_linear_acceleration=2.0), settings), steers=True)
    drive.command(Velocity(0.3, yaw_rate=0.6), now=0.0)
    ahead = [drive.velocity(0.1 * i, 0.1) for i in range(4)]
    drive.command(Velocity(-0.3, yaw_rate=0.3), now=0.4)
    back = [drive.velocity(0.4 + 0.1 * i, 0.1) for i in range(3)]
    assert [v.yaw_rate / v.x for v in ahead] == pytest.approx([2.0] * 4)
    assert all(v.yaw_rate == pytest.approx(-v.x, abs=1e-12) for v in back)
    assert back[-1].x == pytest.approx(-0.3)
