"""Odometry from wheels and a gyro: a small extended Kalman filter.

Wheels that slip measure turning badly and distance well; a gyro turns without slip but drifts.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

import numpy as np
from numba import njit

from arjuna_core.arrays import Floats
from arjuna_core.config import duration_param, param, yaw_rate_param
from arjuna_core.se2 import SE2
from arjuna_sim.devices.odometry import OdometryEstimate

_X, _Y, _THETA, _V, _SIDE, _W, _BIAS = range(7)
_SIZE = _BIAS + 1


@dataclass(frozen=True)
class FusedOdometryConfig:
    """Noises of wheels and gyro."""

    linear_acceleration: float = param(
        0.4, "Typical change of speed.", unit="m/s^2/sqrt(Hz)", minimum=1e-3
    )
    angular_acceleration: float = param(
        0.4, "Typical change of turn rate.", unit="rad/s^2/sqrt(Hz)", minimum=1e-3
    )
    wheel_speed_noise: float = param(
        0.01, "Standard deviation of the wheels' speed, per speed.", minimum=1e-4
    )
    wheel_turn_noise: float = param(
        0.1, "Standard deviation of the wheels' turn rate, per turn rate.", minimum=1e-4
    )
    rest_noise: float = param(
        2e-4,
        "Standard deviation of speed and turn rate that wheels measure at rest.",
        unit="m/s, rad/s",
        minimum=1e-5,
    )
    gyro_noise: float = yaw_rate_param(
        0.002, "Standard deviation of the gyro where its message has none.", minimum=1e-6
    )
    rest_speed: float = param(
        1e-3,
        "Speed and turn rate below which the wheels are at rest.",
        unit="m/s, rad/s",
        minimum=0.0,
        maximum=0.1,
    )
    sliding_rate: float = yaw_rate_param(
        0.05,
        "Turn rate of the gyro above which a robot whose wheels rest is being moved.",
        maximum=10.0,
    )
    rest_time: float = duration_param(
        0.5,
        "The robot is at rest once the wheels have stood so long and the gyro only had noise.",
        minimum=0.1,
        maximum=10.0,
    )
    bias_noise: float = yaw_rate_param(0.01, "Standard deviation of the gyro's bias at the start.")
    bias_walk: float = param(1e-5, "Growth of the gyro's bias.", unit="rad/s/sqrt(s)", minimum=0.0)


class FusedOdometry:
    """An extended Kalman filter over pose, speed ahead and to the left, turn rate and gyro's bias.

    Speeds and turn rate are driven by white accelerations. At rest what the gyro says is its bias,
    which is learnt then alone and else only considered. A robot whose wheels stand may still slide
    or rock: it is at rest when the gyro has varied no more than its noise for a while.

    Source: Thrun, Burgard and Fox, Probabilistic Robotics, 2005, section 3.3; considered states:
    Schmidt, Application of state-space methods to navigation problems, 1966; two hypotheses of the
    bias: Magill, Optimal adaptive estimation of sampled stochastic processes, 1965.
    """

    def __init__(self, config: FusedOdometryConfig) -> None:
        self.config = config
        self._state = np.zeros(_SIZE)
        self._covariance = np.zeros((_SIZE, _SIZE))
        self._covariance[_BIAS, _BIAS] = config.bias_noise**2
        self._stands = False  # by the wheels
        self._at_rest = False  # by wheels and gyro
        self._time = 0.0  # since the start [s]
        self._rates: deque[tuple[float, float]] = deque()  # times and rates since the wheels stand
        self._gyro_came = False  # a gyro has come since the wheels

    @property
    def bias(self) -> float:
        """Of the gyro [rad/s]."""
        return float(self._state[_BIAS])

    @property
    def estimate(self) -> OdometryEstimate:
        """The estimate by wheels and gyro."""
        x, y, theta, v, side, w, _ = self._state.tolist()
        pose = self._covariance[:3, :3].copy()
        twist = float(self._covariance[_V, _V]), float(self._covariance[_W, _W])
        return OdometryEstimate(SE2(x, y, theta), v, w, pose, twist, side)

    def predict(self, dt: float) -> None:
        """Advance by a time [s] along the arc of the present speeds and turn rate."""
        if dt <= 0.0:
            return
        self._time += dt
        config = self.config
        _predict(
            self._state,
            self._covariance,
            dt,
            config.linear_acceleration**2,
            config.angular_acceleration**2,
            config.bias_walk**2,
        )

    def wheels(self, v: float, w: float, side: float = 0.0) -> None:
        """Take what the wheels' encoders say.

        Wheels err by slip, which lasts: their turn rate counts only at rest, where it is exact and
        shows the gyro's bias, and where no gyro has come since the last call.

        Args:
            v: Speed ahead [m/s].
            w: Turn rate [rad/s].
            side: Speed to the left, 0 of a base that cannot [m/s].
        """
        config = self.config
        variance = config.rest_noise**2 + config.wheel_speed_noise**2 * (v * v + side * side)
        self._measure(_V, 0.0, v, variance)
        self._measure(_SIDE, 0.0, side, variance if side else config.rest_noise**2)
        if not self._gyro_came:
            self._measure(_W, 0.0, w, config.rest_noise**2 + (config.wheel_turn_noise * w) ** 2)
        self._stands, self._gyro_came = max(abs(v), abs(w), abs(side)) < config.rest_speed, False
        if not self._stands:
            self._rates.clear()
            self._at_rest = False

    def gyro(self, rate: float, variance: float = 0.0) -> None:
        """Take a turn rate [rad/s] of the gyro, of a variance [rad^2/s^2] if it has one."""
        noise = variance if variance > 0.0 else self.config.gyro_noise**2
        self._at_rest = self._stands and self._rests(rate, noise)
        if self._at_rest:
            self._measure(_W, 0.0, 0.0, self.config.rest_noise**2)
        self._measure(_W, 1.0, rate + self._unlikely_bias(), noise)
        self._gyro_came = True

    def _unlikely_bias(self) -> float:
        """Return the part of the bias that a moving robot's rates are not rid of.

        Most gyros were rid of theirs before: it began at 0 and only walked since, or it is any of
        `bias_noise`. What rests have shown is a measurement under either.
        """
        if self._at_rest:
            return 0.0
        bias, known = float(self._state[_BIAS]), float(self._covariance[_BIAS, _BIAS])
        walked = self.config.bias_walk**2 * self._time
        calm, any_ = known + walked, known + self.config.bias_noise**2
        if calm <= 0.0 or any_ <= 0.0:
            return 0.0
        log_odds = bias * bias / 2 * (1 / any_ - 1 / calm) + math.log(any_ / calm) / 2
        probability = 0.5 + 0.5 * math.tanh(log_odds / 2)  # that it began at 0
        return bias * (1.0 - walked / calm) * probability

    def _rests(self, rate: float, noise: float) -> bool:
        """Take a gyro's rate [rad/s] while the wheels stand; return whether the robot does, too."""
        rates, period = self._rates, self.config.rest_time
        rates.append((self._time, rate))
        while len(rates) > 2 and rates[1][0] <= self._time - period:
            rates.popleft()
        if len(rates) < 3 or self._time - rates[0][0] < period:
            return False
        mean = sum(value for _, value in rates) / len(rates)
        spread = sum((value - mean) ** 2 for _, value in rates) / (len(rates) - 1)
        is_bias = abs(mean - float(self._state[_BIAS])) < self.config.sliding_rate
        # The sample variance of a gyro at rest scatters about its noise's; twice that is motion.
        return is_bias and spread < 2.0 * noise

    def _measure(self, index: int, bias: float, value: float, variance: float) -> None:
        """Correct by one number that measures a state, plus a share of the gyro's bias."""
        at_rest = self._at_rest
        _correct(self._state, self._covariance, index, bias, value, variance, at_rest)


