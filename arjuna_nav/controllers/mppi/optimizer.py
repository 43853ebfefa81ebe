"""MPPI's sequence of controls: sampled round, weighed, averaged, smoothed."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numba import njit

from arjuna_core.arrays import Floats
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


_NO_CONTROLS = np.empty((0, 0), np.float32)


@dataclass
class _Axis:
    """One part of the velocity: its noise, what is tried, what was found and what was driven."""

    noise: Array
    deviation: float
    controls: Array
    sequence: Array = field(default_factory=lambda: np.empty(0, np.float32))
    history: Floats = field(default_factory=lambda: np.empty(0))


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
        holonomic = config.motion_model == "Omni"
        deviations = [
            max(each, 1e-3)  # the weight of a change is per square of it
            for each in (config.vx_std, config.wz_std, config.vy_std)[: 3 if holonomic else 2]
        ]
        white = self._rng.standard_normal((len(deviations), steps, columns), dtype=np.float32)
        keep = math.exp(-config.model_dt / config.noise_time) if config.noise_time else 0.0
        self._gamma = config.gamma * (1.0 - keep) / (1.0 + keep)  # slow changes are likelier
        self._axes = [
            _Axis(
                correlated(each, keep, deviation), deviation, np.empty((steps, batch), np.float32)
            )
            for each, deviation in zip(white, deviations, strict=True)
        ]
        self.rollouts = empty_rollouts(steps, batch, holonomic)
        self.reset()

    @property
    def controls(self) -> Array:
        """The controls found: speeds, yaw rates and, if it drives sideways, speeds to the left."""
        return np.array([axis.sequence for axis in self._axes])

    def reset(self) -> None:
        """Forget the controls found."""
        for axis in self._axes:
            axis.sequence = np.zeros(self._config.time_steps, np.float32)
            axis.history = np.zeros(_HISTORY)

    def improve(self, velocity: Velocity, limits: Limits, judge: Judge) -> bool:
        """Make the controls better; return False where every rollout collides."""
        for _ in range(self._config.iteration_count):
            self._sample(velocity, limits)
            costs, blocked = judge(self.rollouts)
            if blocked:
                return False
            for axis in self._axes:
                weigh(costs, axis.controls, axis.sequence, self._gamma / axis.deviation**2)
            weights = np.exp((costs.min() - costs) / np.float32(self._config.temperature))
            weights /= weights.sum()
            for axis in self._axes:
                axis.sequence = average(weights, axis.controls)
        self._smooth(limits)
        return True

    def _sample(self, velocity: Velocity, limits: Limits) -> None:
        config, batch = self._config, self._config.batch_size
        noises = [axis.noise for axis in self._axes]
        if config.regenerate_noises:  # a window of the spare noise: new noise would cost more
            starts = self._rng.integers((_SPARE - 1) * batch, size=len(noises))
            noises = [
                np.ascontiguousarray(noise[:, at : at + batch])
                for noise, at in zip(noises, starts, strict=True)
            ]
        for axis, noise in zip(self._axes, noises, strict=True):
            add_noise(axis.sequence, noise, axis.controls)
        roll_out(
            self._axes[0].controls,
            self._axes[1].controls,
            self._axes[2].controls if len(self._axes) > 2 else _NO_CONTROLS,
            (float(velocity.x), float(velocity.y), float(velocity.yaw_rate)),
            limits,
            config.model_dt,
            self.rollouts,
        )

    def _smooth(self, limits: Limits) -> None:
        """Fit the controls, those driven before among them, by a running quadratic."""
        bounds = (
            (limits.v_min, limits.v_max),
            (-limits.w_max, limits.w_max),
            (-limits.side_max, limits.side_max),
        )
        for axis, (low, high) in zip(self._axes, bounds, strict=False):
            axis.sequence = _smoothed(axis.history, axis.sequence, low, high)

    def found(self, velocity: Velocity, limits: Limits) -> Rollouts:
        """Return where the controls found take the robot, as one rollout."""
        steps, holonomic = self._config.time_steps, len(self._axes) > 2
        columns = [np.ascontiguousarray(axis.sequence[:, None]) for axis in self._axes]
        rollouts = empty_rollouts(steps, 1, holonomic)
        now = (float(velocity.x), float(velocity.y), float(velocity.yaw_rate))
        side = columns[2] if holonomic else _NO_CONTROLS
        roll_out(columns[0], columns[1], side, now, limits, self._config.model_dt, rollouts)
        return rollouts

    def advance(self, time: float) -> Velocity:
        """Return the controls a time [s] ahead, and move on by it."""
        for axis in self._axes:
            axis.sequence = _later(axis.sequence, time / self._config.model_dt)
            axis.history[:-1] = axis.history[1:]
            axis.history[-1] = axis.sequence[0]
        x, yaw_rate, *side = (float(axis.sequence[0]) for axis in self._axes)
        return Velocity(x, y=side[0] if side else 0.0, yaw_rate=yaw_rate)


@njit(cache=True)
def _smoothed(before: Floats, values: Array, low: float, high: float) -> Array:
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
