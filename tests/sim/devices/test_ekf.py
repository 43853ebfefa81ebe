"""The filter of wheels and gyro: exact motion, slip, bias, and covariances that tell the truth."""

from __future__ import annotations

import math

import numpy as np
import pytest

from arjuna_core.se2 import SE2, wrap
from arjuna_core.twist import Velocity
from arjuna_sim.config import SimulatorConfig
from arjuna_sim.devices.ekf import FusedOdometry, FusedOdometryConfig
from arjuna_sim.devices.odometry import OdometryEstimate
from arjuna_sim.devices.sensors.imu import ImuConfig
from tests.sim.builders import simulator

DT = 0.02


def _run(
    filter_: FusedOdometry, seconds: float, v: float, wheel_w: float, gyro_w: float
) -> OdometryEstimate:
    for _ in range(round(seconds / DT)):
        filter_.predict(DT)
        filter_.wheels(v, wheel_w)
        filter_.gyro(gyro_w)
    return filter_.estimate


def test_a_circle_is_followed_when_wheels_and_gyro_agree() -> None:
    filter_ = FusedOdometry(FusedOdometryConfig(bias_noise=0.0))
    _run(filter_, 0.2, 0.5, 0.5, 0.5)
    start = filter_.estimate.T_odom_base
    end = _run(filter_, 2.0, 0.5, 0.5, 0.5)
    step = start.inverse() @ end.T_odom_base
    assert (step.x, step.y, step.theta) == pytest.approx(
        (math.sin(1.0), 1.0 - math.cos(1.0), 1.0), abs=2e-3
    )
    assert (end.v, end.w) == pytest.approx((0.5, 0.5), abs=1e-3)


def test_wheels_that_slip_are_overruled_by_the_gyro() -> None:
    filter_ = FusedOdometry(FusedOdometryConfig(bias_noise=0.0))
    _run(filter_, 1.0, 0.0, 0.0, 0.0)
    end = _run(filter_, 2.0, 0.3, 1.0, 0.6)
    assert end.T_odom_base.theta == pytest.approx(1.2, abs=0.03)


def test_the_gyros_bias_is_learnt_at_rest() -> None:
    filter_ = FusedOdometry(FusedOdometryConfig())
    rested = _run(filter_, 5.0, 0.0, 0.0, 0.008)
    assert filter_.bias == pytest.approx(0.008, abs=5e-4)
    assert abs(rested.T_odom_base.theta) < 5e-3
    end = _run(filter_, 20.0, 0.5, 0.0, 0.008)
    assert abs(end.T_odom_base.theta) < 0.02  # the bias alone would make 0.16


def test_a_robot_that_is_turned_by_hand_does_not_spoil_the_bias() -> None:
    filter_ = FusedOdometry(FusedOdometryConfig())
    _run(filter_, 2.0, 0.0, 0.0, 0.0)
    turned = _run(filter_, 2.0, 0.0, 0.0, 0.5)
    assert abs(filter_.bias) < 1e-3
    assert turned.T_odom_base.theta == pytest.approx(1.0, abs=0.05)


def test_a_robot_that_still_rocks_when_its_wheels_stand_teaches_no_bias() -> None:
    filter_ = FusedOdometry(FusedOdometryConfig())
    turned = 0.0
    for i in range(200):  # it begins below the rate at which a robot is carried
        rate = 0.04 * math.exp(-5.0 * i * DT)
        turned += rate * DT
        estimate = _run(filter_, DT, 0.0, 0.0, rate)
    assert filter_.bias == pytest.approx(0.0, abs=2e-3)
    assert estimate.T_odom_base.theta == pytest.approx(turned, abs=0.01)


@pytest.mark.parametrize("bias", [0.0, 0.01])
def test_a_square_is_never_worse_than_by_the_gyro_alone(bias: float) -> None:
    """20 m of straights, turns and rests: the mean error over seeds, with a margin for luck."""
    errors = np.array([_square(bias, 1.0, seed) for seed in range(5)])
    fused, gyro = np.sqrt((errors**2).mean(axis=0))
    assert fused < 1.2 * gyro + math.radians(0.05)


