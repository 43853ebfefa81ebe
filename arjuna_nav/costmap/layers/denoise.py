"""The layer that sets groups of lethal cells free that are too small to be anything."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numba import njit

from arjuna_core.arrays import Bytes
from arjuna_core.config import param
from arjuna_nav.costmap.costmap import FREE, LETHAL
from arjuna_nav.costmap.layers.base import Layer
from arjuna_nav.costmap.window import Window

_SIDES = np.array([[0, 1], [1, 0], [0, -1], [-1, 0], [1, 1], [1, -1], [-1, 1], [-1, -1]])


@dataclass(frozen=True)
class DenoiseConfig:
    """Parameters of the denoise layer."""

    enabled: bool = param(True, "Whether the layer takes part.")
    minimal_group_size: int = param(2, "Cells of the smallest group that stays; all do below 2.")
    group_connectivity_type: int = param(
        8, "Neighbours that a cell is in a group with.", choices=(4, 8)
    )


class DenoiseLayer(Layer):
    """Sets the groups free that have too few lethal cells, of what the layers before it wrote.

    Source: nav2_costmap_2d, denoise layer.
    """

    Config: ClassVar[type[Any]] = DenoiseConfig

    @property
    def reach(self) -> int:
        """A group that is small lies wholly within so much [cells]."""
        return max(int(self.config.minimal_group_size), 0)

    def write(self, costs: Bytes, window: Window) -> None:
        """Set small groups free; those that the window's edge cuts count by what lies in it."""
        if self.config.minimal_group_size > 1:
            _denoise(costs, self.config.minimal_group_size, self.config.group_connectivity_type)


@njit(cache=True)
def _denoise(data: Bytes, least: int, connectivity: int) -> None:
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
