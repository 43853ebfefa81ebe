"""MPPI's sequence of controls: sampled round, weighed, averaged, smoothed."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numba import njit
from numpy.typing import NDArray

from arjuna_core.twist import Velocity
from arjuna_nav.controllers.mppi.config import MppiConfig
from arjuna_nav.controllers.mppi.rollouts import (
    Array,
    Limits,
    Rollouts,
    add_noise,
    average,
    correlated,
    empty_rollouts,
    roll_out,
    weigh,
)

_SMOOTHING = np.array([-21, 14, 39, 54, 59, 54, 39, 14, -21]) / 231.0
"""Savitzky and Golay's quadratic of nine points."""
_HISTORY = 4  # commands sent, which the smoothing looks back on: half of its nine points
_SPARE = 3  # times as many noises as a batch takes: each tick draws a window of them
Judge = Callable[[Rollouts], tuple[Array, bool]]
"""Returns each rollout's cost, and whether all collide."""


class Optimizer:
    """Keeps the best controls found and makes them better.

    Source: Williams, Drews, Goldfain, Rehg and Theodorou, Aggressive driving with model predictive
        path integral control, ICRA 2016; nav2_mppi_controller. The noise is correlated in time as
        in Vlahov et al., Low frequency sampling in model predictive path integral control, 2024:
        of white noise little is left where the accelerations are small.
    """

    def __init__(self, config: MppiConfig) -> None:
        self._config = config
        steps, batch = config.time_steps, config.batch_size
        self._rng = np.random.default_rng(config.seed)
        columns = batch * (_SPARE if config.regenerate_noises else 1)
        white = self._rng.standard_normal((2, steps, columns), dtype=np.float32)
        keep = math.exp(-config.model_dt / config.noise_time) if config.noise_time else 0.0
        self._gamma = config.gamma * (1.0 - keep) / (1.0 + keep)  # slow changes are likelier
        self._noise_v = correlated(white[0], keep, config.vx_std)
        self._noise_w = correlated(white[1], keep, config.wz_std)
        self._controls_v = np.empty((steps, batch), np.float32)
        self._controls_w = np.empty((steps, batch), np.float32)
        self.rollouts = empty_rollouts(steps, batch)
        self.reset()

    def reset(self) -> None:
        """Forget the controls found."""
        steps = self._config.time_steps
        self.v, self.w = np.zeros(steps, np.float32), np.zeros(steps, np.float32)
        self._history = np.zeros((_HISTORY, 2))

    def improve(self, velocity: Velocity, limits: Limits, judge: Judge) -> bool:
        """Make the controls better; return False where every rollout collides."""
        for _ in range(self._config.iteration_count):
            self._sample(velocity, limits)
            costs, blocked = judge(self.rollouts)
            if blocked:
                return False
            self._update(costs)
        self._smooth(limits)
        return True

    def _sample(self, velocity: Velocity, limits: Limits) -> None:
        """Roll out noisy controls."""
        config, noise_v, noise_w = self._config, self._noise_v, self._noise_w
        batch = config.batch_size
        if config.regenerate_noises:  # a window of the spare noise: new noise would cost more
            at_v, at_w = self._rng.integers((_SPARE - 1) * batch, size=2)
            noise_v = np.ascontiguousarray(noise_v[:, at_v : at_v + batch])
            noise_w = np.ascontiguousarray(noise_w[:, at_w : at_w + batch])
        add_noise(self.v, noise_v, self._controls_v)
        add_noise(self.w, noise_w, self._controls_w)
        roll_out(
            self._controls_v,
            self._controls_w,
            velocity.x,
            velocity.yaw_rate,
            limits,
            config.model_dt,
            self.rollouts,
        )

    def _update(self, costs: Array) -> None:
        """Average the controls by their costs."""
        config = self._config
        for controls, sequence, std in (
            (self._controls_v, self.v, config.vx_std),
            (self._controls_w, self.w, config.wz_std),
        ):
            weigh(costs, controls, sequence, self._gamma / std**2)
        weights = np.exp((costs.min() - costs) / np.float32(config.temperature))
        weights /= weights.sum()
        self.v = average(weights, self._controls_v)
        self.w = average(weights, self._controls_w)

    def _smooth(self, limits: Limits) -> None:
        """Fit the controls, those driven before among them, by a running quadratic."""
        self.v = _smoothed(self._history[:, 0], self.v, limits.v_min, limits.v_max)
        self.w = _smoothed(self._history[:, 1], self.w, -limits.w_max, limits.w_max)

    def advance(self, time: float) -> Velocity:
        """Return the controls a time [s] ahead, and move on by it."""
        steps = time / self._config.model_dt
        self.v, self.w = _later(self.v, steps), _later(self.w, steps)
        command = Velocity(float(self.v[0]), yaw_rate=float(self.w[0]))
        self._history[:-1] = self._history[1:]
        self._history[-1] = command.x, command.yaw_rate
        return command


@njit(cache=True)
def _smoothed(before: NDArray[np.float64], values: Array, low: float, high: float) -> Array:
    """Return values by a running quadratic, within limits; their last one repeats."""
    result, count = np.empty_like(values), len(values)
    for i in range(count):
        total = 0.0
        for k in range(len(_SMOOTHING)):
            j = i + k - _HISTORY
            value = before[j] if j < 0 else values[min(j, count - 1)]
            total += _SMOOTHING[k] * value
        result[i] = min(max(total, low), high)
    return result


@njit(cache=True)
def _later(values: Array, steps: float) -> Array:
    """Return the values so many steps on, linear between them; the last one repeats."""
    result, last = np.empty_like(values), len(values) - 1
    whole = math.floor(steps)
    part = steps - whole
    for i in range(len(values)):
        j = i + whole
        value = values[min(j, last)]
        result[i] = value + part * (values[min(j + 1, last)] - value)
    return result
