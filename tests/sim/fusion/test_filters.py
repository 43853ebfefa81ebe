"""The filters against the published equations, written down here a second time."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import pytest

from arjuna_core.arrays import Bools, Floats
from arjuna_sim.fusion.estimator import Control, Estimator
from arjuna_sim.fusion.filters import (
    ExtendedFilter,
    Filter,
    Measurement,
    Noise,
    UnscentedFilter,
)
from arjuna_sim.fusion.kinematics import SIZE, jacobian, transition

CLOSE = 1e-6
TWO_D = (2, 3, 4, 8, 9, 10, 14)


def moved(x: Floats, dt: float) -> Floats:
    """Return the state after a time [s], equation by equation."""
    px, py, pz, r, p, y, vx, vy, vz, wr, wp, wy, ax, ay, az = x
    s, c, t = math.sin, math.cos, math.tan
    forward, left, up = (v * dt + 0.5 * a * dt**2 for v, a in ((vx, ax), (vy, ay), (vz, az)))
    return np.array(
        [
            px
            + c(y) * c(p) * forward
            + (c(y) * s(p) * s(r) - s(y) * c(r)) * left
            + (c(y) * s(p) * c(r) + s(y) * s(r)) * up,
            py
            + s(y) * c(p) * forward
            + (s(y) * s(p) * s(r) + c(y) * c(r)) * left
            + (s(y) * s(p) * c(r) - c(y) * s(r)) * up,
            pz - s(p) * forward + c(p) * s(r) * left + c(p) * c(r) * up,
            r + (wr + s(r) * t(p) * wp + c(r) * t(p) * wy) * dt,
            p + (c(r) * wp - s(r) * wy) * dt,
            y + (s(r) * wp + c(r) * wy) / c(p) * dt,
            *(vx + ax * dt, vy + ay * dt, vz + az * dt),
            *(wr, wp, wy, ax, ay, az),
        ]
    )


def derivative(x: Floats, dt: float, step: float = 1e-6) -> Floats:
    """Return the derivative of `moved` by central differences."""
    columns = [(moved(x + e, dt) - moved(x - e, dt)) / (2 * step) for e in np.eye(SIZE) * step]
    result: Floats = np.array(columns).T
    return result


def wrap(angle: float) -> float:
    """Return an angle in [-pi, pi)."""
    return (angle + math.pi) % (2 * math.pi) - math.pi


@dataclass
class Peer:
    """Moore and Stouch's filter in plain loops."""

    x: Floats
    P: Floats
    Q: Floats
    dynamic: bool = False
    control: Control | None = None
    command: Floats = field(default_factory=lambda: np.zeros(6))
    t: float | None = None

    def take(self, z: Measurement) -> None:
        """Predict to a measurement's time, then correct by it."""
        used = [i for i in range(SIZE) if z.mask[i] and math.isfinite(z.values[i])]
        if self.t is None:
            for i in used:
                self.x[i] = z.values[i]
                for j in used:
                    self.P[i, j] = z.covariance[i, j]
            self.t = z.stamp
            return
        if z.stamp > self.t:
            self.predict(z.stamp - self.t)
            self.t = z.stamp
        H = np.eye(SIZE)[used]
        R = np.array([[z.covariance[i, j] for j in used] for i in used])
        for k in range(len(used)):
            R[k, k] = max(abs(R[k, k]), 1e-9)
        y = np.array([z.values[i] - self.x[i] for i in used])
        y = np.array([wrap(v) if 3 <= i < 6 else v for i, v in zip(used, y, strict=True)])
        S = H @ self.P @ H.T + R
        if math.sqrt(y @ np.linalg.solve(S, y)) >= z.threshold:
            return
        K = np.linalg.solve(S, H @ self.P).T
        self.x = self.x + K @ y
        self.x[3:6] = [wrap(a) for a in self.x[3:6]]
        A = np.eye(SIZE) - K @ H
        self.P = A @ self.P @ A.T + K @ R @ K.T

    def predict(self, dt: float) -> None:
        """Advance by a time [s]."""
        F, Q = derivative(self.x, dt), self.Q.copy()
        if self.dynamic:
            V = np.eye(6) * np.linalg.norm(self.x[6:12])
            Q[:6, :6] = V @ Q[:6, :6] @ V.T
        x = self.x.copy()
        for i in range(6) if self.control is not None else ():
            assert self.control is not None
            if not self.control.mask[i]:
                continue
            v, u = self.x[6 + i], self.command[i]
            error = u - v
            goal = u if abs(error) <= abs(u) + 0.01 else 0.0
            row = 1 if abs(goal) < abs(v) else 0
            limit, gain = self.control.limits[row, i], self.control.gains[row, i]
            a = max(-limit, min(limit, gain * error))
            if i < 3:
                x[12 + i] = a
            else:
                x[6 + i] += a * dt
        # the angles that turn the body are those before the command, which changes none
        self.x = moved(x, dt)
        self.x[3:6] = [wrap(a) for a in self.x[3:6]]
        self.P = F @ self.P @ F.T + dt * Q


def mask(*indices: int) -> Bools:
    """Return a mask with these states."""
    found: Bools = np.isin(np.arange(SIZE), indices)
    return found


WHEELS, GYRO, POSE, ATTITUDE, IMU = (
    mask(6, 7, 11),
    mask(11),
    mask(0, 1, 5),
    mask(3, 4, 5, 9, 10, 11, 12, 13, 14),
    mask(5, 11, 12),
)


