"""Distances of a costmap's cells from a path and from its end."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from arjuna_core.arrays import Bytes, Floats, Ints
from arjuna_nav.costmap.costmap import INSCRIBED, UNKNOWN

UNREACHED = np.int32(2**30)
"""Value of a blocked or unreached cell."""


@njit(cache=True)
def path_cells(points: Floats, height: int, width: int) -> Ints:
    """Return the cells, `row * width + column`, that a path crosses until it leaves the grid.

    Args:
        points: `(N, 2) float64` of `(x, y)` in cells.
    """
    cells = np.empty(4 * (len(points) + height + width), np.int64)
    count, inside = 0, False
    for i in range(len(points)):
        x0, y0 = points[max(i - 1, 0)]
        x1, y1 = points[i]
        steps = int(2.0 * max(abs(x1 - x0), abs(y1 - y0))) + 1
        for k in range(1, steps + 1):
            column = int(np.floor(x0 + (x1 - x0) * k / steps))
            row = int(np.floor(y0 + (y1 - y0) * k / steps))
            if not (0 <= row < height and 0 <= column < width):
                if inside:
                    return cells[:count]
                continue
            inside = True
            cell = row * width + column
            if count < len(cells) and (count == 0 or cells[count - 1] != cell):
                cells[count] = cell
                count += 1
    return cells[:count]


@njit(cache=True)
def spread_distances(data: Bytes, sources: Ints) -> NDArray[np.int32]:
    """Return each cell's distance to the nearest source round obstacles, `(height, width) int32`.

    Steps go to the four neighbours [cells]; `UNREACHED` where no path leads. Sources count even
    where they are blocked.

    Source: nav2 dwb_critics, MapGridCritic.
    """
    height, width = data.shape
    distance = np.full(height * width, UNREACHED, np.int32)
    costs = data.ravel()
    queue = np.empty(height * width, np.int32)
    head, tail = 0, 0
    for cell in sources:
        if distance[cell] != 0:
            distance[cell] = 0
            queue[tail] = cell
            tail += 1
    while head < tail:
        cell = queue[head]
        head += 1
        row, column = cell // width, cell % width
        for k in range(4):
            r, c = row + (k == 0) - (k == 1), column + (k == 2) - (k == 3)
            if not (0 <= r < height and 0 <= c < width):
                continue
            other = r * width + c
            cost = costs[other]
            blocked = cost >= INSCRIBED and cost != UNKNOWN
            if distance[other] == UNREACHED and not blocked:
                distance[other] = distance[cell] + 1
                queue[tail] = other
                tail += 1
    return distance.reshape(height, width)
