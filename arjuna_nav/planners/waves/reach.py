"""Which cells can be reached at all: a flood, in a tenth of a wave's time."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray


def reachable(
    data: NDArray[np.uint8], costs: NDArray[np.float32], seeds: NDArray[np.float64]
) -> NDArray[np.bool_]:
    """Return which cells a wave would reach from its seeds, `(height, width) bool`.

    Args:
        data: `(height, width) uint8` costs of a costmap.
        costs: Of `traversal_costs`.
        seeds: `(N, 3)` row, column and potential of the cells where the wave begins.
    """
    reached = np.zeros(data.shape, np.bool_)
    _flood(data, np.isfinite(costs), seeds[:, :2].astype(np.int64), reached)
    return reached


@njit(cache=True)
def _flood(
    data: NDArray[np.uint8],
    crossable: NDArray[np.bool_],
    seeds: NDArray[np.int64],
    reached: NDArray[np.bool_],
) -> None:
    """Fill `reached` run by run of a row.

    Source: Smith, Tint fill, SIGGRAPH 1979.
    """
    height, width = data.shape
    stack = [(np.int64(0), np.int64(0))]
    stack.pop()
    for row, column in seeds:
        reached[row, column] = False
        stack.append((row, column))
    while len(stack) > 0:
        row, column = stack.pop()
        if reached[row, column]:
            continue
        first, last = column, column
        while first > 0 and crossable[data[row, first - 1]]:
            first -= 1
        while last < width - 1 and crossable[data[row, last + 1]]:
            last += 1
        reached[row, first : last + 1] = True
        for other in (row - 1, row + 1):
            if not 0 <= other < height:
                continue
            before = False
            for k in range(first, last + 1):
                opens = crossable[data[other, k]] and not reached[other, k]
                if opens and not before:
                    stack.append((other, k))
                before = opens
    return
