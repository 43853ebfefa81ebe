"""Kinematics, dead reckoning and pacing by exact arithmetic."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from arjuna_core.se2 import SE2
from arjuna_core.twist import Velocity
from arjuna_sim.devices.drive import Base, DriveConfig, Kinematics, kinematics_of
from arjuna_sim.devices.odometry import Odometry, OdometryConfig
from arjuna_sim.model.settings import DriveSettings

KINEMATICS = Kinematics(track=0.6, radius=0.05)


def _odometry(ticks: int, noise: float = 0.0) -> Odometry:
    config = OdometryConfig(ticks_per_revolution=ticks, encoder_noise=noise)
    return Odometry(config, KINEMATICS, np.random.default_rng(5))


def test_covariance_does_not_depend_on_how_often_it_is_updated() -> None:
    results = []
    for steps in (50, 500):
        odometry = _odometry(10_000_000)
        for i in range(1, steps + 1):
            last = odometry.update((40.0 * i / steps, 50.0 * i / steps), 1.0 / steps)
        results.append(last.covariance)
    assert np.allclose(results[0], results[1], rtol=0.05, atol=1e-6)
    assert np.linalg.eigvalsh(results[0]).min() > 0.0


class Exact(Base):
    """A base whose encoders count its path ahead, its path to the left and its turn, one each."""

    def speeds(self, velocity: Velocity) -> NDArray[np.float64]:
        return np.array([velocity.x, velocity.y, velocity.yaw_rate])

    def motion(
        self, turns: NDArray[np.float64], angles: NDArray[np.float64]
    ) -> tuple[float, float, float]:
        path, side, turn = turns.tolist()
        return path, side, turn


def test_each_step_is_an_arc_with_noise_of_path_and_turn() -> None:
    config = OdometryConfig(10_000_000, linear_noise=0.1, angular_noise=0.2, drift_noise=0.3)
    odometry = Odometry(config, Exact(), np.random.default_rng(0))
    encoders, pose = np.array([1.0, 2.0, 3.0]), SE2()
    odometry.reset(encoders)  # type: ignore[arg-type]
    rng = np.random.default_rng(7)
    for step in rng.uniform(-0.5, 0.5, (50, 3)).tolist():
        encoders += step
        seen = odometry.update(encoders, 0.1)
        pose = pose @ SE2.exp(tuple(step))
        assert seen.T_odom_base.array() == pytest.approx(pose.array(), abs=1e-4)
        assert (seen.v, seen.side, seen.w) == pytest.approx(tuple(10.0 * np.array(step)), abs=1e-4)
        direction, turn = math.hypot(*step[:2]), abs(step[2])
        expected = 0.1**2 * direction, 0.2**2 * turn + 0.3**2 * direction
        assert np.array(seen.twist_variance) * 0.1**2 == pytest.approx(expected, abs=1e-6)
    grown = seen.covariance
    odometry.reset((0.0, 0.0, 0.0))
    rest = odometry.update((0.0, 0.0, 0.0), 0.1)
    assert (rest.T_odom_base, rest.v, rest.w, rest.side) == (SE2(), 0.0, 0.0, 0.0)
    assert np.abs(grown).max() > 0.0 == np.abs(rest.covariance).max()


def test_encoders_count_whole_ticks() -> None:
    odometry = _odometry(4)
    assert odometry.update((0.5, 0.5), 0.1).v == 0.0
    assert odometry.update((1.6, 1.6), 0.1).v == pytest.approx(math.pi / 2 * 0.05 / 0.1)


def test_noise_of_the_encoders_jitters_and_does_not_add_up() -> None:
    odometry = _odometry(4096, noise=2.0)
    poses = [odometry.update((0.0, 0.0), 0.02).T_odom_base for _ in range(2000)]
    meters_per_tick = 2.0 * math.pi / 4096 * 0.05
    x = np.array([pose.x for pose in poses]) / meters_per_tick
    # The mean of two wheels, each rounded to whole ticks.
    assert x.std() == pytest.approx(math.sqrt((2.0**2 + 1 / 12) / 2), rel=0.1)
    assert np.abs(x).max() < 12.0


def test_wheels_turn_as_the_velocity_asks() -> None:
    left, right = Kinematics(track=0.5, radius=0.1).speeds(Velocity(1.0, yaw_rate=2.0))
    assert (left, right) == pytest.approx((5.0, 15.0))
    settings = DriveSettings(("l",), ("r",), 0.5, 0.05, 1.0, 0.6, 0.04)
    assert kinematics_of(settings, DriveConfig()) == Kinematics(0.6, 0.04)
    own = DriveConfig(effective_track_width=0.7, effective_wheel_radius=0.03)
    assert kinematics_of(settings, own) == Kinematics(0.7, 0.03)
