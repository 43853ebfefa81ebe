"""Resampling: which particles survive, and how many the spread of the belief asks for."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from arjuna_core.se2 import wrap

BIN_SIZE = np.array([0.5, 0.5, math.radians(10.0)])
HEADING_BINS = 36
_OFFSET = 1 << 20  # keeps bin indices positive up to 500 km from the origin


def bin_codes(particles: NDArray[np.float64]) -> NDArray[np.int64]:
    """Return the histogram bin of each particle `(N, 3)` as one number, `(N,) int64`.

    Bins measure 0.5 m x 0.5 m x 10 degrees, as nav2_amcl's.
    """
    bins = np.floor(particles / BIN_SIZE).astype(np.int64)
    headings = np.floor((wrap(particles[:, 2]) + math.pi) / BIN_SIZE[2]).astype(np.int64)
    return encode(bins[:, 0], bins[:, 1], headings)


def encode(
    x: NDArray[np.int64], y: NDArray[np.int64], heading: NDArray[np.int64]
) -> NDArray[np.int64]:
    """Pack bin indices, each `(N,) int64`, into one number a bin; headings are taken modulo 36."""
    return ((x + _OFFSET) << 30) + ((y + _OFFSET) << 6) + heading % HEADING_BINS


def decode(
    codes: NDArray[np.int64],
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
    """Undo `encode`."""
    return (codes >> 30) - _OFFSET, ((codes >> 6) & 0xFFFFFF) - _OFFSET, codes & 0x3F


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
    total = np.cumsum(weights)
    positions = (rng.random() + np.arange(count)) * (total[-1] / count)
    found = np.searchsorted(total, positions, side="right")
    indices: NDArray[np.int64] = np.minimum(found, len(weights) - 1)
    return indices


def kld_resample(
    particles: NDArray[np.float64],
    weights: NDArray[np.float64],
    limits: tuple[float, float, int, int],
    rng: np.random.Generator,
) -> NDArray[np.float64]:
    """Draw as many particles as the belief's spread needs.

    A full-size draw finds the bins that matter, then one of the size they call for is made, so
    that the low-variance property holds for what is kept.

    Args:
        particles: `(N, 3) float64` [m, m, rad].
        weights: `(N,) float64`, not all zero.
        limits: `error, z, minimum, maximum` of `kld_count`.
        rng: Source of chance.

    Returns:
        `(M, 3) float64`.
    """
    error, z, minimum, maximum = limits
    trial = low_variance_indices(weights, maximum, rng)
    survivors = trial[np.diff(trial, prepend=-1) > 0]  # indices come in order
    bins = len(np.unique(bin_codes(particles[survivors])))
    count = kld_count(bins, error, z, minimum, maximum)
    return particles[low_variance_indices(weights, count, rng)]
