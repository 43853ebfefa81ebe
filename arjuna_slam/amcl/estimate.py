"""The estimate: what the particles amount to, and how far it can be trusted."""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from arjuna_core.se2 import SE2, wrap
from arjuna_slam.amcl.resample import bin_codes, decode, encode


class Status(enum.Enum):
    """How an update of the filter ended."""

    TRACKING = "tracking"
    AMBIGUOUS = "ambiguous"
    LOST = "lost"
    BLIND = "blind"


@dataclass(frozen=True)
class Estimate:
    """Where the robot is.

    Attributes:
        T_map_base: Pose of the base in the map.
        T_map_odom: Pose of the odometry frame in the map.
        covariance: Of x, y, theta, `(3, 3) float64` [m, m, rad], of the heaviest cluster.
        quality: Trust, 0..1: the share of beams that agree times the share of the weight.
        reason: What the quality rests on, one sentence.
        status: How the update ended.
    """

    T_map_base: SE2
    T_map_odom: SE2
    covariance: NDArray[np.float64]
    quality: float
    reason: str
    status: Status


@dataclass(frozen=True)
class Cluster:
    """Particles that lie together.

    Attributes:
        share: Of the whole weight, 0..1.
        mean: `(3,) float64` [m, m, rad].
        covariance: `(3, 3) float64`.
        members: Indices of its particles, `(M,) int64`.
    """

    share: float
    mean: NDArray[np.float64]
    covariance: NDArray[np.float64]
    members: NDArray[np.int64]


def find_clusters(
    particles: NDArray[np.float64], weights: NDArray[np.float64], least: float, limit: int
) -> list[Cluster]:
    """Return the heaviest clusters, heaviest first.

    Particles belong together when their histogram bins touch, headings wrapping around.

    Args:
        particles: `(N, 3) float64` [m, m, rad].
        weights: `(N,) float64` that sum to 1.
        least: Share of the weight, 0..1, below which only the heaviest is returned.
        limit: Greatest number of clusters returned.

    Source: nav2_amcl (pf_kdtree_cluster).
    """
    codes, bin_of_particle = np.unique(bin_codes(particles), return_inverse=True)
    labels = _touching(codes)[bin_of_particle]
    shares = np.bincount(labels, weights)
    heaviest = np.argsort(-shares, kind="stable")[:limit]
    heaviest = heaviest[shares[heaviest] >= min(least, shares.max())]
    return [_summary(particles, weights, np.flatnonzero(labels == label)) for label in heaviest]


def _touching(codes: NDArray[np.int64]) -> NDArray[np.int64]:
    """Label sorted bins `(K,)` by connected component."""
    if len(codes) == 1:
        return np.zeros(1, np.int64)
    x, y, heading = decode(codes)
    rows, columns = [], []
    for dx, dy, dh in _HALF_NEIGHBOURHOOD:
        neighbours = encode(x + dx, y + dy, heading + dh)
        found = np.minimum(np.searchsorted(codes, neighbours), len(codes) - 1)
        hit = np.flatnonzero(codes[found] == neighbours)
        rows.append(hit)
        columns.append(found[hit])
    row, column = np.concatenate(rows), np.concatenate(columns)
    edges = coo_array((np.ones(len(row), np.int8), (row, column)), shape=(len(codes),) * 2)
    labels: NDArray[np.int64] = connected_components(edges, directed=False)[1].astype(np.int64)
    return labels


_HALF_NEIGHBOURHOOD = [
    (dx, dy, dh)
    for dx in (-1, 0, 1)
    for dy in (-1, 0, 1)
    for dh in (-1, 0, 1)
    if (dx, dy, dh) > (0, 0, 0)
]


def _summary(
    particles: NDArray[np.float64], weights: NDArray[np.float64], members: NDArray[np.int64]
) -> Cluster:
    own, share = particles[members], float(weights[members].sum())
    if share > 0.0:
        relative = weights[members] / share
    else:
        relative = np.full(len(members), 1.0 / len(members))
    heading = math.atan2(relative @ np.sin(own[:, 2]), relative @ np.cos(own[:, 2]))
    mean = np.array([relative @ own[:, 0], relative @ own[:, 1], heading])
    errors = own - mean
    errors[:, 2] = wrap(errors[:, 2])
    return Cluster(share, mean, (errors * relative[:, np.newaxis]).T @ errors, members)
