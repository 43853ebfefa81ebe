"""Motion models: how odometry moves particles, and how surely."""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np

from arjuna_core.arrays import Floats
from arjuna_core.se2 import SE2, wrap
from arjuna_slam.amcl.config import AmclConfig


class MotionModel(Protocol):
    """Moves particles by a noisy step of odometry."""

    def __call__(
        self, config: AmclConfig, particles: Floats, delta: SE2, rng: np.random.Generator
    ) -> Floats:
        """Return new particles `(N, 3)` [m, m, rad], each moved by a draw around `delta`.

        `delta` is the motion since the last step in the robot's frame before it; columns are
        contiguous.
        """  # fmt: skip


def differential(
    config: AmclConfig, particles: Floats, delta: SE2, rng: np.random.Generator
) -> Floats:
    """Turn, drive, turn: for robots that cannot move sideways; see `MotionModel`.

    Source: Thrun, Burgard, Fox, Probabilistic Robotics, 2005, table 5.6, with nav2_amcl's noise
    that treats driving backwards as forwards.
    """
    a, length = config, math.hypot(delta.x, delta.y)
    least = 0.01  # [m]; shorter moves have no reliable direction
    first = math.atan2(delta.y, delta.x) if length >= least else 0.0
    second = wrap(delta.theta - first)
    noise1, noise2 = _turn_or_reverse(first), _turn_or_reverse(second)
    variances = (
        a.alpha1 * noise1**2 + a.alpha2 * length**2,
        a.alpha3 * length**2 + a.alpha4 * (noise1**2 + noise2**2),
        a.alpha1 * noise2**2 + a.alpha2 * length**2,
    )
    turns, drive, last = _draws((first, length, second), variances, len(particles), rng)
    heading = particles[:, 2] + turns
    return _moved(particles, drive * np.cos(heading), drive * np.sin(heading), heading + last)


def omnidirectional(
    config: AmclConfig, particles: Floats, delta: SE2, rng: np.random.Generator
) -> Floats:
    """Translate in any direction and turn: nav2_amcl's OmniMotionModel; see `MotionModel`."""
    a, length, angle = config, math.hypot(delta.x, delta.y), wrap(delta.theta)
    variances = (
        a.alpha3 * length**2 + a.alpha1 * angle**2,
        a.alpha5 * length**2 + a.alpha1 * angle**2,
        a.alpha4 * angle**2 + a.alpha2 * length**2,
    )
    along, across, angles = _draws((length, 0.0, angle), variances, len(particles), rng)
    bearing = particles[:, 2] + math.atan2(delta.y, delta.x)
    return _moved(particles, *_rotated(along, across, bearing), particles[:, 2] + angles)


def skid_steer(
    config: AmclConfig, particles: Floats, delta: SE2, rng: np.random.Generator
) -> Floats:
    """Drive an arc while the wheels slip; see `MotionModel`.

    Turning errs most, and shifts the base sideways: the centre about which a skid-steer robot
    turns lies somewhere ahead of or behind the middle of its wheels. A turn is one draw, not two
    as in the differential model.

    Source: Mandow et al., Experimental kinematics for wheeled skid-steer mobile robots, IROS 2007.
    """
    a, length, angle = config, math.hypot(delta.x, delta.y), wrap(delta.theta)
    variances = (
        a.alpha3 * length**2 + a.alpha4 * angle**2,
        a.alpha5 * angle**2,
        a.alpha1 * angle**2 + a.alpha2 * length**2,
    )
    along, across, angles = _draws((delta.x, delta.y, angle), variances, len(particles), rng)
    heading = particles[:, 2]
    return _moved(particles, *_rotated(along, across, heading), heading + angles)


def _draws(
    means: tuple[float, float, float],
    variances: tuple[float, float, float],
    count: int,
    rng: np.random.Generator,
) -> Floats:
    draws = rng.standard_normal((3, count))
    draws *= np.sqrt(variances)[:, np.newaxis]
    draws += np.array(means)[:, np.newaxis]
    return draws


def _rotated(x: Floats, y: Floats, angle: Floats) -> tuple[Floats, Floats]:
    c, s = np.cos(angle), np.sin(angle)
    return c * x - s * y, s * x + c * y


def _moved(particles: Floats, x: Floats, y: Floats, heading: Floats) -> Floats:
    result = np.empty(particles.shape, order="F")
    np.add(particles[:, 0], x, out=result[:, 0])
    np.add(particles[:, 1], y, out=result[:, 1])
    result[:, 2] = heading - 2.0 * math.pi * np.floor(heading / (2.0 * math.pi) + 0.5)
    return result


def _turn_or_reverse(angle: float) -> float:
    """Return how far an angle is from straight ahead or straight back, whichever is less."""
    return min(abs(wrap(angle)), abs(wrap(angle - math.pi)))
