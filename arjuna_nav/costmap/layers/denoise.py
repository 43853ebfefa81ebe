"""The layer that sets groups of lethal cells free that are too small to be anything."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from scipy import ndimage

from arjuna_core.arrays import Bytes
from arjuna_core.config import param
from arjuna_nav.costmap.costmap import FREE, LETHAL
from arjuna_nav.costmap.layers.base import Layer
from arjuna_nav.costmap.window import Window


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
            sides_alone = self.config.group_connectivity_type == 4
            groups, _ = ndimage.label(costs == LETHAL, None if sides_alone else np.ones((3, 3)))
            small = np.bincount(groups.ravel()) < self.config.minimal_group_size
            small[0] = False  # what is not lethal
            costs[small[groups]] = FREE
