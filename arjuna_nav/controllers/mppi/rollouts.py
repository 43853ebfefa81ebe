"""MPPI's rollouts: where noisy controls take the robot.

Arrays are `(steps, batch) float32`, so that the inner loops run along the batch and are vectorized.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from arjuna_core.arrays import Singles

Array = Singles
_F = np.float32


class Rollouts(NamedTuple):
    """Motions of all rollouts, seen from the robot's present pose.

    Attributes:
        v: Speeds [m/s].
        w: Yaw rates [rad/s].
        x: Positions ahead [m].
        y: Positions to the left [m].
        yaw: Headings [rad], not wrapped.
        side: Speeds to the left [m/s]; `(0, 0)` of a robot that does not drive sideways.
    """

    v: Array
    w: Array
    x: Array
    y: Array
    yaw: Array
    side: Array


class Limits(NamedTuple):
    """Limits of the drive.

    Attributes:
        v_min: Least forward speed [m/s].
        v_max: Greatest [m/s].
        w_max: Greatest yaw rate [rad/s].
        accel: Gain of speed [m/s^2].
        decel: Loss of speed [m/s^2].
        accel_w: Change of the yaw rate [rad/s^2].
        side_max: Greatest speed to either side [m/s].
        side_accel: Gain of speed to the left [m/s^2].
        side_decel: Gain of speed to the right [m/s^2].
        radius: Least turning radius [m].
    """

    v_min: float
    v_max: float
    w_max: float
    accel: float
    decel: float
    accel_w: float
    side_max: float = 0.0
    side_accel: float = 0.0
    side_decel: float = 0.0
    radius: float = 0.0


def empty_rollouts(steps: int, batch: int, holonomic: bool) -> Rollouts:
    """Return room for rollouts."""
    shapes = [(steps, batch)] * 5 + [(steps, batch) if holonomic else (0, 0)]
    return Rollouts(*(np.zeros(shape, np.float32) for shape in shapes))


@njit(cache=True, fastmath=True)
def correlated(white: Array, keep: float, deviation: float) -> Array:
    """Return noise of a deviation whose steps keep a part, 0 to 1, of the step before."""
    result = np.empty_like(white)
    part, fresh = _F(keep), _F(math.sqrt(1.0 - keep * keep) * deviation)
    for b in range(white.shape[1]):
        result[0, b] = _F(deviation) * white[0, b]
    for t in range(1, white.shape[0]):
        for b in range(white.shape[1]):
            result[t, b] = part * result[t - 1, b] + fresh * white[t, b]
    return result


@njit(cache=True, fastmath=True)
def add_noise(sequence: Array, noise: Array, out: Array) -> None:
    """Write controls `(steps,)` plus noise `(steps, batch)`; limits come with the rollout."""
    for t in range(noise.shape[0]):
        for b in range(noise.shape[1]):
            out[t, b] = sequence[t] + noise[t, b]


@njit(cache=True, fastmath=True)
def roll_out(
    controls_v: Array,
    controls_w: Array,
    controls_side: Array,
    now: tuple[float, float, float],
    limits: Limits,
    dt: float,
    out: Rollouts,
) -> None:
    """Write where controls take the robot that now drives forward, to the left and turns so.

    A step's velocity is the control before it, as near as the limits allow. Headings turn by
    a polynomial of sine and cosine a step, exact to 1e-7. Each loop has a few rows alone, or the
    compiler does not vectorize it (`bench controller` times a command).
    """
    steps, batch = controls_v.shape
    v0, side0, w0 = now
    step, turn = _F(dt), _F(limits.accel_w * dt)
    up, down = _F(limits.accel * dt), _F(limits.decel * dt)
    left, right = _F(limits.side_accel * dt), _F(limits.side_decel * dt)
    v_min, v_max, w_max = _F(limits.v_min), _F(limits.v_max), _F(limits.w_max)
    side_max, radius = _F(limits.side_max), _F(limits.radius)
    v, w, x, y, yaw, side = out
    v[0], w[0], y[0] = _F(v0), _F(w0), _F(0.0)
    yaw[0], x[0] = _F(w0) * step, _F(v0) * step
    if len(side):
        side[0], y[0] = _F(side0), _F(side0) * step
    c, s = np.empty(batch, np.float32), np.empty(batch, np.float32)
    c[:], s[:] = _F(math.cos(w0 * dt)), _F(math.sin(w0 * dt))
    for t in range(1, steps):
        _limited(controls_v[t - 1], v[t - 1], v_min, v_max, down, up, v[t])
        _limited(controls_w[t - 1], w[t - 1], -w_max, w_max, turn, turn, w[t])
        if radius > _F(0.0):
            _bowed(v[t], radius, w[t])
        _moved(x[t - 1], v[t], c, step, x[t])
        _moved(y[t - 1], v[t], s, step, y[t])
        if len(side):
            _limited(controls_side[t - 1], side[t - 1], -side_max, side_max, right, left, side[t])
            _moved(x[t], side[t], s, -step, x[t])
            _moved(y[t], side[t], c, step, y[t])
        _turned(yaw[t - 1], w[t], step, yaw[t])
        _rotated(w[t], step, c, s)


@njit(cache=True, fastmath=True)
def _bowed(speeds: Array, radius: float, rates: Array) -> None:
    """Limit the yaw rates to what a turning radius allows at each speed."""
    for b in range(len(rates)):
        most = abs(speeds[b]) / radius
        rates[b] = min(max(rates[b], -most), most)


@njit(cache=True, fastmath=True)
def _limited(
    controls: Array, last: Array, low: float, high: float, down: float, up: float, out: Array
) -> None:
    """Write controls as near as limits and the steps from the last velocities allow."""
    for b in range(len(out)):
        within = min(max(controls[b], low), high)
        out[b] = min(max(within, last[b] - down), last[b] + up)


@njit(cache=True, fastmath=True)
def _moved(last: Array, speeds: Array, along: Array, step: float, out: Array) -> None:
    """Write one coordinate of the positions after a step."""
    for b in range(len(out)):
        out[b] = last[b] + speeds[b] * step * along[b]


@njit(cache=True, fastmath=True)
def _turned(last: Array, rates: Array, step: float, out: Array) -> None:
    """Write the headings after a step."""
    for b in range(len(out)):
        out[b] = last[b] + rates[b] * step


@njit(cache=True, fastmath=True)
def _rotated(rates: Array, step: float, c: Array, s: Array) -> None:
    """Turn the headings' cosines and sines by a step."""
    half, one = _F(0.5), _F(1.0)
    sixth, twenty_fourth, a120 = _F(1.0 / 6.0), _F(1.0 / 24.0), _F(1.0 / 120.0)
    for b in range(len(c)):
        angle = rates[b] * step
        square = angle * angle
        sine = angle * (one - square * (sixth - square * a120))
        cosine = one - square * (half - square * twenty_fourth)
        c[b], s[b] = c[b] * cosine - s[b] * sine, s[b] * cosine + c[b] * sine


@njit(cache=True, fastmath=True)
def weigh(costs: Array, controls: Array, sequence: Array, smoothness: float) -> None:
    """Add to the costs how much controls stray from the sequence, `smoothness` a square."""
    weight = _F(smoothness)
    for t in range(controls.shape[0]):
        factor = weight * sequence[t]
        for b in range(controls.shape[1]):
            costs[b] += factor * (controls[t, b] - sequence[t])


@njit(cache=True, fastmath=True)
def average(weights: Array, controls: Array) -> Array:
    """Return the weighted mean of controls, `(steps,)`; the weights' sum is 1."""
    result = np.zeros(controls.shape[0], np.float32)
    for t in range(controls.shape[0]):
        total = _F(0.0)
        for b in range(controls.shape[1]):
            total += weights[b] * controls[t, b]
        result[t] = total
    return result
