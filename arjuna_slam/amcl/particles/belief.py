"""The belief: weighted particles, and the clusters that they form."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arjuna_core.se2 import SE2, wrap
from arjuna_slam.amcl.config import AmclConfig
from arjuna_slam.amcl.estimate import Hypothesis
from arjuna_slam.amcl.particles.bins import to_bins
from arjuna_slam.amcl.particles.clusters import Cluster, find_clusters
from arjuna_slam.amcl.particles.motion import MODELS
from arjuna_slam.amcl.particles.resample import effective_count, kld_indices, low_variance_indices
from arjuna_slam.matching.map_field import MapField

_RIVAL = 0.02  # lighter clusters are no hypothesis
_RIVALS_MAX = 6  # clusters that are told at most


class Belief:
    """A set of particles.

    Args:
        config: Parameters.
        field: The map.
        rng: Source of all randomness.

    Attributes:
        particles: `(N, 3) float64` in the map frame [m, m, rad], columns contiguous.
        weights: `(N,) float64` that sum to 1.
    """

    def __init__(self, config: AmclConfig, field: MapField, rng: np.random.Generator) -> None:
        self._config, self._field, self._rng = config, field, rng
        self._motion = MODELS[config.robot_model_type]
        self._updates = 0
        self._rank_of: NDArray[np.int64] | None = None  # of each particle's cluster, when known
        self._tied = np.zeros(0, bool)  # which clusters the last scan fit alike
        self._binned: tuple[NDArray[np.int32], NDArray[np.int64]] | None = None
        self.particles: NDArray[np.float64] = np.empty((0, 3))
        self.weights: NDArray[np.float64] = np.empty(0)

    def spread(self, pose: SE2, root: NDArray[np.float64]) -> None:
        """Draw all particles around a pose, `root @ root.T` being the covariance `(3, 3)`."""
        draws = self._rng.standard_normal((self._config.max_particles, 3)) @ root.T
        self._replace(pose.array() + draws)

    def scatter(self) -> None:
        """Draw all particles from the map's free cells."""
        self._replace(self._anywhere(self._config.max_particles))

    def seed(self, places: list[Hypothesis], covariance: NDArray[np.float64]) -> None:
        """Draw all particles around places in proportion to their shares.

        Args:
            places: The hypotheses.
            covariance: Of the draws around each, `(3, 3) float64`, diagonal.
        """
        count = self._config.max_particles
        shares = np.array([place.share for place in places])
        poses = np.array([place.T_map_base.array() for place in places])
        centres = poses[low_variance_indices(shares, count, self._rng)]
        draws = self._rng.standard_normal((count, 3)) @ np.sqrt(covariance)
        self._replace(centres + draws)

    def _replace(self, particles: NDArray[np.float64]) -> None:
        particles[:, 2] = wrap(particles[:, 2])
        self.particles = np.asfortranarray(particles)
        self.weights = np.full(len(particles), 1.0 / len(particles))
        self._rank_of = self._binned = None
        self._tied = np.zeros(0, bool)

    def _anywhere(self, count: int) -> NDArray[np.float64]:
        step = 2 if self._config.freespace_downsampling else 1
        return self._field.sample_free(count, self._rng, step)

    def move(self, delta: SE2) -> None:
        """Move each particle by a draw around a step of odometry."""
        self.particles = self._motion(self._config, self.particles, delta, self._rng)
        self._binned = None

    def reweigh(self, factors: NDArray[np.float64]) -> None:
        """Multiply the weights by `(N,)` positive factors."""
        self.weights = self.weights * factors
        self.weights /= self.weights.sum()

    def level(self, factors: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return factors `(N,)` that leave the shares of tied clusters among each other alone.

        Where a scan fits several places alike, its sampled likelihood differs by chance, and over
        many scans chance would decide for one of them.

        Args:
            factors: Of the particles.
        """
        tied = self._tied
        if self._rank_of is None or tied.sum() < 2:
            return factors
        count = len(tied)
        before = np.bincount(self._rank_of, self.weights, count + 1)[:count]
        after = np.bincount(self._rank_of, self.weights * factors, count + 1)[:count]
        common = after[tied].sum() / before[tied].sum()
        scale = np.ones(count + 1)
        scale[:count][tied] = common * before[tied] / after[tied]
        return factors * scale[self._rank_of]

    def resample(self, injection: float) -> bool:
        """Draw the particles anew if that is due.

        Args:
            injection: Share of particles, 0..1, to replace by ones from anywhere.

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
        self.weights = np.full(len(kept), 1.0 / len(kept))
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
        """Return the places where the particles are, the heaviest first."""
        found, self._rank_of = find_clusters(
            self.particles, self.weights, _RIVAL, _RIVALS_MAX, self._binned
        )
        return found

    def shift(self, factors: NDArray[np.float64], tied: NDArray[np.bool_]) -> NDArray[np.float64]:
        """Multiply the weight of each cluster found last by a factor; return their shares `(K,)`.

        Args:
            factors: Of the clusters, `(K,) float64`.
            tied: Which of them the scan fits alike, `(K,) bool`.
        """
        assert self._rank_of is not None
        self._tied = tied
        count = len(factors)
        if count > 1:
            self.reweigh(np.append(factors, 1.0)[self._rank_of])
        shares = np.bincount(self._rank_of, self.weights, count + 1)[:count]
        return np.asarray(shares, np.float64)
