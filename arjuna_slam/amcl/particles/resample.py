"""Resampling: which particles survive, and how many the spread of the belief asks for."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray


def kld_count(bins: int, error: float, z: float, minimum: int, maximum: int) -> int:
    """Return how many particles a belief that occupies `bins` bins needs.

    Args:
        bins: Number of occupied histogram bins.
        error: Bound on the Kullback-Leibler distance.
        z: Quantile of the standard normal distribution.
        minimum: Least count.
        maximum: Greatest count.

    Source: Fox, Adapting the sample size in particle filters through KLD-sampling, 2003, eq. 7.
    """
    if bins <= 1:
        return minimum
    a = 2.0 / (9.0 * (bins - 1))
    count = math.ceil((bins - 1) / (2.0 * error) * (1.0 - a + math.sqrt(a) * z) ** 3)
    return max(minimum, min(count, maximum))


def low_variance_indices(
    weights: NDArray[np.float64], count: int, rng: np.random.Generator
) -> NDArray[np.int64]:
    """Draw indices `(count,) int64` in proportion to weights `(N,)` by one random offset.

    Source: Thrun, Burgard, Fox, Probabilistic Robotics, 2005, table 4.4.
    """
    return _walk(weights, float(weights.sum()), count, rng.random())


def kld_indices(
    weights: NDArray[np.float64],
    bin_of: NDArray[np.int32],
    limits: tuple[float, float, int, int],
    rng: np.random.Generator,
) -> NDArray[np.int64]:
    """Draw as many particles as the belief's spread needs.

    A full-size draw finds the bins that matter, then one of the size they call for is made, so
    that the low-variance property holds for what is kept.

    Args:
        weights: `(N,) float64`, not all zero.
        bin_of: Each particle's bin, `(N,) int32`.
        limits: `error, z, minimum, maximum` of `kld_count`.
        rng: Source of randomness.

    Returns:
        Indices of what is kept, ascending, `(M,) int64`.
    """
    error, z, minimum, maximum = limits
    trial = low_variance_indices(weights, maximum, rng)
    drawn = np.zeros(int(bin_of.max()) + 1, bool)
    drawn[bin_of[trial]] = True
    count = kld_count(int(drawn.sum()), error, z, minimum, maximum)
    return trial if count == maximum else low_variance_indices(weights, count, rng)


def effective_count(weights: NDArray[np.float64]) -> float:
    """Return how many particles of equal weight would carry as much, 1 to N.

    Source: Grisetti et al., Improved techniques for grid mapping with Rao-Blackwellized particle
    filters, 2007, section IV-B.
    """
    return float(weights.sum() ** 2 / (weights @ weights))


@njit(cache=True)
def _walk(
    weights: NDArray[np.float64], total: float, count: int, offset: float
) -> NDArray[np.int64]:
    """Return at which particle each of `count` even steps through the weights ends."""
    indices = np.empty(count, np.int64)
    step = total / count
    last = len(weights) - 1
    while last > 0 and weights[last] == 0.0:  # rounding must not end on one without weight
        last -= 1
    i, reached = 0, weights[0]
    for k in range(count):
        position = (k + offset) * step
        while reached <= position and i < last:
            i += 1
            reached += weights[i]
        indices[k] = i
    return indices
