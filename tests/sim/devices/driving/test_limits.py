"""Limits are those of the robot's file and of parameters, and none else."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from arjuna_sim.devices.drive import DriveConfig
from arjuna_sim.devices.driving.controller import HoldLimits, limited
from arjuna_sim.model.settings import DriveSettings

_WHEELS = DriveSettings(("l",), ("r",), 0.5, 0.05, 1.0, 0.5, 0.05, plugin="p")


def test_nothing_is_bounded_but_by_what_physics_can_step() -> None:
    free = limited(DriveConfig(), _WHEELS)
    assert {b.value for b in (free.forward, free.reverse, free.turn)} == {50.0}
    assert "physics" in free.turn.source
    assert free.linear_acceleration == free.angular_acceleration == math.inf
    assert free.hold == HoldLimits(0.5, 3.0)


def test_the_robots_file_bounds_what_it_names() -> None:
    told = replace(
        _WHEELS, max_velocity=0.4, max_turn=1.5, max_acceleration=0.2, max_turn_acceleration=0.7
    )
    limits = limited(DriveConfig(), told)
    assert (limits.forward.value, limits.reverse.value, limits.turn.value) == (0.4, 0.4, 1.5)
    assert "plugin 'p'" in limits.forward.source
    assert (limits.linear_acceleration, limits.angular_acceleration) == (0.2, 0.7)
    assert limited(DriveConfig(), replace(told, max_reverse=0.1)).reverse.value == 0.1


@pytest.mark.parametrize(("parameter", "bound"), [(0.3, 0.3), (9.0, 9.0), (0.0, 0.0), (1e3, 50.0)])
def test_parameters_take_the_place_of_what_the_file_says(parameter: float, bound: float) -> None:
    config = DriveConfig(max_linear_velocity=parameter, max_angular_velocity=2.0)
    limits = limited(config, replace(_WHEELS, max_velocity=0.4))
    assert (limits.forward.value, limits.turn.value) == (bound, 2.0)
    assert "drive.max_angular_velocity" in limits.turn.source


def test_a_robot_turns_up_as_its_wheels_grip_at_half_its_track() -> None:
    slippery = limited(DriveConfig(), _WHEELS, steady=0.1)
    assert slippery.linear_acceleration == 0.1
    assert slippery.angular_acceleration == pytest.approx(0.1 / 0.25)
    balanced = limited(DriveConfig(), replace(_WHEELS, separation=0.0), steady=0.1)
    assert balanced.angular_acceleration == math.inf
    config = DriveConfig(max_linear_acceleration=0.05, max_angular_acceleration=0.1)
    lower = limited(config, _WHEELS, steady=0.1)
    assert (lower.linear_acceleration, lower.angular_acceleration) == (0.05, 0.1)


def test_time_out_is_the_parameters_else_that_of_the_robots_controllers() -> None:
    own = replace(_WHEELS, command_timeout=0.25)
    assert limited(DriveConfig(), own).hold == HoldLimits(0.25, is_fixed=True)
    config = DriveConfig(command_timeout=0.0, command_timeout_max=9.0)
    assert limited(config, own).hold == HoldLimits(0.0, 9.0)
