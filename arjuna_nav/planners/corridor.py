"""Where a way may lead: an estimate on a coarse grid, so that a wave need not cover the map."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from arjuna_nav.costmap.costmap import INSCRIBED, LETHAL
from arjuna_nav.planners.potential import NEUTRAL, spread

SHIFT = 3
"""A cell of the coarse grid is 8 x 8 of the map's: walls that robots cannot pass stay closed."""

_CELL = 1 << SHIFT
_BLOCKED = 60  # added to a coarse cell's value by the share that is blocked: ways bend round it
_WORTHWHILE = 256 * 256  # cells; a wave covers fewer in a few milliseconds
_DOUBTFUL = 1.1  # a way dearer than estimated by this factor may not be the best
_WIDTH = 6.0 * NEUTRAL  # least slack: three coarse cells to either side of a straight way


def corridor(
    data: NDArray[np.uint8],
    costs: NDArray[np.float32],
    start: tuple[int, int],
    goal: tuple[int, int],
    slack: float,
) -> tuple[NDArray[np.bool_], float] | None:
    """Return the coarse cells that a good way may cross, and what it may cost.

    Those through which the way costs by estimate at most `1 + slack` times the least, and a little
    more. A coarse cell is open where one of its cells is, and costs what these cost on average, the
    more the more of it is blocked.

    Args:
        data: `(height, width) uint8` costs of a costmap.
        costs: Of `traversal_costs`.
        start: `(row, column)`.
        goal: As `start`.
        slack: See above.

    Returns:
        `(height / 8, width / 8) bool`, rounded up, and a potential; None where the map is small or
        no way is to be seen.

    Source: the bound of bidirectional search (Pohl 1971) on a pooled map.
    """
    if data.size < _WORTHWHILE:
        return None
    coarse = _pooled(data, costs)
    waves = [
        spread(coarse, costs, np.array([[cell[0] // _CELL, cell[1] // _CELL, 0.0]]))
        for cell in (start, goal)
    ]
    least = waves[0][goal[0] // _CELL, goal[1] // _CELL]
    if not np.isfinite(least):
        return None
    allowed = least * (1.0 + slack) + _WIDTH
    return waves[0] + waves[1] <= allowed, float(least) * _CELL * _DOUBTFUL


@njit(cache=True)
def _pooled(data: NDArray[np.uint8], costs: NDArray[np.float32]) -> NDArray[np.uint8]:
    """Return the value of each coarse cell, LETHAL where none of its cells is open."""
    height, width = data.shape
    rows, columns = (height + _CELL - 1) // _CELL, (width + _CELL - 1) // _CELL
    result = np.empty((rows, columns), np.uint8)
    total, count = np.empty(columns, np.int32), np.empty(columns, np.int32)
    for row in range(rows):
        total[:] = 0
        count[:] = 0
        for r in range(row * _CELL, min((row + 1) * _CELL, height)):
            for column in range(columns):
                for c in range(column * _CELL, min((column + 1) * _CELL, width)):
                    if costs[data[r, c]] < np.inf:
                        total[column] += min(data[r, c], INSCRIBED - 1)
                        count[column] += 1
        for column in range(columns):
            if count[column] == 0:
                result[row, column] = LETHAL
                continue
            mean = total[column] // count[column]
            blocked = _BLOCKED - _BLOCKED * count[column] // (_CELL * _CELL)
            result[row, column] = min(mean + blocked, INSCRIBED - 1)
    return result