def _square(bias: float, rest: float, seed: int) -> tuple[float, float]:
    """Return the heading's error [rad] by the filter and by the gyro's sum."""
    filter_, rng = FusedOdometry(FusedOdometryConfig()), np.random.default_rng(seed)
    truth = by_gyro = 0.0
    turn = math.pi / 2 / 0.8
    for v, w, seconds in ((0.0, 0.0, rest), *_legs(rest, turn) * 4):
        for _ in range(round(seconds / DT)):
            rate = w + bias + 0.002 * rng.standard_normal()
            truth, by_gyro = truth + w * DT, by_gyro + rate * DT
            filter_.predict(DT)
            filter_.wheels(v, 1.05 * w)
            filter_.gyro(rate, 0.002**2)
    return wrap(filter_.estimate.T_odom_base.theta - truth), wrap(by_gyro - truth)


def _legs(rest: float, turn: float) -> tuple[tuple[float, float, float], ...]:
    return ((0.5, 0.0, 10.0), (0.0, 0.0, rest), (0.0, 0.8, turn), (0.0, 0.0, rest))


def test_a_base_that_moves_sideways_is_followed_while_it_turns() -> None:
    """Along the exact arc of a constant twist, whatever its direction."""
    filter_ = FusedOdometry(FusedOdometryConfig(bias_noise=0.0))
    poses = []
    for _ in range(125):
        poses.append(filter_.estimate.T_odom_base)
        filter_.predict(DT)
        filter_.wheels(0.2, 0.5, 0.3)
        filter_.gyro(0.5)
    end = filter_.estimate
    expected = SE2.exp((0.4, 0.6, 1.0))
    step = poses[25].inverse() @ end.T_odom_base
    assert (step.x, step.y, step.theta) == pytest.approx(
        (expected.x, expected.y, expected.theta), abs=2e-3
    )
    assert (end.v, end.side) == pytest.approx((0.2, 0.3), abs=1e-3)


def test_wheels_serve_alone_where_no_gyro_comes() -> None:
    filter_ = FusedOdometry(FusedOdometryConfig())
    for _ in range(100):
        filter_.predict(DT)
        filter_.wheels(0.5, 0.4)
    estimate = filter_.estimate
    assert estimate.w == pytest.approx(0.4, abs=0.01)
    assert estimate.T_odom_base.theta == pytest.approx(0.8, abs=0.02)


def test_covariance_stays_symmetric_and_positive() -> None:
    filter_ = FusedOdometry(FusedOdometryConfig())
    rng = np.random.default_rng(2)
    for _ in range(3000):
        v, w = rng.normal(0.0, 0.5), rng.normal(0.0, 1.0)
        estimate = _run(filter_, DT, v, w, w + rng.normal(0.0, 0.002))
    covariance = estimate.covariance
    assert np.allclose(covariance, covariance.T)
    assert np.linalg.eigvalsh(covariance).min() > 0.0


def _drive(seed: int, imu: ImuConfig | None = None) -> tuple[float, float, float]:
    """Drive about; return the heading's error by wheels, by the filter, and its sigma [rad]."""
    sim = simulator(config=SimulatorConfig(imu=imu or ImuConfig()), seed=seed)
    filter_, rng = FusedOdometry(FusedOdometryConfig()), np.random.default_rng(seed)
    command = Velocity()
    for i in range(3000):
        if i % 60 == 0:  # from 1.2 s on
            command = Velocity(
                float(rng.uniform(-0.2, 0.8)), yaw_rate=float(rng.uniform(-2.0, 2.0))
            )
        last = sim.drive(command if i >= 60 else Velocity())
        assert last.imu is not None
        filter_.predict(DT)
        filter_.wheels(last.odometry.v, last.odometry.w)
        filter_.gyro(float(last.imu.angular_velocity[2]), last.imu.angular_variance)
    truth, estimate = last.truth.pose.theta, filter_.estimate
    wheels = wrap(last.odometry.T_odom_base.theta - truth)
    fused = wrap(estimate.T_odom_base.theta - truth)
    return abs(wheels), abs(fused), math.sqrt(estimate.covariance[2, 2])


def test_heading_after_a_minute_of_slipping_is_better_than_by_wheels_and_as_good_as_told() -> None:
    errors = np.array([_drive(seed) for seed in range(4)])
    wheels, fused, sigma = errors.T
    assert np.sqrt((fused**2).mean()) < 0.5 * np.sqrt((wheels**2).mean())
    assert (fused < 4.0 * sigma).all()
    assert sigma.max() < 0.05
