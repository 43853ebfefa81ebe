"""Masks, frames, differences and gravity."""

from __future__ import annotations

import math

import numpy as np
import pytest

from arjuna_core.pose3 import Pose3
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
