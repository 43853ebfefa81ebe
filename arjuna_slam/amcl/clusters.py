"""The histogram that KLD sampling and clustering share: 0.5 m x 0.5 m x 10 degrees a bin."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from arjuna_core.arrays import Floats, Ints

_METRES = 0.5  # side of a bin [m]: Fox's and Nav2's
_HEADINGS = 36  # bins of 10 degrees, as theirs
_RADIANS = 2.0 * math.pi / _HEADINGS
_SADDLE = 0.2  # of the lesser peak's weight, above which two modes are one
_STEPS = tuple((x, y, h) for x in (-1, 0, 1) for y in (-1, 0, 1) for h in (-1, 0, 1))


def to_bins(particles: Floats) -> tuple[NDArray[np.int32], Ints]:
    """Sort particles, columns contiguous, into the histogram's bins.

    Returns:
        The index of each particle's bin, `(N,) int32`, and the bins that are occupied, `(K, 3)
        int64`: x and y, and the heading from 0 to 35.
    """
    x, y, heading = particles[:, 0], particles[:, 1], particles[:, 2]
    low = (math.floor(x.min() / _METRES), math.floor(y.min() / _METRES))
    columns = math.floor(x.max() / _METRES) - low[0] + 1
    rows = math.floor(y.max() / _METRES) - low[1] + 1
    codes = _codes(x, y, heading, low[0], low[1], rows)
    size = columns * rows * _HEADINGS
    table_max = 1 << 23  # bins: a table of 32 MB numbers them faster than a sort
    if size <= table_max:
        bin_of, used = _number(codes, size)
    else:
        used, inverse = np.unique(codes, return_inverse=True)
        bin_of = inverse.astype(np.int32)
    cells = used // _HEADINGS
    return bin_of, np.column_stack(
        (cells // rows + low[0], cells % rows + low[1], used % _HEADINGS)
    )


def bin_centres(bins: Ints) -> Floats:
    """Return the centres of bins `(K, 3)`, as `(K, 3) float64` [m, m, rad]."""
    centres: Floats = (bins + 0.5) * np.array((_METRES, _METRES, _RADIANS))
    centres[:, 2] -= math.pi
    return centres


@njit(cache=True)
def _codes(x: Floats, y: Floats, heading: Floats, low_x: int, low_y: int, rows: int) -> Ints:
    """Return one number a bin, from 0."""
    codes = np.empty(len(x), np.int64)
    for i in range(len(x)):
        bx = np.int64(math.floor(x[i] * (1.0 / _METRES))) - low_x
        by = np.int64(math.floor(y[i] * (1.0 / _METRES))) - low_y
        turn = (heading[i] + math.pi) * (0.5 / math.pi)
        turn -= math.floor(turn)
        bh = min(np.int64(turn * _HEADINGS), _HEADINGS - 1)
        codes[i] = (bx * rows + by) * _HEADINGS + bh
    return codes


@njit(cache=True)
def _number(codes: Ints, size: int) -> tuple[NDArray[np.int32], Ints]:
    """Number the codes, all below `size`, in the order in which they occur."""
    table = np.zeros(size, np.int32)
    bin_of = np.empty(len(codes), np.int32)
    seen = np.empty(min(len(codes), size), np.int64)
    used = 0
    for i in range(len(codes)):
        number = table[np.uint64(codes[i])]
        if number == 0:
            seen[used] = codes[i]
            used += 1
            number = np.int32(used)
            table[np.uint64(codes[i])] = number
        bin_of[i] = number - 1
    return bin_of, seen[:used].copy()


def connect(bins: Ints, shares: Floats) -> Ints:
    """Label bins `(K, 3)` alike, `(K,) int64` from 0, that belong to one mode of the belief.

    From the heaviest bin down, each joins what it touches, corners and wrapped headings included.
    Modes that meet are one if the bin between them carries enough of the lesser one's peak; so
    the tails of neighbouring modes do not join them.

    Source: Chazal et al., Persistence-based clustering in Riemannian manifolds, 2013.
    """
    x, y = bins[:, 0] - bins[:, 0].min() + 1, bins[:, 1] - bins[:, 1].min() + 1
    rows = int(y.max()) + 2
    codes = (x * rows + y) * _HEADINGS + bins[:, 2]
    order = np.argsort(codes)
    by_share = np.argsort(-shares[order], kind="stable")
    labels = np.empty(len(bins), np.int64)
    labels[order] = _connect(codes[order], shares[order], by_share, rows)
    return labels


@njit(cache=True)
def _connect(codes: Ints, shares: Floats, by_share: Ints, rows: int) -> Ints:
    """Number the bins' modes by falling peaks; codes are sorted, their rows and columns from 1."""
    root, rank = np.full(len(codes), -1), np.empty(len(codes), np.int64)
    rank[by_share] = np.arange(len(codes))
    for k in by_share:
        root[k] = k
        cell, heading = divmod(codes[k], _HEADINGS)
        for dx, dy, turn in _STEPS:
            near = (cell + dx * rows + dy) * _HEADINGS + (heading + turn) % _HEADINGS
            other = np.searchsorted(codes, near)
            if other == k or other == len(codes) or codes[other] != near or root[other] < 0:
                continue
            a, b = _top(root, k), _top(root, other)
            if rank[b] < rank[a]:
                a, b = b, a
            if a != b and (b == k or shares[k] >= _SADDLE * shares[b]):
                root[b] = a
    labels, found = np.empty(len(codes), np.int64), 0
    for k in by_share:
        top = _top(root, k)
        if top == k:
            labels[k] = found
            found += 1
        else:
            labels[k] = labels[top]
    return labels


@njit(cache=True)
def _top(root: Ints, k: int) -> int:
    while root[k] != k:
        k = root[k]
    return k


@dataclass(frozen=True)
class Cluster:
    """Particles that lie together."""

    share: float  # of the whole weight, 0..1
    mean: Floats  # `(3,) float64` [m, m, rad]
    covariance: Floats  # `(3, 3) float64`

    def holds(self, pose: Floats) -> bool:
        """Return whether a pose `(3,)` [m, m, rad] may be one of the cluster's."""
        off = pose - self.mean
        off[2] = math.remainder(off[2], 2.0 * math.pi)
        slack = 0.05  # [m, rad] beyond three deviations, which may be zero
        return bool((np.abs(off) <= 3.0 * np.sqrt(self.covariance.diagonal()) + slack).all())


def find_clusters(
    particles: Floats,
    weights: Floats,
    least: float,
    limit: int,
    binned: tuple[NDArray[np.int32], Ints] | None = None,
) -> tuple[list[Cluster], Ints]:
    """Return the heaviest clusters, heaviest first, and each particle's rank among them.

    Particles belong together when their histogram bins touch, see `connect`. A cluster below the
    share `least` of the weight counts only if it is the heaviest. `binned` is what `to_bins` says,
    where that is known; bins may be empty. Particles of no cluster have the number of clusters.

    Source: nav2_amcl (pf_kdtree_cluster), but for the modes.
    """
    bin_of, bins = to_bins(particles) if binned is None else binned
    shares = np.asarray(np.bincount(bin_of, weights, len(bins)), np.float64)
    used = np.bincount(bin_of, minlength=len(bins)) > 0
    labels = np.full(len(bins), -1)
    labels[used] = connect(bins[used], shares[used])
    totals = np.bincount(labels[used], shares[used])
    order = np.argsort(-totals, kind="stable")[:limit]
    order = order[totals[order] >= min(least, totals.max())]
    rank = np.full(len(totals) + 1, len(order), np.int64)
    rank[order] = np.arange(len(order))
    rank_of_bin: Ints = rank[labels]
    references = bin_centres(bins[_heaviest(shares, rank_of_bin, len(order))])
    rank_of = rank_of_bin[bin_of]
    sums = _moments(particles[:, 0], particles[:, 1], particles[:, 2], weights, rank_of, references)
    pairs = zip(sums, references, strict=True)
    return [_cluster(row, reference) for row, reference in pairs], rank_of


@njit(cache=True)
def _heaviest(shares: Floats, rank: Ints, count: int) -> Ints:
    """Return each cluster's heaviest bin, from where differences are summed."""
    heaviest = np.full(count, -1)
    for k in range(len(shares)):
        r = rank[k]
        if r < count and (heaviest[r] < 0 or shares[k] > shares[heaviest[r]]):
            heaviest[r] = k
    return heaviest


@njit(cache=True)
def _moments(
    x: Floats, y: Floats, heading: Floats, weights: Floats, rank: Ints, references: Floats
) -> Floats:
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


def _cluster(sums: Floats, reference: Floats) -> Cluster:
    share = float(sums[0])
    means = sums[1:] / share if share > 0.0 else np.zeros(9)
    shift, (xx, xy, xt, yy, yt, tt) = means[:3], means[3:]
    covariance = np.array([[xx, xy, xt], [xy, yy, yt], [xt, yt, tt]]) - np.outer(shift, shift)
    np.fill_diagonal(covariance, np.maximum(covariance.diagonal(), 0.0))  # rounding
    mean = reference + shift
    mean[2] = math.remainder(mean[2], 2.0 * math.pi)
    return Cluster(share, mean, covariance)
