"""Calibration finds what the shipped robot carries, from any start, and what it finds is good."""

from __future__ import annotations

import math

import numpy as np
import pytest

from arjuna_sim.calibrate import calibrate_robot
from arjuna_sim.devices.calibration import (
    Calibration,
    CalibrationError,
    compare,
    dead_reckon,
    identify,
)
from arjuna_sim.devices.drive import Kinematics
from arjuna_sim.files.robots.robot_file import load_robot
from tests.sim.builders import EMPTY, ROBOT, ROOM, edited


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> Calibration:
    """The calibration of the shipped robot, which was robbed of its own."""
    folder = tmp_path_factory.mktemp("robot")
    robot = edited(ROBOT, folder, "effectiveTrackWidth>0.6029<", "effectiveTrackWidth>0.34<")
    return calibrate_robot(robot, EMPTY)


def test_shipped_numbers_are_what_calibration_finds(found: Calibration) -> None:
    drive = load_robot(ROBOT).drive
    assert found.found.track == pytest.approx(drive.effective_track, rel=0.01)
    assert found.found.radius == pytest.approx(drive.effective_radius, rel=0.002)
    assert found.nominal == Kinematics(0.34, 0.05)


def test_odometry_is_within_two_and_four_per_cent_after_it(found: Calibration) -> None:
    kinds = {row.manoeuvre.kind for row in found.after}
    assert kinds == {"straight", "spin", "arc"}
    assert max(abs(row.path_error) for row in found.after) < 0.02
    assert max(abs(row.turn_error) for row in found.after) < 0.04
    assert min(row.turn_error for row in found.before if row.manoeuvre.kind == "spin") > 0.5


def test_dead_reckoning_of_the_pattern_ends_near_the_truth_only_after_it(
    found: Calibration,
) -> None:
    end = found.check.truth[-1, :2]
    after = found.path_after[-1, :2]
    before = found.path_before[-1, :2]
    assert math.dist(end, after) < 0.5  # of 20 m
    assert math.dist(end, before) > 1.0


def test_identification_is_exact_where_odometry_is(found: Calibration) -> None:
    """Truth replaced by what some ideal robot would have done."""
    ideal = Kinematics(0.5, 0.07)
    poses = dead_reckon(found.check, ideal)
    poses[:, 2] = np.unwrap(poses[:, 2])
    log = type(found.check)(found.check.wheels, poses, found.check.spans, found.check.tick)
    again = identify(log)
    assert again.track == pytest.approx(0.5, rel=1e-3)
    assert again.radius == pytest.approx(0.07, rel=1e-3)
    assert max(abs(row.turn_error) for row in compare(log, ideal)) < 1e-2


def test_noise_covers_the_errors_that_remain(found: Calibration) -> None:
    noise = found.noise
    assert 0.001 <= noise.drift_noise <= noise.angular_noise < 0.05
    assert 0.001 <= noise.linear_noise < 0.02


def test_a_world_without_room_is_refused() -> None:
    with pytest.raises(CalibrationError, match="bumped into obstacle_red; valid: a world with 4 m"):
        calibrate_robot(ROBOT, ROOM)
