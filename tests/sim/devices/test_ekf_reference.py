"""The filter of wheels and gyro against a Kalman filter in plain matrices, by the book."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from arjuna_core.se2 import SE2
from arjuna_sim.devices.ekf import FusedOdometry, FusedOdometryConfig

DT = 0.02
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
        ways = np.zeros((3, 7))
        ways[0, [X, Y]] = (math.cos(heading), math.sin(heading))
        ways[1, [X, Y]] = (-math.sin(heading), math.cos(heading))
        ways[2, THETA] = 1.0
        self.covariance = F @ self.covariance @ F.T
        for way, speed in zip(ways, np.eye(7)[[V, SIDE, W]], strict=True):
            for a, b, time in ((way, way, dt**3 / 3), (speed, speed, dt)):
                self.covariance += 0.4**2 * time * np.outer(a, b)
            both = np.outer(way, speed)
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


def test_wheels_alone_tell_how_fast_it_turns() -> None:
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
    for i in range(40):
        filter_.predict(DT)
        filter_.wheels(0.0, 0.0)
        filter_.gyro(rate + noise * (1.0 if i % 2 else -1.0))
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
    for _ in range(40):
        filter_.predict(DT)
        filter_.wheels(v, w, side)
        filter_.gyro(0.004)
    assert (filter_.bias > 1e-3) == learns


def test_a_rest_begins_anew_after_each_motion() -> None:
    filter_ = FusedOdometry(FusedOdometryConfig())
    for i in range(200):
        filter_.predict(DT)
        filter_.wheels(0.1 if i % 20 == 0 else 0.0, 0.0)  # 0.38 s of rest at a time
        filter_.gyro(0.004)
    assert filter_.bias == 0.0


def test_a_bias_that_is_sure_is_taken_off_once_it_moves() -> None:
    filter_ = FusedOdometry(FusedOdometryConfig())
    for _ in range(100):
        filter_.predict(DT)
        filter_.wheels(0.0, 0.0)
        filter_.gyro(0.008)
    start = filter_.estimate.T_odom_base.theta
    for _ in range(100):
        filter_.predict(DT)
        filter_.wheels(0.5, 0.0)
        filter_.gyro(0.308)
    assert filter_.estimate.T_odom_base.theta - start == pytest.approx(0.3 * 2.0, abs=0.006)


def test_a_bias_up_to_the_rate_of_sliding_is_learnt_to_its_end() -> None:
    filter_ = FusedOdometry(FusedOdometryConfig())
    for _ in range(300):
        filter_.predict(DT)
        filter_.wheels(0.0, 0.0)
        filter_.gyro(-0.03)
    assert filter_.bias == pytest.approx(-0.03, abs=1e-3)


def test_a_bias_that_is_not_told_from_none_stays_on() -> None:
    filter_ = FusedOdometry(FusedOdometryConfig())
    for _ in range(32):  # of which 7 teach: to 0.0006 rad/s, by 0.00075
        filter_.predict(DT)
        filter_.wheels(0.0, 0.0)
        filter_.gyro(0.0006)
    learnt = filter_.bias
    assert 0.0004 < learnt < 0.0006
    for _ in range(100):
        filter_.predict(DT)
        filter_.wheels(0.5, 0.0)
        filter_.gyro(0.3006)
    assert filter_.bias == learnt
    assert filter_.estimate.w == pytest.approx(0.3006, abs=1e-5)  # not 0.3
