"""Sparse Cholesky decomposition of matrices of 3 x 3 blocks, for pose graphs.

The order of elimination and the pattern of the factor come from SuperLU's minimum degree on the
graph of nodes, so they cost a ninth of those of the scalar matrix; the factor itself is computed
block by block, its dense lower right corner by LAPACK. On the public pose graphs a step takes a
fifth of the time of SciPy's `splu`: `python -m bringup bench posegraph` measures both.

Source: Davis, Direct methods for sparse linear systems, 2006, chapters 4 and 7.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from scipy.sparse import coo_matrix, diags
from scipy.sparse.linalg import splu

from arjuna_core.arrays import Floats, Ints


@dataclass(frozen=True)
class Pattern:
    """Positions of the blocks of a matrix's factor."""

    perm: Ints  # row of each node in the order of elimination, `(N,) int64`
    starts: Ints  # first block of each column before the corner, `(C + 1,) int64`
    rows: Ints  # row of each block, the diagonal first, `(K,) int64`
    slots: Ints  # block of each pair of nodes, -1 in the corner, -2 for none, `(E,) int64`

    @property
    def corner(self) -> int:
        """Nodes in the dense corner."""
        return len(self.perm) - (len(self.starts) - 1)


def pattern(count: int, i: Ints, j: Ints) -> Pattern:
    """Order nodes and find the pattern of the factor, from the nodes of each pair, `(E,) int64`.

    Node 0 is held, so its pairs have no block.
    """
    free = (i != 0) & (j != 0)
    pair = (np.concatenate((i[free], j[free])), np.concatenate((j[free], i[free])))
    links = coo_matrix((-np.ones(len(pair[0])), pair), shape=(count, count)).tocsc()
    regular = 1e-6  # so that fill decays slowly and never to zero
    laplacian = (links + diags(regular - np.asarray(links.sum(axis=0)).ravel())).tocsc()
    factor = splu(
        laplacian, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0,
        options={"SymmetricMode": True},
    )  # fmt: skip
    perm = factor.perm_c.astype(np.int64)
    lower = factor.L.tocsc()
    lower.sort_indices()
    starts, rows = lower.indptr.astype(np.int64), lower.indices.astype(np.int64)
    starts = starts[: _corner_start(starts) + 1]
    rows = rows[: starts[-1]]
    return Pattern(perm, starts, rows, _slots(perm, starts, rows, i, j))


def _corner_start(starts: Ints) -> int:
    """Return the first column of the largest lower right corner that is dense."""
    most = 1000  # nodes, as the cost of the corner grows with their cube
    sizes = np.arange(1, min(len(starts) - 1, most) + 1)
    filled = np.cumsum(np.diff(starts)[::-1])[: len(sizes)]
    density = 0.5  # share of blocks from which a corner counts as dense
    dense = np.flatnonzero(filled >= density * 0.5 * sizes * (sizes + 1))
    return len(starts) - 1 - int(sizes[dense[-1]])


@njit(cache=True)
def _slots(perm: Ints, starts: Ints, rows: Ints, i: Ints, j: Ints) -> Ints:
    slots = np.empty(len(i), np.int64)
    first = len(starts) - 1
    for e in range(len(i)):
        low, high = min(perm[i[e]], perm[j[e]]), max(perm[i[e]], perm[j[e]])
        slots[e] = -1
        if i[e] == 0 or j[e] == 0:
            slots[e] = -2
        elif low < first:
            column = rows[starts[low] : starts[low + 1]]
            slots[e] = starts[low] + np.searchsorted(column, high)
    return slots


