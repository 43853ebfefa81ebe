"""Where a way may lead: an estimate on coarse grids, so that a search need not cover the map."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, TypeVar

import numpy as np
from numba import njit
from numpy.typing import NDArray

from arjuna_nav.costmap.costmap import INSCRIBED, LETHAL
from arjuna_nav.planners.waves.potential import EVERYWHERE, NEUTRAL, spread

T = TypeVar("T")

_SHIFTS = (3, 2)  # cells of 8 x 8 of the map's, then within their corridor of 4 x 4
_BLOCKED = 60  # added to a coarse cell's value by the share that is blocked: ways bend round it
_WORTHWHILE = 256 * 256  # cells; a wave covers fewer in a few milliseconds
_DOUBTFUL = 1.1  # a way dearer than estimated by this factor may not be the best
_WIDTH = 6.0  # least slack: three coarse cells to either side of a straight way [cells]


class Corridor(NamedTuple):
    """The coarse cells that a good way may cross, and what it may cost.

    Attributes:
        open: `(height >> shift, width >> shift) bool`, rounded up.
        shift: A coarse cell is `2**shift` squared of the map's.
        price: What a way within may cost, else there may be a better one elsewhere.
    """

    open: NDArray[np.bool_]
    shift: int
    price: float


UNBOUNDED = Corridor(EVERYWHERE, 0, np.inf)


def corridors(
    data: NDArray[np.uint8],
    costs: NDArray[np.float32],
    start: tuple[int, int],
    goal: tuple[int, int],
    slack: float,
    width: float = 0.0,
) -> tuple[Corridor, ...]:
    """Return the coarse cells through which ways cost by estimate little more than the least.

    First those of the finer grid, then those of the coarser one that hold them. They cost at most
    `1 + slack` times the least, and a little more. A coarse cell is open where one of its cells is,
    and costs what these cost on average, the more the more of it is blocked.

    Args:
        data: `(height, width) uint8` costs of a costmap.
        costs: What it costs to cross a cell by its value, as of `traversal_costs`.
        start: `(row, column)`.
        goal: As `start`.
        slack: See above.
        width: Cells of the map that a way may need to each side, for a robot that bends.

    Returns:
        None at all where the map is small, the goal is blocked, or no way is to be seen.

    Source: the bound of bidirectional search (Pohl 1971) on a pyramid of pooled maps.
    """
    if data.size < _WORTHWHILE or not np.isfinite(costs[data[goal]]):
        return ()
    found: tuple[Corridor, ...] = ()
    within, before = EVERYWHERE, _SHIFTS[0]
    for shift in _SHIFTS:
        coarse = _pooled(data, costs, shift, within, before - shift)
        ends = tuple((cell[0] >> shift, cell[1] >> shift) for cell in (start, goal))
        waves = [spread(coarse, costs, np.array([[*end, 0.0]])) for end in ends]
        least = float(waves[0][ends[1]])
        if not np.isfinite(least):
            break
        allowed = least * (1.0 + slack) + (_WIDTH + 2.0 * width / (1 << shift)) * NEUTRAL
        within, before = waves[0] + waves[1] <= allowed, shift
        found = (Corridor(within, shift, least * _DOUBTFUL * (1 << shift)), *found)
    return found


def guided(
    look: Callable[[Corridor], T],
    price: Callable[[T], float],
    within: tuple[Corridor, ...],
) -> T:
    """Return what a search finds in the first corridor that it is believed in, else everywhere.

    A search through a corridor is believed unless it came to the goal not at all, or at a price
    that says that the estimate took a door for wider than it is.

    Args:
        look: Searches within a corridor.
        price: What the way to the goal that was found costs, inf where none was.
        within: The corridors.
    """
    for one in within:
        found = look(one)
        if price(found) <= one.price:
            return found
    return look(UNBOUNDED)


@njit(cache=True, inline="always")
def is_outside(within: Corridor, row: int, column: int) -> bool:
    """Tell whether a cell of the map lies outside of a corridor."""
    bounded = within.open.shape[0] > 0
    return bounded and not within.open[row >> within.shift, column >> within.shift]


@njit(cache=True)
def _pooled(
    data: NDArray[np.uint8],
    costs: NDArray[np.float32],
    shift: int,
    within: NDArray[np.bool_],
    ratio: int,
) -> NDArray[np.uint8]:
    """Return each coarse cell's value, LETHAL where none of its cells is open or it is outside."""
    height, width = data.shape
    size = 1 << shift
    rows, columns = (height + size - 1) // size, (width + size - 1) // size
    result = np.full((rows, columns), LETHAL, np.uint8)
    bounded = within.shape[0] > 0
    for row in range(rows):
        for column in range(columns):
            if bounded and not within[row >> ratio, column >> ratio]:
                continue
            total, count = 0, 0
            for r in range(row * size, min((row + 1) * size, height)):
                for c in range(column * size, min((column + 1) * size, width)):
                    if costs[data[r, c]] < np.inf:
                        total += min(data[r, c], INSCRIBED - 1)
                        count += 1
            if count > 0:
                blocked = _BLOCKED - _BLOCKED * count // (size * size)
                result[row, column] = min(total // count + blocked, INSCRIBED - 1)
    return result
