"""Odometry from wheels and gyro, against a filter in plain NumPy too."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
import pytest
from numpy.typing import NDArray

from arjuna_core.se2 import SE2, wrap
from arjuna_core.twist import Velocity
from arjuna_sim.config import SimulatorConfig
from arjuna_sim.devices.ekf import FusedOdometry, FusedOdometryConfig
from arjuna_sim.devices.odometry import OdometryEstimate
from arjuna_sim.devices.sensors.imu import ImuConfig
from tests.sim.builders import simulator

DT = 0.02


def _run(
    filter_: FusedOdometry, gyro: Iterable[float], v: float = 0.0, w: float = 0.0, side: float = 0.0
) -> OdometryEstimate:
    """Step with rates of the gyro [rad/s] and constant speeds of the wheels."""
    for rate in gyro:
        filter_.predict(DT)
        filter_.wheels(v, w, side)
        filter_.gyro(rate)
    return filter_.estimate


def test_a_robot_that_is_turned_by_hand_does_not_spoil_the_bias() -> None:
    filter_ = FusedOdometry(FusedOdometryConfig())
    _run(filter_, 100 * [0.0])
    turned = _run(filter_, 100 * [0.5])
    assert abs(filter_.bias) < 1e-3
    assert turned.T_odom_base.theta == pytest.approx(1.0, abs=0.05)


def test_a_robot_that_still_rocks_when_its_wheels_stand_teaches_no_bias() -> None:
    filter_ = FusedOdometry(FusedOdometryConfig())
    # It begins below the rate at which a robot is carried.
    rates = 0.04 * np.exp(-5.0 * DT * np.arange(200))
    estimate = _run(filter_, rates.tolist())
    assert filter_.bias == pytest.approx(0.0, abs=2e-3)
    assert estimate.T_odom_base.theta == pytest.approx(rates.sum() * DT, abs=0.01)


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


def test_heading_after_a_minute_of_slipping_is_better_than_by_wheels_and_within_its_sigma() -> None:
    errors = np.array([_drive(seed) for seed in range(2)])
    wheels, fused, sigma = errors.T
    assert np.sqrt((fused**2).mean()) < 0.5 * np.sqrt((wheels**2).mean())
    assert (fused < 4.0 * sigma).all()
    assert sigma.max() < 0.05


X, Y, THETA, V, SIDE, W, BIAS = range(7)


class Reference:
    """Thrun, Burgard and Fox, section 3.3, with Jacobians by finite differences.

    Speeds change by white accelerations of 0.4 m/s^2 and 0.4 rad/s^2 per root of hertz, the bias
    walks by 1e-5. A bias is estimated at rest and else considered only (Schmidt): its gain is 0.
    """

    def __init__(self) -> None:
        self.state, self.covariance = np.zeros(7), np.diag([0.0] * 6 + [0.01**2])

    def predict(self, dt: float) -> None:
        x = self.state.copy()
        tiny = 1e-6
        F = np.stack(
            [(_moved(x + tiny * e, dt) - _moved(x - tiny * e, dt)) / 2 / tiny for e in np.eye(7)], 1
        )
        heading = x[THETA] + x[W] * dt / 2
        paths = np.zeros((3, 7))
        paths[0, [X, Y]] = (math.cos(heading), math.sin(heading))
        paths[1, [X, Y]] = (-math.sin(heading), math.cos(heading))
        paths[2, THETA] = 1.0
        self.covariance = F @ self.covariance @ F.T
        for path, speed in zip(paths, np.eye(7)[[V, SIDE, W]], strict=True):
            for a, b, time in ((path, path, dt**3 / 3), (speed, speed, dt)):
                self.covariance += 0.4**2 * time * np.outer(a, b)
            both = np.outer(path, speed)
            self.covariance += 0.4**2 * dt**2 / 2 * (both + both.T)
        self.covariance[BIAS, BIAS] += 1e-5**2 * dt
        self.state = _moved(x, dt)

    def measure(self, row: NDArray[np.float64], value: float, variance: float, rests: bool) -> None:
        gain = self.covariance @ row / (row @ self.covariance @ row + variance)
        if rests:
            gain[:V] = 0.0  # what lies behind stays as it is
        else:
            gain[BIAS] = 0.0
        self.state = self.state + gain * (value - row @ self.state)
        left = np.eye(7) - np.outer(gain, row)
        self.covariance = left @ self.covariance @ left.T + variance * np.outer(gain, gain)


def _moved(x: NDArray[np.float64], dt: float) -> NDArray[np.float64]:
    end = SE2(*x[:3].tolist()) @ SE2.exp((x[V] * dt, x[SIDE] * dt, x[W] * dt))
    found: NDArray[np.float64] = x.copy()
    found[:3] = end.x, end.y, x[THETA] + x[W] * dt
    return found


def unit(*indices: int) -> NDArray[np.float64]:
    row: NDArray[np.float64] = np.eye(7)[list(indices)].sum(axis=0)
    return row


def agree(filter_: FusedOdometry, reference: Reference) -> None:
    """Compare what a user sees: the pose, speeds, bias and their covariances."""
    found, x, P = filter_.estimate, reference.state, reference.covariance
    pose = found.T_odom_base
    seen = (pose.x, pose.y, pose.theta, found.v, found.side, found.w, filter_.bias)
    assert seen == pytest.approx(x, rel=1e-3, abs=1e-6)
    scale = np.sqrt(np.outer(P.diagonal(), P.diagonal()))[:3, :3]
    assert (np.abs(found.covariance - P[:3, :3]) <= 2e-3 * scale + 1e-15).all()
    assert found.twist_variance == pytest.approx((P[V, V], P[W, W]), rel=2e-3)


def test_a_moving_robot_is_filtered_by_the_book() -> None:
    filter_, reference = FusedOdometry(FusedOdometryConfig()), Reference()
    rng = np.random.default_rng(4)
    for i in range(150):
        v, side, w = 0.5 * math.sin(0.05 * i), 0.1 * math.cos(0.03 * i), 0.8 * math.sin(0.02 * i)
        side = side if i >= 75 else 0.0
        wheel_w, gyro = 1.1 * w, w + rng.normal(0.0, 0.002)
        filter_.predict(DT)
        filter_.wheels(v, wheel_w, side)
        filter_.gyro(gyro, 0.003**2 if i % 2 else 0.0)
        reference.predict(DT)
        speed = (2e-4) ** 2 + 0.01**2 * (v**2 + side**2)
        reference.measure(unit(V), v, speed, rests=False)
        reference.measure(unit(SIDE), side, speed if side else (2e-4) ** 2, rests=False)
        if i == 0:  # no gyro has come before
            reference.measure(unit(W), wheel_w, (2e-4) ** 2 + (0.1 * wheel_w) ** 2, rests=False)
        noise = 0.003**2 if i % 2 else 0.002**2
        reference.measure(unit(W, BIAS), gyro, noise, rests=False)
        agree(filter_, reference)


def test_wheels_alone_measure_the_turn_rate() -> None:
    filter_, reference = FusedOdometry(FusedOdometryConfig()), Reference()
    for i in range(100):
        v, w = 0.3, 0.5 + 0.002 * i
        filter_.predict(DT)
        filter_.predict(0.0)
        filter_.predict(-1.0)  # no time goes by
        filter_.wheels(v, w)
        reference.predict(DT)
        reference.measure(unit(V), v, (2e-4) ** 2 + 0.01**2 * v**2, rests=False)
        reference.measure(unit(SIDE), 0.0, (2e-4) ** 2, rests=False)
        reference.measure(unit(W), w, (2e-4) ** 2 + (0.1 * w) ** 2, rests=False)
        agree(filter_, reference)


def rest(filter_: FusedOdometry, reference: Reference, count: int, gyro: float, since: int) -> None:
    """Let both rest; from a step on they have rested for half a second."""
    for i in range(count):
        filter_.predict(DT)
        filter_.wheels(0.0, 0.0)
        filter_.gyro(gyro)
        rests = i > since  # of the wheels; the gyro says so a call later
        reference.predict(DT)
        reference.measure(unit(V), 0.0, (2e-4) ** 2, rests)
        reference.measure(unit(SIDE), 0.0, (2e-4) ** 2, rests)
        if i == 0 and not reference.state.any():
            reference.measure(unit(W), 0.0, (2e-4) ** 2, rests)
        rests = i >= since
        if rests:
            reference.measure(unit(W), 0.0, (2e-4) ** 2, rests)
        bias, sigma = reference.state[BIAS], math.sqrt(reference.covariance[BIAS, BIAS])
        unsure = bias if not rests and abs(bias) < 3.0 * sigma else 0.0
        reference.measure(unit(W, BIAS), gyro + unsure, 0.002**2, rests)
        agree(filter_, reference)


def test_a_bias_is_learnt_once_wheels_and_gyro_have_rested_for_half_a_second() -> None:
    filter_, reference = FusedOdometry(FusedOdometryConfig()), Reference()
    rest(filter_, reference, 60, 0.004, since=25)  # 25 steps of 0.02 s after the first
    assert 0.003 < filter_.bias < 0.0045


@pytest.mark.parametrize(
    ("rate", "noise", "learns"),
    [(0.049, 0.0, True), (0.051, 0.0, False), (0.01, 0.0027, True), (0.01, 0.0030, False)],
)
def test_what_turns_or_shakes_is_not_at_rest(rate: float, noise: float, learns: bool) -> None:
    """A gyro of 0.002 rad/s: rest is below 0.05 rad/s, and up to twice its variance, 0.0028^2."""
    filter_ = FusedOdometry(FusedOdometryConfig())
    _run(filter_, 20 * [rate - noise, rate + noise])
    assert (abs(filter_.bias) > 1e-3) == learns


@pytest.mark.parametrize(
    ("v", "w", "side", "learns"),
    [
        *((0.0, 0.0, 0.0, True), (9e-4, -9e-4, 0.0, True), (0.0, 0.0, -9e-4, True)),
        *((1e-3, 0.0, 0.0, False), (-2e-3, 0.0, 0.0, False)),
        *((0.0, -1e-3, 0.0, False), (0.0, 0.0, -1e-3, False)),
    ],
)
def test_wheels_stand_below_a_millimetre_a_second(
    v: float, w: float, side: float, learns: bool
) -> None:
    filter_ = FusedOdometry(FusedOdometryConfig())
    _run(filter_, 40 * [0.004], v, w, side)
    assert (filter_.bias > 1e-3) == learns


def test_a_rest_starts_again_after_each_motion() -> None:
    filter_ = FusedOdometry(FusedOdometryConfig())
    for _ in range(10):  # 0.38 s of rest at a time
        _run(filter_, [0.004], 0.1)
        _run(filter_, 19 * [0.004])
    assert filter_.bias == 0.0


def test_a_bias_that_is_sure_is_taken_off_once_it_moves() -> None:
    filter_ = FusedOdometry(FusedOdometryConfig())
    start = _run(filter_, 100 * [0.008]).T_odom_base.theta
    end = _run(filter_, 100 * [0.308], 0.5).T_odom_base.theta
    assert end - start == pytest.approx(0.3 * 2.0, abs=0.006)


def test_a_bias_up_to_the_rate_of_sliding_is_learnt_to_its_end() -> None:
    filter_ = FusedOdometry(FusedOdometryConfig())
    _run(filter_, 300 * [-0.03])
    assert filter_.bias == pytest.approx(-0.03, abs=1e-3)


def test_an_insignificant_bias_is_hardly_removed() -> None:
    filter_ = FusedOdometry(FusedOdometryConfig())
    _run(filter_, 32 * [0.0006])  # of which 7 teach: to 0.0006 rad/s, by 0.00075
    learnt = filter_.bias
    assert 0.0004 < learnt < 0.0006
    moving = _run(filter_, 100 * [0.3006], 0.5)
    assert filter_.bias == learnt
    assert moving.w == pytest.approx(0.3006, abs=1e-4)  # not 0.3


@pytest.mark.parametrize(
    ("noise", "rate", "walk", "mean", "spread"),
    [
        *((0.002, 50, 1e-5, 0.0, 0.0), (2e-4, 100, 1e-5, 0.0, 0.0), (2e-4, 100, 0.0, 0.0, 0.0)),
        *((2e-4, 100, 0.0, 7.5e-6, 8e-7), (0.009, 50, 1e-5, 0.003, 0.001)),
        *((0.001, 50, 0.0, 0.02, 0.0), (0.002, 50, 1e-5, 0.0, 0.01)),
    ],
)
def test_headings_of_a_mission_are_twice_as_far_off_as_the_ideal_filters_at_most(
    noise: float, rate: int, walk: float, mean: float, spread: float
) -> None:
    """IMUs as Gazebo's files have them, of drives with rests, over seeds.

    The ideal filter knows how the file draws biases and when the robot rests.
    """
    errors, sigmas = [], []
    for seed in range(4):
        rng = np.random.default_rng(seed)
        legs = _mission(rng)
        errors.append(_heading_error(legs, rng, noise, rate, walk, mean, spread))
        sigmas.append(_ideal_sigma(legs, noise, rate, walk, math.hypot(mean, spread)))
    resolution = math.radians(0.05)
    assert np.sqrt(np.mean(np.square(errors))) < 2.0 * np.mean(sigmas) + resolution


def _mission(rng: np.random.Generator) -> list[tuple[float, float, float]]:
    """Return speed, turn rate and duration of its legs: 4 minutes with a rest now and then."""
    legs = [(0.0, 0.0, 2.0)]
    while sum(seconds for *_, seconds in legs) < 240.0:
        legs += [(rng.uniform(0.1, 0.3), rng.uniform(-1.0, 1.0), rng.uniform(2.0, 6.0))] * 5
        legs.append((0.0, 0.0, rng.uniform(1.0, 3.0)))
    return legs


def _heading_error(
    legs: list[tuple[float, float, float]],
    rng: np.random.Generator,
    noise: float,
    rate: int,
    walk: float,
    mean: float,
    spread: float,
) -> float:
    filter_, dt = FusedOdometry(FusedOdometryConfig()), 1.0 / rate
    truth, bias = 0.0, rng.normal(mean, spread) * rng.choice((-1.0, 1.0))
    for v, w, seconds in legs:
        for _ in range(round(seconds * rate)):
            bias += walk * math.sqrt(dt) * rng.standard_normal()
            truth += w * dt
            filter_.predict(dt)
            filter_.wheels(v, 1.05 * w)
            filter_.gyro(w + bias + noise * rng.standard_normal(), noise**2)
    return wrap(filter_.estimate.T_odom_base.theta - truth)


def _ideal_sigma(
    legs: list[tuple[float, float, float]], noise: float, rate: int, walk: float, bias: float
) -> float:
    """Return the deviation of the heading by a Kalman filter of the bias, learnt at rest."""
    heading = shared = 0.0  # variance, and covariance with the bias' error
    variance, dt = bias**2, 1.0 / rate
    for v, w, seconds in legs:
        for i in range(round(seconds * rate)):
            variance += walk**2 * dt
            if v or w:
                heading += 2.0 * dt * shared + dt**2 * (variance + noise**2)
                shared += dt * variance
            elif i >= 0.5 * rate:  # the time that a robot must have stood
                left = noise**2 / (variance + noise**2)
                variance, shared = left * variance, left * shared
    return math.sqrt(heading)
