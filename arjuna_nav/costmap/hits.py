"""Where in its cell an obstacle lies: the mean of the latest hits, as a number of 32 bits.

The lower half is x, the upper y; 0 says that no scan has hit the cell.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

_NEWEST = 0.25  # weight of a hit in its cell's mean: noise of ranges is averaged
_STEPS = 65534.0  # that a cell's edge is told apart in


@njit(cache=True)
def blended(code: int, x: float, y: float) -> int:
    """Return where a cell's mark lies after one more hit at a place in it [cells]."""
    if code:
        x0, y0 = _decoded(code)
        x, y = x0 + _NEWEST * (x - x0), y0 + _NEWEST * (y - y0)
    return 1 + int(x * _STEPS) + (int(y * _STEPS) << 16)


@njit(cache=True)
def _decoded(code: int) -> tuple[float, float]:
    return ((code & 0xFFFF) - 0.5) / _STEPS, ((code >> 16) + 0.5) / _STEPS


@njit(cache=True)
def hit_points(
    data: NDArray[np.uint8],
    hits: NDArray[np.uint32],
    x: float,
    y: float,
    radius: float,
    lethal: int,
) -> NDArray[np.float64]:
    """Return where the lethal cells about a place are marked, `(N, 2)` x, y [cells].

    A cell that no scan has hit is marked in its middle.

    Args:
        data: `(height, width) uint8` of a costmap.
        hits: `(height, width) uint32` as `enter_scan` fills them; 0 for none.
        x: Of the place [cells].
        y: Of the place [cells].
        radius: How far about it [cells].
        lethal: The cost of such a cell.
    """
    height, width = data.shape
    rows = max(math.floor(y - radius), 0), min(math.floor(y + radius) + 1, height)
    columns = max(math.floor(x - radius), 0), min(math.floor(x + radius) + 1, width)
    found = []
    for row in range(rows[0], rows[1]):
        for column in range(columns[0], columns[1]):
            if data[row, column] == lethal:
                off = _decoded(hits[row, column]) if hits[row, column] else (0.5, 0.5)
                if math.hypot(column + off[0] - x, row + off[1] - y) <= radius:
                    found.append((column + off[0], row + off[1]))
    points = np.empty((len(found), 2))
    for i in range(len(found)):
        points[i, 0], points[i, 1] = found[i]
    return points
