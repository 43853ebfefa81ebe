"""Calibration: exact where wheels are ideal; what it finds is what is shipped."""

from __future__ import annotations

import math

import numpy as np
import pytest

from arjuna_core.se2 import SE2
from arjuna_core.twist import Velocity
from arjuna_sim.calibrate import calibrate_robot
from arjuna_sim.devices.calibration import (
    PATTERN,
    Calibration,
    CalibrationError,
    DriveLog,
    Measurement,
    calibrate,
    compare,
    dead_reckon,
    drive,
    identify,
)
from arjuna_sim.devices.drive import Kinematics
from arjuna_sim.devices.odometry import OdometryConfig
from arjuna_sim.files.robots.robot_file import load_robot
from tests.sim.builders import EMPTY, ROBOT, ROOM, edited

TRUE, NOMINAL = Kinematics(0.5, 0.08), Kinematics(0.3, 0.1)
START = SE2(1.0, -2.0, 3.0)


class Formula:
    """A vehicle that moves as two ideal wheels do, less a share that grows with speed.

    Args:
        given: How it makes wheel speeds of velocities.
        true: How these move it.
        slip: Share that it loses of the path at 1 m/s, and of the turn at 1 rad/s.
        veer: Turn that it adds to a path [rad/m].
    """

    tick = 0.05

    def __init__(
        self, given: Kinematics, true: Kinematics = TRUE, slip: float = 0.0, veer: float = 0.0
    ) -> None:
        self._asked, self._true, self._slip, self._veer = given, true, slip, veer
        self._wheels, self._pose = np.array([5.0, -3.0]), START

    def drive(self, velocity: Velocity) -> None:
        speeds = self._asked.speeds(velocity)
        self._wheels += speeds * self.tick
        v, w = self._true.base_motion(*speeds.tolist())
        v, w = v * (1.0 - self._slip * abs(v)), w * (1.0 - self._slip * abs(w))
        turn = (w + self._veer * v) * self.tick
        self._pose = self._pose @ SE2.exp((v * self.tick, 0.0, turn))

    def observe(self) -> Measurement:
        left, right = self._wheels.tolist()
        return Measurement((left, right), self._pose)


def log(given: Kinematics = TRUE, true: Kinematics = TRUE) -> DriveLog:
    """Return the log of an ideal vehicle."""
    return drive(Formula(given, true))


def test_the_pattern_stays_within_four_metres_and_is_the_same_to_either_side() -> None:
    driven = log()
    assert np.hypot(*(driven.truth[:, :2] - (START.x, START.y)).T).max() < 4.0
    straight, spins, arcs = (
        [each for each in PATTERN if each.kind == kind] for kind in ("straight", "spin", "arc")
    )
    assert len(straight) + len(spins) + len(arcs) == len(PATTERN)
    speeds = [each.command.x for each in straight]
    assert min(speeds) == -0.3
    assert max(speeds) == 1.0
    assert all(abs(each.command.x) * each.seconds <= 2.0 for each in straight)
    assert {each.command.yaw_rate for each in spins} == {1.0, 2.0, 0.5, -1.0, -2.0, -0.5}
    assert sorted((a.command.x, a.command.yaw_rate) for a in arcs) == [
        *((0.4, -0.5), (0.4, 0.5), (0.5, 1.0), (0.6, -1.0)),
    ]
    angles = [abs(each.command.yaw_rate) * each.seconds for each in (*spins, *arcs)]
    assert set(angles) == {math.pi / 2, math.pi}


def test_each_manoeuvre_goes_from_rest_to_rest() -> None:
    driven = log()
    assert driven.tick == Formula.tick
    assert driven.wheels[0] == pytest.approx((5.0, -3.0))
    assert [manoeuvre for manoeuvre, _, _ in driven.spans] == list(PATTERN)
    last = 0
    for manoeuvre, start, end in driven.spans:
        assert start == last
        moving = round(manoeuvre.seconds / Formula.tick)
        assert end - start == moving + round(1.0 / Formula.tick)
        steps = np.abs(np.diff(driven.wheels[start : end + 1], axis=0)).max(axis=1)
        assert (steps[:moving] > 0.0).all()
        assert (steps[moving:] == 0.0).all()
        path = manoeuvre.command.x * moving * Formula.tick
        assert driven.path(manoeuvre, start, end) == pytest.approx(path, rel=1e-3)
        last = end
    assert last == len(driven.truth) - 1 == len(driven.wheels) - 1
    assert np.abs(np.diff(driven.truth[:, 2])).max() < 0.2  # the heading is not wrapped