@njit(cache=True)
def _predict(
    state: Floats, covariance: Floats, dt: float, linear: float, angular: float, walk: float
) -> None:
    """Bring state and covariance to a time later (`bench sim`: 30 us of a tick in NumPy).

    Args:
        state: `(7,) float64`, changed in place, as what Numba returns costs 1 us an array.
        covariance: `(7, 7) float64`, changed in place.
        linear: Of the white accelerations ahead and to the left, which are integrated exactly.
        angular: Of the white acceleration about.
        walk: Of the gyro's bias.
    """
    path, left, turn = state[_V] * dt, state[_SIDE] * dt, state[_W] * dt
    middle = state[_THETA] + turn / 2
    c, s = math.cos(middle), math.sin(middle)
    # Below 1e-9 rad sin(x) / x is 1 in double precision.
    chord = math.sin(turn / 2) / (turn / 2) if abs(turn) > 1e-9 else 1.0
    state[_X] += chord * (path * c - left * s)
    state[_Y] += chord * (path * s + left * c)
    state[_THETA] = (state[_THETA] + turn + math.pi) % (2.0 * math.pi) - math.pi
    by_state = np.eye(_SIZE)
    by_state[_X, _THETA], by_state[_Y, _THETA] = -path * s - left * c, path * c - left * s
    by_state[_X, _V], by_state[_Y, _V] = c * dt, s * dt
    by_state[_X, _SIDE], by_state[_Y, _SIDE] = -s * dt, c * dt
    by_state[_X, _W] = by_state[_X, _THETA] * dt / 2
    by_state[_Y, _W] = by_state[_Y, _THETA] * dt / 2
    by_state[_THETA, _W] = dt
    _frame(by_state, covariance)
    along = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    for k in range(3):
        power = linear if k < 2 else angular
        for i in range(3):
            for j in range(3):
                covariance[i, j] += power * dt**3 / 3 * along[k, i] * along[k, j]
            covariance[i, _V + k] += power * dt**2 / 2 * along[k, i]
            covariance[_V + k, i] += power * dt**2 / 2 * along[k, i]
        covariance[_V + k, _V + k] += power * dt
    covariance[_BIAS, _BIAS] += walk * dt


