"""Groups of lethal cells that are too small to be anything are set free."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from arjuna_nav.costmap.config import DenoiseConfig
from arjuna_nav.costmap.costmap import FREE, LETHAL

_SIDES = np.array([[0, 1], [1, 0], [0, -1], [-1, 0], [1, 1], [1, -1], [-1, 1], [-1, -1]])


def denoise(data: NDArray[np.uint8], config: DenoiseConfig) -> None:
    """Set the groups of a grid `(height, width) uint8` free that have too few lethal cells.

    Groups that the grid's edge cuts count by what of them lies in it.

    Source: nav2_costmap_2d, denoise layer.
    """
    if config.minimal_group_size > 1:
        _denoise(data, config.minimal_group_size, config.group_connectivity_type)


@njit(cache=True)
def _denoise(data: NDArray[np.uint8], least: int, connectivity: int) -> None:
    height, width = data.shape
    seen = np.zeros(data.shape, np.bool_)
    for row in range(height):
        for column in range(width):
            if data[row, column] != LETHAL or seen[row, column]:
                continue
            seen[row, column] = True
            group, k = [(row, column)], 0
            while k < len(group):
                for side in range(connectivity):
                    r, c = group[k][0] + _SIDES[side, 0], group[k][1] + _SIDES[side, 1]
                    inside = 0 <= r < height and 0 <= c < width
                    if inside and data[r, c] == LETHAL and not seen[r, c]:
                        seen[r, c] = True
                        group.append((r, c))
                k += 1
            if len(group) < least:
                for r, c in group:
                    data[r, c] = FREE