@pytest.mark.parametrize(
    "true", [Kinematics(0.5, 0.0), Kinematics(0.5, -0.08), Kinematics(-0.5, 0.08)]
)
def test_wheels_that_move_the_robot_otherwise_are_refused(true: Kinematics) -> None:
    with pytest.raises(CalibrationError, match="the wheels turn, but the robot does not follow"):
        identify(log(NOMINAL, true))


def test_wheels_that_do_not_turn_are_refused() -> None:
    still = log()
    with pytest.raises(CalibrationError, match="does not follow them"):
        identify(DriveLog(still.wheels * 0.0, still.truth * 0.0, still.spans, still.tick))


def test_encoders_reckon_the_path_from_the_origin() -> None:
    driven = log()
    reckoned = dead_reckon(driven, TRUE)
    truth = [START.inverse() @ SE2(*pose) for pose in driven.truth.tolist()]
    assert len(reckoned) == len(truth)
    gaps = [
        pose.distance(SE2(*found)) for pose, found in zip(truth, reckoned.tolist(), strict=True)
    ]
    assert max(gaps) < 0.05  # encoders count whole ticks


def test_errors_are_relative_and_a_manoeuvre_has_those_of_its_kind() -> None:
    rows = compare(log(), Kinematics(TRUE.track * 1.1, TRUE.radius * 1.32))
    assert [row.manoeuvre for row in rows] == list(PATTERN)
    for row in rows:
        path = 0.0 if row.manoeuvre.kind == "spin" else 0.32
        turn = 0.0 if row.manoeuvre.kind == "straight" else 0.2
        assert row.path_error == pytest.approx(path, abs=1e-3)
        assert row.turn_error == pytest.approx(turn, abs=1e-9)


def test_noise_covers_what_errors_remain_of_a_second_drive() -> None:
    drives: list[Kinematics] = []

    def vehicle(given: Kinematics) -> Formula:
        drives.append(given)
        return Formula(given, slip=0.1, veer=0.05)

    config = OdometryConfig(ticks_per_revolution=77)
    result = calibrate(vehicle, NOMINAL, config)
    assert drives == [NOMINAL, result.found]
    assert result.nominal == NOMINAL
    assert result.noise.ticks_per_revolution == 77
    assert result.before == compare(result.check, NOMINAL)
    straight = [row for row in result.after if row.manoeuvre.kind == "straight"]
    direction = np.array([abs(row.true_path) for row in straight])
    off = np.array([row.path - row.true_path for row in straight])
    assert result.noise.linear_noise == pytest.approx(math.sqrt((off**2 / direction).mean()))
    assert 0.02 < result.noise.linear_noise < 0.1
    veered = np.array([row.turn - row.true_turn for row in straight])
    assert result.noise.drift_noise == pytest.approx(math.sqrt((veered**2 / direction).mean()))
    assert result.noise.drift_noise == pytest.approx(0.05 * math.sqrt(direction.mean()), rel=0.05)
    spins = [row for row in result.after if row.manoeuvre.kind == "spin"]
    share = np.array([(row.turn - row.true_turn) ** 2 / abs(row.true_turn) for row in spins])
    assert result.noise.angular_noise == pytest.approx(math.sqrt(share.mean()))
    assert result.noise.angular_noise > 0.02
    np.testing.assert_array_equal(result.path_before, dead_reckon(result.check, NOMINAL))
    np.testing.assert_array_equal(result.path_after, dead_reckon(result.check, result.found))


def test_an_exact_robot_keeps_the_least_noise() -> None:
    noise = calibrate(Formula, NOMINAL, OdometryConfig()).noise
    assert (noise.linear_noise, noise.angular_noise, noise.drift_noise) == (1e-3, 1e-3, 1e-3)


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


def test_a_world_without_room_is_refused() -> None:
    with pytest.raises(CalibrationError, match="bumped into obstacle_red; valid: a world with 4 m"):
        calibrate_robot(ROBOT, ROOM)