def drive(masks: list[Bools], planar: bool, seed: int, threshold: float) -> list[Measurement]:
    """Return what sensors measure of a body that moves in curves, 6 s long."""
    rng = np.random.default_rng(seed)
    x, found = np.zeros(SIZE), list[Measurement]()
    for k in range(1, 301):
        t = k * 0.02
        x[12] = 0.4 * math.cos(t)
        x[9:12] = (0.0, 0.0, 0.6) if planar else (0.2 * math.cos(t), 0.1 * math.sin(2 * t), 0.6)
        x[6:9] += x[12:15] * 0.02
        x = moved(x, 0.02)
        for sensor, one in enumerate(masks):
            noise = rng.uniform(1e-4, 4e-3, SIZE)
            if k % (sensor + 1) or not rng.random() > 0.05:
                continue
            values = x + rng.normal(0.0, np.sqrt(noise))
            if rng.random() < 0.02:
                values += 5.0  # an outlier
            values[3:6] = [wrap(a) for a in values[3:6]]
            used, covariance = one.copy(), np.diag(noise)
            if planar:
                used[list(TWO_D)], values[list(TWO_D)] = True, 0.0
                covariance[TWO_D, TWO_D] = 1e-6
            found.append(Measurement(t, values, covariance, used, threshold))
    return found


CONTROL = Control(
    mask(0, 5)[:6], np.array([[1.3] * 6, [0.9] * 6]), np.array([[0.8] * 6, [1.0] * 6]), 100.0
)


@pytest.mark.parametrize(
    ("masks", "planar", "dynamic", "control", "threshold"),
    [
        ([WHEELS, GYRO], True, False, None, np.inf),
        ([WHEELS, ATTITUDE], False, False, None, np.inf),
        ([POSE, WHEELS, IMU], False, True, None, np.inf),
        ([POSE, ATTITUDE], False, False, CONTROL, np.inf),
        ([WHEELS, POSE, ATTITUDE, IMU], False, True, CONTROL, 4.0),
    ],
)
def test_the_filter_follows_the_equations(
    masks: list[Bools], planar: bool, dynamic: bool, control: Control | None, threshold: float
) -> None:
    Q, P = np.diag(np.linspace(0.01, 0.06, SIZE)), np.eye(SIZE) * 1e-2
    estimator = Estimator(
        lambda: ExtendedFilter(np.zeros(SIZE), P.copy()), Noise(Q, dynamic), 0.1, control=control
    )
    peer = Peer(np.zeros(SIZE), P.copy(), Q, dynamic, control)
    command = np.array((0.5, 0.0, 0.0, 0.0, 0.0, 0.3))
    estimator.command(command, 0.0)
    peer.command = command
    for measured in drive(masks, planar, 7, threshold):
        estimator.add(measured)
        estimator.update(measured.stamp)
        peer.take(measured)
        assert estimator.stamp == peer.t
        difference = estimator.filter.state - peer.x
        difference[3:6] = [wrap(a) for a in difference[3:6]]
        assert np.abs(difference).max() < CLOSE
        assert np.abs(estimator.filter.covariance - peer.P).max() < CLOSE
        later = copy.deepcopy(peer)
        later.predict(0.1)
        for each, ahead in ((peer, 0.0), (later, 0.1), (peer, -0.1)):
            state, covariance = estimator.at(measured.stamp + ahead)
            state = state - each.x
            state[3:6] = [wrap(a) for a in state[3:6]]
            assert np.abs(state).max() < CLOSE
            assert np.abs(covariance - each.P).max() < CLOSE
    assert np.abs(peer.x[:2]).max() > 0.1


def test_the_jacobian_is_the_derivative() -> None:
    rng = np.random.default_rng(3)
    for _ in range(20):
        x = rng.uniform(-1.2, 1.2, SIZE)
        assert transition(x, 0.05) @ x == pytest.approx(moved(x, 0.05), abs=1e-12)
        got = jacobian(x, 0.05, transition(x, 0.05))
        assert got == pytest.approx(derivative(x, 0.05), abs=1e-8)


def test_the_unscented_filter_agrees_where_the_motion_is_nearly_linear() -> None:
    found = []
    makes: tuple[Callable[[], Filter], ...] = (ExtendedFilter, UnscentedFilter)
    for make in makes:
        estimator = Estimator(make, Noise(np.eye(SIZE) * 0.01), 0.1)
        for measured in drive([WHEELS, ATTITUDE], False, 5, np.inf):
            estimator.add(measured)
            estimator.update(measured.stamp)
        found.append(estimator.filter)
    assert found[1].state == pytest.approx(found[0].state, abs=0.01)
    assert np.sqrt(found[1].covariance.diagonal()) == pytest.approx(
        np.sqrt(found[0].covariance.diagonal()), rel=0.1
    )


def test_the_unscented_prediction_has_the_mean_of_samples() -> None:
    state, spread = np.zeros(SIZE), np.full(SIZE, 1e-8)
    state[6], spread[5] = 1.0, 0.3**2
    one = UnscentedFilter(state.copy(), np.diag(spread))
    one.predict(1.0, Noise(np.zeros((SIZE, SIZE))))
    # E[cos] of a normal angle is exp(-variance / 2); to second order 1 - variance / 2
    assert one.state[0] == pytest.approx(1.0 - 0.3**2 / 2, abs=1e-3)
    assert one.covariance[1, 1] == pytest.approx(0.3**2, rel=0.05)
