"""Inflation: cost that falls off with the distance from lethal cells."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
from numba import njit
from numpy.typing import NDArray

from arjuna_core.arrays import Bytes, Floats
from arjuna_nav.costmap.costmap import INSCRIBED, LETHAL, MAX_NON_OBSTACLE, UNKNOWN


def cost_at_distance(distance: float, inscribed_radius: float, cost_scaling_factor: float) -> int:
    """Return the cost at a distance from the nearest lethal cell.

    Args:
        distance: Between the cells' centres [m].
        inscribed_radius: The robot's [m].
        cost_scaling_factor: Decay [1/m].

    Source: nav2_costmap_2d, inflation layer, computeCost.
    """
    if distance == 0.0:
        return LETHAL
    if distance <= inscribed_radius:
        return INSCRIBED
    return int(MAX_NON_OBSTACLE * math.exp(-cost_scaling_factor * (distance - inscribed_radius)))


@cache
def clearances(cost_scaling_factor: float) -> Floats:
    """Return how far beyond its inscribed radius a robot is where a cost is, `(256,)` [m].

    `cost_at_distance` turned round: 0 from 253 on, inf for cells that cost nothing or are unknown.
    """
    result = np.full(256, np.inf)
    costs = np.arange(1, INSCRIBED)
    if cost_scaling_factor > 0.0:
        result[1:INSCRIBED] = -np.log(costs / MAX_NON_OBSTACLE) / cost_scaling_factor
    result[INSCRIBED : LETHAL + 1] = 0.0
    return result


class Inflation:
    """Spreads cost from lethal cells, exactly by Nav2's formula, whatever the clutter.

    Args:
        radius: Over which cost is spread [m].
        cost_scaling_factor: Decay [1/m].
        inscribed_radius: The robot's [m].
        resolution: Edge of a cell [m].
        inflate_unknown: Whether unknown cells take any cost, not only that of a collision.
        around_unknown: Whether cost spreads from unknown cells too; they become lethal.

    Attributes:
        reach: How far cost spreads [cells].

    Source: Felzenszwalb and Huttenlocher, Distance transforms of sampled functions, 2012: columns,
        then rows, here by trying each shift up to the reach, which the processor does by vectors.
    """

    def __init__(
        self,
        radius: float,
        cost_scaling_factor: float,
        inscribed_radius: float,
        resolution: float,
        inflate_unknown: bool = False,
        around_unknown: bool = False,
    ) -> None:
        self.reach = math.ceil(radius / resolution - 1e-9)  # Nav2 rounds up
        self._inflate_unknown, self._around_unknown = inflate_unknown, around_unknown
        squares = range(self.reach**2 + 1)
        distances = (math.sqrt(square) * resolution for square in squares)
        costs = [cost_at_distance(d, inscribed_radius, cost_scaling_factor) for d in distances]
        self._costs = np.array(costs, dtype=np.uint8)

    def apply(self, data: Bytes) -> None:
        """Inflate a grid `(height, width) uint8` in place; unknown stays so outside 253."""
        if self._around_unknown:
            data[data == UNKNOWN] = LETHAL
        _inflate(data, self._costs, self.reach, self._inflate_unknown)


@njit(cache=True)
def _inflate(data: Bytes, costs: Bytes, reach: int, inflate_unknown: bool) -> None:
    """Inflate in place; `costs` has the cost of each squared distance in cells."""
    height, width = data.shape
    far = np.uint16(reach + 1)
    gaps = np.empty((height + 1, width), np.uint16)  # to the nearest lethal cell of the column
    above = np.full(width, far, np.uint16)
    for row in range(height):
        here = gaps[row]
        for column in range(width):
            gap = min(above[column] + 1, far)
            here[column] = 0 if data[row, column] == LETHAL else gap
        above = here
    gaps[height] = far
    squares = np.empty(width + 2 * reach, np.int32)
    nearest = np.empty(width, np.int32)
    for row in range(height - 1, -1, -1):
        here, below, least = gaps[row], gaps[row + 1], far
        for column in range(width):
            gap = min(here[column], min(below[column] + 1, far))
            here[column] = gap
            least = min(least, gap)
        if least < far:
            _nearest(here, far, reach, squares, nearest)
            _merge(data[row], nearest, costs, inflate_unknown)


@njit(cache=True)
def _nearest(
    gaps: NDArray[np.uint16],
    far: int,
    reach: int,
    squares: NDArray[np.int32],
    nearest: NDArray[np.int32],
) -> None:
    """Fill the squared distances [cells] of a row's cells to the nearest lethal one."""
    width = len(gaps)
    squares[:] = 2 * far * far
    middle = squares[reach : reach + width]
    for column in range(width):
        gap = np.int32(gaps[column])
        middle[column] = gap * gap if gap < far else 2 * far * far
    nearest[:] = middle
    for shift in range(1, reach + 1):
        left, right = squares[reach - shift :], squares[reach + shift :]
        square = np.int32(shift * shift)
        for column in range(width):
            nearest[column] = min(nearest[column], min(left[column], right[column]) + square)


@njit(cache=True)
def _merge(row: Bytes, nearest: NDArray[np.int32], costs: Bytes, inflate_unknown: bool) -> None:
    """Raise a row's costs to what their distances cost."""
    least = 1 if inflate_unknown else INSCRIBED
    for column in range(len(row)):
        if nearest[column] >= len(costs):
            continue
        cost, old = costs[nearest[column]], row[column]
        if (old == UNKNOWN and cost >= least) or (old != UNKNOWN and cost > old):
            row[column] = cost
