"""Random errors of sensors."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray


class BiasedNoise:
    """White noise on a bias that walks.

    Args:
        rng: Where the noise comes from.
        size: Number of channels.
        sigma: Standard deviation of each reading.
        walk: Growth of the bias' standard deviation [per root second].
    """

    def __init__(self, rng: np.random.Generator, size: int, sigma: float, walk: float) -> None:
        self._rng = rng
        self._sigma = sigma
        self._walk = walk
        self.bias: NDArray[np.float64] = np.zeros(size)

    def sample(self, dt: float) -> NDArray[np.float64]:
        """Return the error of the next reading, `(size,) float64`, `dt` [s] after the last."""
        size = len(self.bias)
        draws = self._rng.standard_normal(2 * size)
        self.bias = self.bias + self._walk * math.sqrt(dt) * draws[:size]
        return self.bias + self._sigma * draws[size:]
