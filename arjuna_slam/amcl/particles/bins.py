"""The histogram that KLD sampling and clustering share: 0.5 m x 0.5 m x 10 degrees a bin."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

_METRES = 0.5  # side of a bin [m]: Fox's and Nav2's
_HEADINGS = 36  # bins of 10 degrees, as theirs
_RADIANS = 2.0 * math.pi / _HEADINGS
_TABLE_MAX = 1 << 23  # bins of the box around all particles, up to which a table numbers them
_SADDLE = 0.2  # of the lesser peak's weight, above which two modes are one
_STEPS = tuple((x, y, h) for x in (-1, 0, 1) for y in (-1, 0, 1) for h in (-1, 0, 1))


def to_bins(particles: NDArray[np.float64]) -> tuple[NDArray[np.int32], NDArray[np.int64]]:
    """Sort particles into the histogram's bins.

    Args:
        particles: `(N, 3) float64` [m, m, rad], columns contiguous.

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
    if size <= _TABLE_MAX:
        bin_of, met = _number(codes, size)
    else:
        met, inverse = np.unique(codes, return_inverse=True)
        bin_of = inverse.astype(np.int32)
    places = met // _HEADINGS
    return bin_of, np.column_stack(
        (places // rows + low[0], places % rows + low[1], met % _HEADINGS)
    )


def bin_centres(bins: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return the centres of bins `(K, 3)`, as `(K, 3) float64` [m, m, rad]."""
    centres: NDArray[np.float64] = (bins + 0.5) * np.array((_METRES, _METRES, _RADIANS))
    centres[:, 2] -= math.pi
    return centres


@njit(cache=True)
def _codes(
    x: NDArray[np.float64],
    y: NDArray[np.float64],
    heading: NDArray[np.float64],
    low_x: int,
    low_y: int,
    rows: int,
) -> NDArray[np.int64]:
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
def _number(codes: NDArray[np.int64], size: int) -> tuple[NDArray[np.int32], NDArray[np.int64]]:
    """Number the codes, all below `size`, in the order in which they are met."""
    table = np.zeros(size, np.int32)
    bin_of = np.empty(len(codes), np.int32)
    met = np.empty(min(len(codes), size), np.int64)
    used = 0
    for i in range(len(codes)):
        number = table[np.uint64(codes[i])]
        if number == 0:
            met[used] = codes[i]
            used += 1
            number = np.int32(used)
            table[np.uint64(codes[i])] = number
        bin_of[i] = number - 1
    return bin_of, met[:used].copy()


def connect(bins: NDArray[np.int64], shares: NDArray[np.float64]) -> NDArray[np.int64]:
    """Label bins `(K, 3)` alike that belong to one mode of the belief.

    From the heaviest bin down, each joins what it touches, corners and wrapped headings included.
    Modes that meet are one if the bin between them carries enough of the lesser one's peak; so
    the tails of places near each other do not make them one.

    Args:
        bins: From `to_bins`.
        shares: The weight of each, `(K,) float64`.

    Returns:
        `(K,) int64`, from 0.

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
def _connect(
    codes: NDArray[np.int64], shares: NDArray[np.float64], by_share: NDArray[np.int64], rows: int
) -> NDArray[np.int64]:
    """Number the bins' modes by falling peaks; codes are sorted, their rows and columns from 1."""
    root, rank = np.full(len(codes), -1), np.empty(len(codes), np.int64)
    rank[by_share] = np.arange(len(codes))
    for k in by_share:
        root[k] = k
        place, heading = divmod(codes[k], _HEADINGS)
        for dx, dy, turn in _STEPS:
            near = (place + dx * rows + dy) * _HEADINGS + (heading + turn) % _HEADINGS
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
def _top(root: NDArray[np.int64], k: int) -> int:
    while root[k] != k:
        k = root[k]
    return k