@njit(cache=True)
def _correct(
    state: Floats,
    covariance: Floats,
    index: int,
    bias: float,
    value: float,
    variance: float,
    at_rest: bool,
) -> None:
    """Correct state and covariance by one number that measures a state, plus some of the bias."""
    row = np.zeros(_SIZE)
    row[index], row[_BIAS] = 1.0, bias
    gain = covariance[:, index] + bias * covariance[:, _BIAS]
    gain /= gain[index] + bias * gain[_BIAS] + variance
    if at_rest:
        gain[:_V] = 0.0  # one rest says too little of the bias to turn the past by it
    else:
        gain[_BIAS] = 0.0  # a push or a bump is no bias; Joseph's form takes any gain
    state += gain * (value - state[index] - bias * state[_BIAS])
    state[_THETA] = (state[_THETA] + math.pi) % (2.0 * math.pi) - math.pi
    rest = np.eye(_SIZE)
    for i in range(_SIZE):
        for j in range(_SIZE):
            rest[i, j] -= gain[i] * row[j]
    _frame(rest, covariance)
    for i in range(_SIZE):
        for j in range(_SIZE):
            covariance[i, j] += variance * gain[i] * gain[j]


@njit(cache=True)
def _frame(frame: Floats, inner: Floats) -> None:
    """Make `inner` into `frame @ inner @ frame.T`, all `(7, 7) float64`."""
    half = np.zeros((_SIZE, _SIZE))
    for i in range(_SIZE):
        for k in range(_SIZE):
            if frame[i, k] != 0.0:
                for j in range(_SIZE):
                    half[i, j] += frame[i, k] * inner[k, j]
    inner[:] = 0.0
    for j in range(_SIZE):
        for k in range(_SIZE):
            if frame[j, k] != 0.0:
                for i in range(_SIZE):
                    inner[i, j] += half[i, k] * frame[j, k]
