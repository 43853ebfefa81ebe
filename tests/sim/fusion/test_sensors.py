"""Fusion: sensors, the estimator, the earth."""

from __future__ import annotations

import math

import numpy as np
import pytest

from arjuna_core.arrays import Floats
from arjuna_core.geodesy import GeoPoint, TangentPlane
from arjuna_core.pose3 import Pose3
from arjuna_sim.fusion.earth import EarthFrame
from arjuna_sim.fusion.estimator import Control, Estimator
from arjuna_sim.fusion.filters import ExtendedFilter, Measurement, Noise
from arjuna_sim.fusion.kinematics import SIZE
from arjuna_sim.fusion.sensors import (
    Part,
    PoseInput,
    acceleration_measured,
    twist_measured,
    without_gravity,
)

LEFT = Pose3.from_rpy((0.0, 0.0, 0.0), (0.0, 0.0, math.pi / 2))
NOISE = np.diag(np.arange(1.0, 7.0))


def _part(*states: int, planar: bool = False) -> Part:
    return Part("one", np.isin(np.arange(SIZE), states), planar=planar)


def test_a_turned_sensor_turns_its_mask_and_covariance() -> None:
    got = twist_measured(
        _part(6, 11), 1.0, np.array((2.0, 9.0, 9.0, 0.0, 0.0, 0.5)), NOISE, LEFT, np.zeros(SIZE)
    )
    assert np.flatnonzero(got.mask).tolist() == [7, 11]
    assert got.values[7] == pytest.approx(2.0)
    assert got.covariance[7, 7] == pytest.approx(1.0)


def test_a_sensor_off_the_base_is_moved_by_its_turning() -> None:
    state = np.zeros(SIZE)
    state[11] = 2.0
    at = Pose3((0.5, 0.0, 0.0))
    got = twist_measured(_part(6, 7), 0.0, np.array((0.0, 1.0, 0.0, 0, 0, 0)), NOISE, at, state)
    assert got.values[6:9] == pytest.approx((0.0, 0.0, 0.0))


def test_the_plane_measures_what_it_holds() -> None:
    values = Pose3.from_rpy((1.0, 2.0, 3.0), (0.1, 0.2, 0.3))
    got = PoseInput(_part(0, 5, planar=True)).measured(0.0, values, NOISE)
    assert got is not None
    assert np.flatnonzero(got.mask).tolist() == [0, 2, 3, 4, 5, 8, 9, 10, 14]
    assert got.values[[2, 3, 4]].tolist() == [0.0, 0.0, 0.0]
    assert got.covariance[2, 2] == 1e-6


def test_a_pose_comes_into_the_world() -> None:
    T_world_frame = Pose3((10.0, 0.0, 0.0), LEFT.quaternion)
    got = PoseInput(_part(0, 1, 5)).measured(0.0, Pose3((1.0, 0.0, 0.0)), NOISE, T_world_frame)
    assert got is not None
    assert got.values[[0, 1, 5]] == pytest.approx((10.0, 1.0, math.pi / 2))


def test_relative_poses_count_from_the_first() -> None:
    one = PoseInput(_part(0, 1, 5), relative=True)
    first = Pose3((3.0, 1.0, 0.0), LEFT.quaternion)
    start = one.measured(0.0, first, NOISE)
    then = one.measured(1.0, first @ Pose3((2.0, 0.0, 0.0)), NOISE)
    assert start is not None
    assert then is not None
    assert start.values == pytest.approx(np.zeros(SIZE))
    assert then.values[:2] == pytest.approx((2.0, 0.0))
    one.forget()
    again = one.measured(2.0, first, NOISE)
    assert again is not None
    assert again.values == pytest.approx(np.zeros(SIZE))


def test_differences_of_poses_are_velocities() -> None:
    one = PoseInput(_part(0, 5), differential=True)
    step = Pose3.from_rpy((0.2, 0.0, 0.0), (0.0, 0.0, 0.1))
    first = Pose3((3.0, 1.0, 0.0), LEFT.quaternion)
    assert one.measured(1.0, first, NOISE) is None
    got = one.measured(1.5, first @ step, NOISE)
    assert got is not None
    assert np.flatnonzero(got.mask).tolist() == [6, 11]
    assert got.values[[6, 11]] == pytest.approx((0.4, 0.2))
    assert got.covariance[6, 6] == pytest.approx((1.0 + 1.0) * 0.5)


def test_an_imu_that_faces_left_swaps_roll_and_pitch() -> None:
    tilted = Pose3.from_rpy((0.0, 0.0, 0.0), (0.0, -0.1, math.pi / 2 + 0.3))
    got = PoseInput(_part(3, 4, 5)).of_imu(0.0, tilted, NOISE, LEFT)
    assert got is not None
    assert got.values[3:6] == pytest.approx((0.1, 0.0, 0.3))


@pytest.mark.parametrize("knows", [True, False])
def test_gravity_is_taken_out_by_the_attitude(knows: bool) -> None:
    state = np.zeros(SIZE)
    state[4] = 0.2
    tilted = Pose3.from_rpy((0.0, 0.0, 0.0), (0.0, 0.2, 0.0)) @ LEFT
    felt = tilted.rotation().T @ np.array((0.0, 0.0, 9.8))
    free = without_gravity(felt + 1.0, 9.8, tilted if knows else None, LEFT, state)
    assert free == pytest.approx(np.ones(3))
    got = acceleration_measured(_part(12), 0.0, np.array((1.0, 2.0, 3.0)), np.eye(3), LEFT)
    assert np.flatnonzero(got.mask).tolist() == [13]
    assert got.values[12:] == pytest.approx((-2.0, 1.0, 3.0))


