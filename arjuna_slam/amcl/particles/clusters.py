"""Clusters: particles that lie together, each a place where the robot may be."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from arjuna_slam.amcl.particles.bins import bin_centres, connect, to_bins

_SLACK = 0.05  # beyond three deviations [m, rad]


@dataclass(frozen=True)
class Cluster:
    """Particles that lie together.

    Attributes:
        share: Of the whole weight, 0..1.
        mean: `(3,) float64` [m, m, rad].
        covariance: `(3, 3) float64`.
    """

    share: float
    mean: NDArray[np.float64]
    covariance: NDArray[np.float64]

    def holds(self, pose: NDArray[np.float64]) -> bool:
        """Tell whether a pose `(3,)` [m, m, rad] may be one of the cluster's."""
        off = pose - self.mean
        off[2] = math.remainder(off[2], 2.0 * math.pi)
        return bool((np.abs(off) <= 3.0 * np.sqrt(self.covariance.diagonal()) + _SLACK).all())


def find_clusters(
    particles: NDArray[np.float64],
    weights: NDArray[np.float64],
    least: float,
    limit: int,
    binned: tuple[NDArray[np.int32], NDArray[np.int64]] | None = None,
) -> tuple[list[Cluster], NDArray[np.int64]]:
    """Return the heaviest clusters, heaviest first, and each particle's rank among them.

    Particles belong together when their histogram bins touch, see `connect`.

    Args:
        particles: `(N, 3) float64` [m, m, rad], columns contiguous.
        weights: `(N,) float64` that sum to 1.
        least: Share of the weight, 0..1, below which only the heaviest is returned.
        limit: Greatest number of clusters returned.
        binned: What `to_bins` says of the particles, where it is known already; bins may be empty.

    Returns:
        The clusters, and the index of each particle's, `(N,) int64`; that of particles of none is
        the number of clusters.

    Source: nav2_amcl (pf_kdtree_cluster), but for the modes.
    """
    bin_of, bins = to_bins(particles) if binned is None else binned
    shares = np.asarray(np.bincount(bin_of, weights, len(bins)), np.float64)
    met = np.bincount(bin_of, minlength=len(bins)) > 0
    labels = np.full(len(bins), -1)
    labels[met] = connect(bins[met], shares[met])
    totals = np.bincount(labels[met], shares[met])
    order = np.argsort(-totals, kind="stable")[:limit]
    order = order[totals[order] >= min(least, totals.max())]
    rank = np.full(len(totals) + 1, len(order), np.int64)
    rank[order] = np.arange(len(order))
    rank_of_bin: NDArray[np.int64] = rank[labels]
    references = bin_centres(bins[_heaviest(shares, rank_of_bin, len(order))])
    rank_of = rank_of_bin[bin_of]
    sums = _moments(particles[:, 0], particles[:, 1], particles[:, 2], weights, rank_of, references)
    pairs = zip(sums, references, strict=True)
    return [_cluster(row, reference) for row, reference in pairs], rank_of


@njit(cache=True)
def _heaviest(
    shares: NDArray[np.float64], rank: NDArray[np.int64], count: int
) -> NDArray[np.int64]:
    """Return each cluster's heaviest bin, from where differences are summed."""
    heaviest = np.full(count, -1)
    for k in range(len(shares)):
        r = rank[k]
        if r < count and (heaviest[r] < 0 or shares[k] > shares[heaviest[r]]):
            heaviest[r] = k
    return heaviest


@njit(cache=True)
def _moments(
    x: NDArray[np.float64],
    y: NDArray[np.float64],
    heading: NDArray[np.float64],
    weights: NDArray[np.float64],
    rank: NDArray[np.int64],
    references: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Return per cluster the weighted count, sums and sums of squares and products, `(K, 10)`."""
    sums = np.zeros((len(references), 10))
    for i in range(len(x)):
        k = rank[i]
        if k >= len(references):
            continue
        w = weights[i]
        dx, dy = x[i] - references[k, 0], y[i] - references[k, 1]
        turn = heading[i] - references[k, 2]
        turn -= 2.0 * math.pi * math.floor(turn / (2.0 * math.pi) + 0.5)
        sums[k, 0] += w
        sums[k, 1] += w * dx
        sums[k, 2] += w * dy
        sums[k, 3] += w * turn
        sums[k, 4] += w * dx * dx
        sums[k, 5] += w * dx * dy
        sums[k, 6] += w * dx * turn
        sums[k, 7] += w * dy * dy
        sums[k, 8] += w * dy * turn
        sums[k, 9] += w * turn * turn
    return sums


def _cluster(sums: NDArray[np.float64], reference: NDArray[np.float64]) -> Cluster:
    share = float(sums[0])
    means = sums[1:] / share if share > 0.0 else np.zeros(9)
    shift, (xx, xy, xt, yy, yt, tt) = means[:3], means[3:]
    covariance = np.array([[xx, xy, xt], [xy, yy, yt], [xt, yt, tt]]) - np.outer(shift, shift)
    np.fill_diagonal(covariance, np.maximum(covariance.diagonal(), 0.0))  # rounding
    mean = reference + shift
    mean[2] = math.remainder(mean[2], 2.0 * math.pi)
    return Cluster(share, mean, covariance)