@njit(cache=True)
def factorize(starts: Ints, rows: Ints, blocks: Floats, corner: Floats) -> None:
    """Replace a matrix by its lower factor; `starts` and `rows` are those of `Pattern`.

    `blocks` are the lower triangle's, `(K, 3, 3)`, `corner` its last rows, `(3 T, 3 T)`.
    """
    first = len(starts) - 1
    for k in range(first):
        begin, end = starts[k], starts[k + 1]
        _factor_block(blocks[begin])
        for p in range(begin + 1, end):
            _divide(blocks[p], blocks[begin])
        for p in range(begin + 1, end):
            column = rows[p]
            if column >= first:
                c = 3 * (column - first)
                for q in range(p, end):
                    r = 3 * (rows[q] - first)
                    _subtract(corner[r : r + 3, c : c + 3], blocks[q], blocks[p])
                continue
            s = starts[column]
            for q in range(p, end):
                while rows[s] != rows[q]:
                    s += 1
                _subtract(blocks[s], blocks[q], blocks[p])
    if len(corner) > 0:
        corner[:] = np.linalg.cholesky(corner)


@njit(cache=True)
def _factor_block(a: Floats) -> None:
    a[0, 0] = np.sqrt(max(a[0, 0], 1e-300))
    a[1, 0] /= a[0, 0]
    a[2, 0] /= a[0, 0]
    a[1, 1] = np.sqrt(max(a[1, 1] - a[1, 0] * a[1, 0], 1e-300))
    a[2, 1] = (a[2, 1] - a[2, 0] * a[1, 0]) / a[1, 1]
    a[2, 2] = np.sqrt(max(a[2, 2] - a[2, 0] * a[2, 0] - a[2, 1] * a[2, 1], 1e-300))


@njit(cache=True)
def _divide(b: Floats, low: Floats) -> None:
    """Replace b by b times the inverse of the transposed lower triangle."""
    for r in range(3):
        b[r, 0] = b[r, 0] / low[0, 0]
        b[r, 1] = (b[r, 1] - b[r, 0] * low[1, 0]) / low[1, 1]
        b[r, 2] = (b[r, 2] - b[r, 0] * low[2, 0] - b[r, 1] * low[2, 1]) / low[2, 2]


@njit(cache=True)
def _subtract(target: Floats, a: Floats, b: Floats) -> None:
    for r in range(3):
        for c in range(3):
            target[r, c] -= a[r, 0] * b[c, 0] + a[r, 1] * b[c, 1] + a[r, 2] * b[c, 2]


@njit(cache=True)
def solve(starts: Ints, rows: Ints, blocks: Floats, corner: Floats, x: Floats) -> None:
    """Solve with the factor in perm; `x` is `(N, 3) float64` in the order of elimination."""
    first = len(starts) - 1
    for k in range(first):
        low = blocks[starts[k]]
        x[k, 0] /= low[0, 0]
        x[k, 1] = (x[k, 1] - low[1, 0] * x[k, 0]) / low[1, 1]
        x[k, 2] = (x[k, 2] - low[2, 0] * x[k, 0] - low[2, 1] * x[k, 1]) / low[2, 2]
        for p in range(starts[k] + 1, starts[k + 1]):
            for r in range(3):
                for c in range(3):
                    x[rows[p], r] -= blocks[p, r, c] * x[k, c]
    tail = x[first:].copy().reshape(-1)
    _solve_dense(corner, tail)
    x[first:] = tail.reshape(-1, 3)
    for k in range(first - 1, -1, -1):
        for p in range(starts[k] + 1, starts[k + 1]):
            for r in range(3):
                for c in range(3):
                    x[k, c] -= blocks[p, r, c] * x[rows[p], r]
        low = blocks[starts[k]]
        x[k, 2] /= low[2, 2]
        x[k, 1] = (x[k, 1] - low[2, 1] * x[k, 2]) / low[1, 1]
        x[k, 0] = (x[k, 0] - low[1, 0] * x[k, 1] - low[2, 0] * x[k, 2]) / low[0, 0]


@njit(cache=True)
def _solve_dense(low: Floats, x: Floats) -> None:
    for r in range(len(x)):
        total = x[r]
        for c in range(r):
            total -= low[r, c] * x[c]
        x[r] = total / low[r, r]
    for r in range(len(x) - 1, -1, -1):
        x[r] /= low[r, r]
        for c in range(r):
            x[c] -= low[r, c] * x[r]
