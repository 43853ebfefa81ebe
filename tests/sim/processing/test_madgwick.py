"""Madgwick's filter against motions whose orientation is known."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from arjuna_sim.processing.madgwick import (
    UP,
    MadgwickFilter,
    _gradient,
    orientation,
    quaternion_of,
    rotation,
)

NORTH = {"enu": (0.0, 0.4, -0.9), "nwu": (0.4, 0.0, -0.9), "ned": (0.4, 0.0, 0.9)}
"""The earth's field in each world frame, of the northern half."""


def turned(roll: float, pitch: float, yaw: float) -> Any:
    """Return a rotation into the world by its angles about x, y, z [rad]."""
    from scipy.spatial.transform import Rotation

    return Rotation.from_euler("xyz", (roll, pitch, yaw)).as_matrix()


@pytest.mark.parametrize("world", UP)
@pytest.mark.parametrize("yaw", [0.0, 1.2, -2.5])
def test_the_first_orientation_is_that_of_gravity_and_field(world: str, yaw: float) -> None:
    R = turned(0.2, -0.3, yaw)
    up, field = R.T @ UP[world], R.T @ NORTH[world]
    np.testing.assert_allclose(orientation(9.81 * up, field, world), R, atol=1e-12)
    without = orientation(up, None, world)
    np.testing.assert_allclose(without @ up, UP[world], atol=1e-12)
    assert np.linalg.det(without) == pytest.approx(1.0)


def test_the_gradient_is_that_of_the_squared_error() -> None:
    rng = np.random.default_rng(3)
    q, direction, measured = rng.normal(size=4), rng.normal(size=3), rng.normal(size=3)
    q /= np.linalg.norm(q)

    def body(p: Any) -> Any:  # the paper's form, without the unit length
        w, x, y, z = p
        R = np.array(
            [
                [0.5 - y * y - z * z, x * y - w * z, x * z + w * y],
                [x * y + w * z, 0.5 - x * x - z * z, y * z - w * x],
                [x * z - w * y, y * z + w * x, 0.5 - x * x - y * y],
            ]
        )
        return 2.0 * R.T @ direction

    step = 1e-6
    found = _gradient(q, direction, measured)
    for part in range(4):
        shift = np.eye(4)[part] * step
        errors = [0.5 * np.sum((body(q + sign * shift) - measured) ** 2) for sign in (1, -1)]
        assert (errors[0] - errors[1]) / (2.0 * step) == pytest.approx(found[part], abs=1e-6)


def test_a_turning_sensor_is_followed_and_a_wrong_start_forgotten() -> None:
    filter_ = MadgwickFilter("enu", gain=0.5)
    filter_.quaternion = quaternion_of(turned(0.5, 0.0, 0.0))  # it lies level
    for step in range(1, 2001):
        R = turned(0.0, 0.0, 0.5 * step * 0.01)
        up, field = R.T @ UP["enu"], R.T @ NORTH["enu"]
        filter_.update(0.01, np.array((0.0, 0.0, 0.5)), 9.81 * up, field)
    difference = rotation(filter_.quaternion).T @ R
    assert math.acos(min(1.0, (np.trace(difference) - 1.0) / 2.0)) < 0.02


def test_the_bias_of_the_gyro_is_learnt() -> None:
    filter_ = MadgwickFilter("enu", gain=0.1, zeta=0.05)
    filter_.start(np.array((0.0, 0.0, 9.81)), np.array(NORTH["enu"]))
    for _ in range(4000):
        rates, up = np.array((0.02, 0.0, 0.03)), np.array((0.0, 0.0, 9.81))
        filter_.update(0.01, rates, up, np.array(NORTH["enu"]))
    np.testing.assert_allclose(filter_.bias, (0.02, 0.0, 0.03), atol=0.01)


def test_free_fall_corrects_nothing() -> None:
    filter_ = MadgwickFilter()
    filter_.update(0.5, np.array((0.0, 0.0, 0.2)), np.zeros(3), None)
    assert filter_.quaternion[3] == pytest.approx(math.sin(0.05), abs=1e-3)
