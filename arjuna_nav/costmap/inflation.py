"""Inflation: cost that falls off with the distance from lethal cells."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from arjuna_nav.costmap.config import InflationConfig
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


class Inflation:
    """Spreads cost from lethal cells, exactly by Nav2's formula.

    Stamping a disc on each lethal cell that has a neighbour which is none gives the same costs as a
    distance transform, at a small part of its price (`tests/nav/test_inflation.py` compares).

    Args:
        config: Radius and decay.
        inscribed_radius: The robot's [m].
        resolution: Edge of a cell [m].
    """

    def __init__(self, config: InflationConfig, inscribed_radius: float, resolution: float) -> None:
        reach = math.ceil(config.inflation_radius / resolution - 1e-9)  # Nav2 rounds up
        self._inflate_unknown = config.inflate_unknown
        self._stamp = np.zeros((2 * reach + 1, 2 * reach + 1), dtype=np.uint8)
        for row, column in np.ndindex(self._stamp.shape):
            cells = math.hypot(row - reach, column - reach)
            if cells <= reach:
                self._stamp[row, column] = cost_at_distance(
                    cells * resolution, inscribed_radius, config.cost_scaling_factor
                )

    def apply(self, data: NDArray[np.uint8]) -> None:
        """Inflate a grid `(height, width) uint8` in place; unknown stays so outside 253."""
        _stamp_all(data, self._stamp, self._inflate_unknown)


@njit(cache=True)
def _stamp_all(data: NDArray[np.uint8], stamp: NDArray[np.uint8], inflate_unknown: bool) -> None:
    height, width = data.shape
    reach = stamp.shape[0] // 2
    inflated = np.zeros((height, width), np.uint8)
    for row in range(height):
        for column in range(width):
            if data[row, column] != LETHAL or _is_interior(data, row, column):
                continue
            for r in range(max(row - reach, 0), min(row + reach + 1, height)):
                for c in range(max(column - reach, 0), min(column + reach + 1, width)):
                    cost = stamp[r - row + reach, c - column + reach]
                    if cost > inflated[r, c]:
                        inflated[r, c] = cost
    least = 1 if inflate_unknown else INSCRIBED
    for row in range(height):
        for column in range(width):
            cost, old = inflated[row, column], data[row, column]
            if (old == UNKNOWN and cost >= least) or (old != UNKNOWN and cost > old):
                data[row, column] = cost


@njit(cache=True)
def _is_interior(data: NDArray[np.uint8], row: int, column: int) -> bool:
    """Tell whether all eight neighbours are lethal: then this cell is nobody's nearest."""
    height, width = data.shape
    if row == 0 or column == 0 or row == height - 1 or column == width - 1:
        return False
    for r in range(row - 1, row + 2):
        for c in range(column - 1, column + 2):
            if data[r, c] != LETHAL:
                return False
    return True
