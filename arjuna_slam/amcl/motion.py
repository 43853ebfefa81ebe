"""Motion models: how odometry moves particles, and how surely."""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from arjuna_core.se2 import SE2, wrap
from arjuna_slam.amcl.config import DIFFERENTIAL, AmclConfig

_TURN_ONLY_BELOW = 0.01  # shorter moves have no direction worth trusting [m]


class MotionModel(Protocol):
    """Moves particles by a noisy step of odometry."""

    def sample(
        self, particles: NDArray[np.float64], delta: SE2, rng: np.random.Generator
    ) -> NDArray[np.float64]:
        """Return new particles `(N, 3)` [m, m, rad], each moved by a draw around `delta`.

        Args:
            particles: `(N, 3) float64` [m, m, rad].
            delta: Motion since the last step in the robot's frame before it.
            rng: Source of chance.
        """


class DifferentialMotion:
    """Turn, drive, turn: for robots that cannot move sideways.

    Source: Thrun, Burgard, Fox, Probabilistic Robotics, 2005, table 5.6, with nav2_amcl's noise
    that treats driving backwards as forwards.
    """

    def __init__(self, config: AmclConfig) -> None:
        self._config = config

    def sample(
        self, particles: NDArray[np.float64], delta: SE2, rng: np.random.Generator
    ) -> NDArray[np.float64]:
        """See `MotionModel.sample`."""
        a = self._config
        length = math.hypot(delta.x, delta.y)
        turn1 = math.atan2(delta.y, delta.x) if length >= _TURN_ONLY_BELOW else 0.0
        turn2 = wrap(delta.theta - turn1)
        noise1, noise2 = _turn_or_reverse(turn1), _turn_or_reverse(turn2)
        deviations = np.sqrt(
            [
                a.alpha1 * noise1**2 + a.alpha2 * length**2,
                a.alpha3 * length**2 + a.alpha4 * (noise1**2 + noise2**2),
                a.alpha1 * noise2**2 + a.alpha2 * length**2,
            ]
        )
        means = np.array([turn1, length, turn2])
        first, drive, second = (means + deviations * rng.standard_normal((len(particles), 3))).T
        heading = particles[:, 2] + first
        return np.column_stack(
            (
                particles[:, 0] + drive * np.cos(heading),
                particles[:, 1] + drive * np.sin(heading),
                wrap(heading + second),
            )
        )


class OmnidirectionalMotion:
    """Translate in any direction and turn: nav2_amcl's OmniMotionModel."""

    def __init__(self, config: AmclConfig) -> None:
        self._config = config

    def sample(
        self, particles: NDArray[np.float64], delta: SE2, rng: np.random.Generator
    ) -> NDArray[np.float64]:
        """See `MotionModel.sample`."""
        a = self._config
        length, turn = math.hypot(delta.x, delta.y), wrap(delta.theta)
        deviations = np.sqrt(
            [
                a.alpha3 * length**2 + a.alpha1 * turn**2,
                a.alpha5 * length**2 + a.alpha1 * turn**2,
                a.alpha4 * turn**2 + a.alpha2 * length**2,
            ]
        )
        means = np.array([length, 0.0, turn])
        ahead, left, rotation = (means + deviations * rng.standard_normal((len(particles), 3))).T
        bearing = particles[:, 2] + math.atan2(delta.y, delta.x)
        c, s = np.cos(bearing), np.sin(bearing)
        return np.column_stack(
            (
                particles[:, 0] + ahead * c - left * s,
                particles[:, 1] + ahead * s + left * c,
                wrap(particles[:, 2] + rotation),
            )
        )


def make_motion(config: AmclConfig) -> MotionModel:
    """Return the motion model that the configuration names."""
    if config.robot_model_type == DIFFERENTIAL:
        return DifferentialMotion(config)
    return OmnidirectionalMotion(config)


def _turn_or_reverse(angle: float) -> float:
    """Return how far an angle is from straight ahead or straight back, whichever is less."""
    return min(abs(wrap(angle)), abs(wrap(angle - math.pi)))