def _estimator(history: float = 0.0, now: bool = False) -> Estimator:
    return Estimator(
        ExtendedFilter, Noise(np.eye(SIZE) * 0.05), 0.1, history=history, predict_to_now=now
    )


def _speed(stamp: float, value: float) -> Measurement:
    values = np.zeros(SIZE)
    values[6] = value
    return Measurement(stamp, values, np.eye(SIZE) * 0.01, np.arange(SIZE) == 6)


def _run(estimator: Estimator, measured: list[Measurement], updates: list[float]) -> Floats:
    arrivals = iter(measured)
    for now in updates:
        estimator.add(next(arrivals))
        estimator.update(now)
    return estimator.filter.state


def test_what_comes_late_counts_at_its_time_where_a_history_is_kept() -> None:
    ordered = [_speed(0.1 * k, 0.1 * k * k) for k in range(1, 7)]
    late = [*ordered[:2], *ordered[3:5], ordered[2], ordered[5]]
    at = [0.1, 0.2, 0.4, 0.5, 0.55, 0.6]
    expected = _run(_estimator(), ordered, [0.1, 0.2, 0.3, 0.4, 0.5, 0.6])
    assert _run(_estimator(1.0), late, at) == pytest.approx(expected, abs=1e-12)
    assert _run(_estimator(), late, at) != pytest.approx(expected, abs=1e-3)
    assert _run(_estimator(0.1), late, at) != pytest.approx(expected, abs=1e-3)


def test_measurements_wait_for_their_time_and_come_in_order() -> None:
    estimator = _estimator()
    for measured in (_speed(0.4, 1.0), _speed(0.2, 0.5)):
        estimator.add(measured)
    estimator.update(0.3)
    assert estimator.stamp == pytest.approx(0.2)
    assert estimator.filter.state[6] == pytest.approx(0.5)


@pytest.mark.parametrize(("now", "stamp"), [(False, 1.0), (True, 1.05)])
def test_in_silence_the_state_is_predicted_on(now: bool, stamp: float) -> None:
    estimator = _estimator(now=now)
    estimator.add(_speed(1.0, 2.0))
    estimator.update(1.0)
    estimator.update(1.05)
    assert estimator.stamp == pytest.approx(stamp)
    estimator.update(1.5)
    assert estimator.stamp == pytest.approx(1.5)
    assert estimator.filter.state[0] == pytest.approx(1.0)


def test_a_pose_is_set_at_rest_and_a_reset_forgets_it() -> None:
    estimator = _estimator()
    estimator.add(_speed(1.0, 2.0))
    estimator.update(1.0)
    estimator.set_pose(np.arange(6.0) / 10, np.eye(6) * 0.5, 2.0)
    assert estimator.filter.state == pytest.approx(np.array([*np.arange(6.0) / 10, *[0.0] * 9]))
    assert estimator.filter.covariance[0, 0] == 0.5
    assert estimator.filter.covariance[6, 6] == 1e-6
    estimator.reset()
    assert estimator.stamp is None
    assert not estimator.filter.state.any()


def test_a_command_accelerates_within_limits_until_it_is_old() -> None:
    limits, gains = np.array([[0.5] * 6, [0.2] * 6]), np.array([[1.0] * 6, [2.0] * 6])
    control = Control(np.arange(6) == 0, limits, gains, 0.3)
    standing, moving, command = np.zeros(6), np.full(6, 1.0), np.full(6, 1.3)
    assert control.accelerations(standing, command, 0.0)[0] == 0.5
    assert control.accelerations(moving, command, 0.0)[0] == pytest.approx(0.3)
    assert control.accelerations(moving, command, 0.3)[0] == -0.2
    assert np.isnan(control.accelerations(moving, command, 0.0)[1:]).all()


FIX = GeoPoint(48.1, 11.5, 520.0)


@pytest.mark.parametrize("yaw", [0.0, 0.7, -2.0])
def test_the_receiver_and_what_lies_around_it_are_where_they_should(yaw: float) -> None:
    pose = Pose3.from_rpy((4.0, -1.0, 0.5), (0.0, 0.0, 0.3))
    earth = EarthFrame.of_start(FIX, yaw, pose, (0.2, 0.1, 0.4))
    receiver = pose.apply(np.array([[0.2, 0.1, 0.4]]))[0]
    assert earth.to_world(FIX) == pytest.approx(receiver)
    # what lies ahead of the robot, which faces `yaw` from east, lies at 0.3 rad in the world
    ahead = TangentPlane(FIX).geodetic(10.0 * np.array((math.cos(yaw), math.sin(yaw), 0.0)))
    expected = receiver + 10.0 * np.array((math.cos(0.3), math.sin(0.3), 0.0))
    assert earth.to_world(ahead) == pytest.approx(expected, abs=1e-6)
    back = earth.to_earth(expected)
    assert back.latitude_deg == pytest.approx(ahead.latitude_deg, abs=1e-9)
    assert back.longitude_deg == pytest.approx(ahead.longitude_deg, abs=1e-9)
