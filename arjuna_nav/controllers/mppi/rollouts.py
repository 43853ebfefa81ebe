"""MPPI's rollouts: where noisy controls take the robot.

Arrays are `(steps, batch) float32`, so that the inner loops run along the batch and are vectorized.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float32]
_F = np.float32


class Rollouts(NamedTuple):
    """Motions of all rollouts, seen from the robot's present pose.

    Attributes:
        v: Speeds [m/s].
        w: Yaw rates [rad/s].
        x: Positions ahead [m].
        y: Positions to the left [m].
        yaw: Headings [rad], not wrapped.
    """

    v: Array
    w: Array
    x: Array
    y: Array
    yaw: Array


class Limits(NamedTuple):
    """Limits of the drive."""

    v_min: float
    v_max: float
    w_max: float
    accel: float
    decel: float
    accel_w: float


def empty_rollouts(steps: int, batch: int) -> Rollouts:
    """Return room for rollouts."""
    return Rollouts(*(np.zeros((steps, batch), np.float32) for _ in range(5)))


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
    v0: float,
    w0: float,
    limits: Limits,
    dt: float,
    out: Rollouts,
) -> None:
    r"""Write where controls take the robot that now drives `(v0, w0)`.

    A step's velocity is the control before it, as near as the limits allow. Headings turn by
    a polynomial of sine and cosine a step, exact to 1e-7. Each loop has a few rows alone, or the
    compiler does not vectorize it (`bench controller` times a command).
    """
    steps, batch = controls_v.shape
    step, turn = _F(dt), _F(limits.accel_w * dt)
    up, down = _F(limits.accel * dt), _F(limits.decel * dt)
    v_min, v_max, w_max = _F(limits.v_min), _F(limits.v_max), _F(limits.w_max)
    v, w, x, y, yaw = out
    v[0], w[0], y[0] = _F(v0), _F(w0), _F(0.0)
    yaw[0], x[0] = _F(w0) * step, _F(v0) * step
    c, s = np.empty(batch, np.float32), np.empty(batch, np.float32)
    c[:], s[:] = _F(math.cos(w0 * dt)), _F(math.sin(w0 * dt))
    for t in range(1, steps):
        _limited(controls_v[t - 1], v[t - 1], v_min, v_max, down, up, v[t])
        _limited(controls_w[t - 1], w[t - 1], -w_max, w_max, turn, turn, w[t])
        _moved(x[t - 1], v[t], c, step, x[t])
        _moved(y[t - 1], v[t], s, step, y[t])
        _turned(yaw[t - 1], w[t], step, yaw[t])
        _rotated(w[t], step, c, s)


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
def weigh(
    costs: Array,
    controls: Array,
    sequence: Array,
    smoothness: float,
) -> None:
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
