"""Resampling: which particles survive, and how many the spread of the belief asks for."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from arjuna_core.arrays import Bools, Floats, Ints
from arjuna_core.se2 import SE2, wrap
from arjuna_slam.amcl.clusters import Cluster, find_clusters, to_bins
from arjuna_slam.amcl.config import MOTION_MODELS, AmclConfig
from arjuna_slam.amcl.estimate import Hypothesis
from arjuna_slam.amcl.motion import MotionModel
from arjuna_slam.matching.map_field import MapField


def kld_count(bins: int, error: float, z: float, minimum: int, maximum: int) -> int:
    """Return the number of particles that a belief in so many histogram bins needs.

    `error` bounds the Kullback-Leibler distance, `z` is a quantile of the normal distribution.

    Source: Fox, Adapting the sample size in particle filters through KLD-sampling, 2003, eq. 7.
    """
    if bins <= 1:
        return minimum
    a = 2.0 / (9.0 * (bins - 1))
    count = math.ceil((bins - 1) / (2.0 * error) * (1.0 - a + math.sqrt(a) * z) ** 3)
    return max(minimum, min(count, maximum))


def low_variance_indices(weights: Floats, count: int, rng: np.random.Generator) -> Ints:
    """Draw indices `(count,) int64` in proportion to weights `(N,)` by one random offset.

    Source: Thrun, Burgard, Fox, Probabilistic Robotics, 2005, table 4.4.
    """
    return _walk(weights, float(weights.sum()), count, rng.random())


def kld_indices(
    weights: Floats,
    bin_of: NDArray[np.int32],
    limits: tuple[float, float, int, int],
    rng: np.random.Generator,
) -> Ints:
    """Return ascending indices `(M,) int64` of as many draws as the belief's spread needs.

    A full-size draw finds the bins that matter, then one of the size they call for is made, so that
    the low-variance property holds for what is kept. `limits` are the last of `kld_count`.
    """
    error, z, minimum, maximum = limits
    trial = low_variance_indices(weights, maximum, rng)
    drawn = np.zeros(int(bin_of.max()) + 1, bool)
    drawn[bin_of[trial]] = True
    count = kld_count(int(drawn.sum()), error, z, minimum, maximum)
    return trial if count == maximum else low_variance_indices(weights, count, rng)


def effective_count(weights: Floats) -> float:
    """Return the number of particles that carry the weights `(N,)`, from 1 to N."""
    return float(weights.sum() ** 2 / (weights @ weights))


def _even(count: int) -> Floats:
    """Return weights `(N,)` of particles that count alike."""
    return np.full(count, 1.0 / count)


@njit(cache=True)
def _walk(weights: Floats, total: float, count: int, offset: float) -> Ints:
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


class Belief:
    """A set of particles.

    Attributes:
        particles: `(N, 3) float64` in the map frame [m, m, rad], columns contiguous.
        weights: `(N,) float64` that sum to 1.
    """

    def __init__(self, config: AmclConfig, field: MapField, rng: np.random.Generator) -> None:
        self._config, self._field, self._rng = config, field, rng
        self._motion: MotionModel = MOTION_MODELS.resolve(config.robot_model_type)
        self._updates = 0
        self._rank_of: Ints | None = None  # of each particle's cluster, when known
        self._tied = np.zeros(0, bool)  # which clusters the last scan fit alike
        self._binned: tuple[NDArray[np.int32], Ints] | None = None
        self.particles: Floats = np.empty((0, 3))
        self.weights: Floats = np.empty(0)

    def spread(self, pose: SE2, root: Floats) -> None:
        """Draw all particles around a pose, `root @ root.T` being the covariance `(3, 3)`."""
        draws = self._rng.standard_normal((self._config.max_particles, 3)) @ root.T
        self._replace(pose.array() + draws)

    def scatter(self) -> None:
        """Draw all particles from the map's free cells."""
        self._replace(self._anywhere(self._config.max_particles))

    def seed(self, hypotheses: list[Hypothesis], covariance: Floats) -> None:
        """Draw all particles around hypotheses, by their shares; a diagonal covariance `(3, 3)`."""
        count = self._config.max_particles
        shares = np.array([one.share for one in hypotheses])
        poses = np.array([one.T_map_base.array() for one in hypotheses])
        centres = poses[low_variance_indices(shares, count, self._rng)]
        draws = self._rng.standard_normal((count, 3)) @ np.sqrt(covariance)
        self._replace(centres + draws)

    def _replace(self, particles: Floats) -> None:
        particles[:, 2] = wrap(particles[:, 2])
        self.particles = np.asfortranarray(particles)
        self.weights = _even(len(particles))
        self._rank_of = self._binned = None
        self._tied = np.zeros(0, bool)

    def _anywhere(self, count: int) -> Floats:
        step = 2 if self._config.freespace_downsampling else 1
        return self._field.sample_free(count, self._rng, step)

    def move(self, delta: SE2) -> None:
        """Move each particle by a draw around a step of odometry."""
        self.particles = self._motion(self._config, self.particles, delta, self._rng)
        self._binned = None

    def reweigh(self, factors: Floats) -> None:
        """Multiply the weights by `(N,)` factors; where none is left, all count alike."""
        weights = self.weights * factors
        total = weights.sum()
        self.weights = weights / total if total > 0.0 else _even(len(weights))

    def level(self, factors: Floats) -> Floats:
        """Return factors `(N,)` that leave the shares of tied clusters among each other alone.

        Where a scan fits at several poses alike, its sampled likelihood differs by chance, and over
        many scans chance would decide for one of them.
        """
        if self._rank_of is None:
            return factors
        count = len(self._tied)
        before = np.bincount(self._rank_of, self.weights, count + 1)[:count]
        after = np.bincount(self._rank_of, self.weights * factors, count + 1)[:count]
        tied = self._tied & (before > 0.0) & (after > 0.0)  # the weights of others have run out
        if tied.sum() < 2:
            return factors
        common = after[tied].sum() / before[tied].sum()
        scale = np.ones(count + 1)
        scale[:count][tied] = common * before[tied] / after[tied]
        return factors * scale[self._rank_of]

    def resample(self, injection: float) -> bool:
        """Resample the particles if that is due, a share `injection` of them from anywhere.

        Returns:
            Whether particles were replaced by ones from anywhere.
        """
        self._updates += 1
        c = self._config
        if self._updates % c.resample_interval:
            return False
        if c.selective_resampling and 2.0 * effective_count(self.weights) > len(self.weights):
            return False
        limits = (c.pf_err, c.pf_z, c.min_particles, c.max_particles)
        bin_of, bins = to_bins(self.particles)
        kept = kld_indices(self.weights, bin_of, limits, self._rng)
        self.particles = np.take(self.particles.T, kept, axis=1).T
        self.weights = _even(len(kept))
        self._binned = (bin_of[kept], bins)
        return injection > 0.0 and self._inject(injection)

    def _inject(self, injection: float) -> bool:
        injected = self._rng.random(len(self.particles)) < injection
        if not injected.any():
            return False
        self.particles[injected] = self._anywhere(int(injected.sum()))
        self._binned = None
        return True

    def clusters(self) -> list[Cluster]:
        """Return the clusters of the particles, the heaviest first."""
        lightest = 0.02  # lighter clusters are no hypothesis
        most = 6  # as many as the search proposes
        found, self._rank_of = find_clusters(
            self.particles, self.weights, lightest, most, self._binned
        )
        return found

    def shift(self, factors: Floats, tied: Bools) -> Floats:
        """Multiply the weight of each cluster found last by a factor; return their shares `(K,)`.

        `tied` are those that the scan fits alike, `(K,) bool`.
        """
        assert self._rank_of is not None
        self._tied = tied
        count = len(factors)
        if count > 1:
            self.reweigh(np.append(factors, 1.0)[self._rank_of])
        shares = np.bincount(self._rank_of, self.weights, count + 1)[:count]
        return np.asarray(shares, np.float64)
