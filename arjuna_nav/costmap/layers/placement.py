"""Maps as a costmap sees them: their cells under the costmap's, wherever their frame lies."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from arjuna_core.grid import GridFrame, OccupancyGrid
from arjuna_core.se2 import IDENTITY, SE2

V = TypeVar("V", np.uint8, np.int8)


@dataclass(frozen=True, eq=False)
class PlacedMap:
    """A map and the frame it lies in.

    Attributes:
        grid: The map.
        frame_id: Its frame; empty for the costmap's own.
    """

    grid: OccupancyGrid
    frame_id: str = ""


@dataclass(frozen=True, eq=False)
class MapUpdate:
    """A part of a map.

    Attributes:
        row: Of its first cell in the map.
        column: Likewise.
        data: `(height, width) int8` occupancy.
    """

    row: int
    column: int
    data: NDArray[np.int8]


class Placement:
    """Which cells of a map the cells of a costmap lie in.

    Args:
        frame: The costmap's.
        T_global_map: Maps coordinates of the map's frame into the costmap's.
        own: The map's.

    Attributes:
        frame: The costmap's.
        T_global_map: As given.
        covered: `(height, width) bool` which cells of the costmap lie in the map; None for all, and
            the map is the same grid.
    """

    def __init__(self, frame: GridFrame, T_global_map: SE2, own: GridFrame) -> None:
        self.frame, self.T_global_map = frame, T_global_map
        self.covered: NDArray[np.bool_] | None = None
        if T_global_map == IDENTITY and frame == own:
            return
        T_map_costmap = own.origin.inverse() @ T_global_map.inverse() @ frame.origin
        columns, rows = np.meshgrid(*(np.arange(n) + 0.5 for n in frame.shape[::-1]))
        centres = np.column_stack((columns.ravel(), rows.ravel())) * frame.resolution
        x, y = np.floor(T_map_costmap.apply(centres) / own.resolution).astype(np.int64).T
        inside = (y >= 0) & (y < own.height) & (x >= 0) & (x < own.width)
        self.covered = inside.reshape(frame.shape)
        self._cells = y[inside], x[inside]

    def read(self, values: NDArray[V], outside: int) -> NDArray[V]:
        """Return a map's values at the costmap's cells; the same array where both are one grid."""
        if self.covered is None:
            return values
        result = np.full(self.frame.shape, outside, values.dtype)
        result[self.covered] = values[self._cells]
        return result
