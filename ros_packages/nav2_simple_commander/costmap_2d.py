"""PyCostmap2D: a costmap's message as cells with costs, under the original's names."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np


def value_of(attribute: str) -> Callable[[Any], Any]:
    """Return a method that returns an attribute, as the originals have one for each."""
    return lambda self: getattr(self, attribute)


class PyCostmap2D:
    """The cells of a `nav2_msgs/Costmap`, or of a `nav_msgs/OccupancyGrid`.

    Attributes:
        costmap: The costs, row by row from the lowest in y, `(size_x * size_y,) uint8`.
    """

    def __init__(self, occupancy_map: Any) -> None:
        if hasattr(occupancy_map, "metadata"):
            about = occupancy_map.metadata
            self.size_x, self.size_y = int(about.size_x), int(about.size_y)
        else:
            about = occupancy_map.info
            self.size_x, self.size_y = int(about.width), int(about.height)
        self.resolution = float(about.resolution)
        self.origin_x = float(about.origin.position.x)
        self.origin_y = float(about.origin.position.y)
        self.global_frame_id = str(occupancy_map.header.frame_id)
        self.costmap_timestamp = occupancy_map.header.stamp
        self.costmap = np.array(occupancy_map.data).astype(np.uint8)

    getSizeInCellsX = value_of("size_x")
    getSizeInCellsY = value_of("size_y")
    getOriginX = value_of("origin_x")
    getOriginY = value_of("origin_y")
    getResolution = value_of("resolution")
    getGlobalFrameID = value_of("global_frame_id")
    getCostmapTimestamp = value_of("costmap_timestamp")

    def getSizeInMetersX(self) -> float:
        return self.size_x * self.resolution

    def getSizeInMetersY(self) -> float:
        return self.size_y * self.resolution

    def getCostXY(self, mx: int, my: int) -> np.uint8:
        return self.getCostIdx(self.getIndex(mx, my))

    def getCostIdx(self, index: int) -> np.uint8:
        cost: np.uint8 = self.costmap[index]
        return cost

    def setCost(self, mx: int, my: int, cost: int) -> None:
        self.costmap[self.getIndex(mx, my)] = cost

    def mapToWorld(self, mx: int, my: int) -> tuple[float, float]:
        """Return the middle of a cell [m]."""
        x = self.origin_x + (mx + 0.5) * self.resolution
        return x, self.origin_y + (my + 0.5) * self.resolution

    def worldToMap(self, wx: float, wy: float) -> tuple[int, int]:
        """Return the cell of a point [m], also one beyond the costmap, as up to Humble."""
        mx = int((wx - self.origin_x) // self.resolution)
        return mx, int((wy - self.origin_y) // self.resolution)

    def worldToMapValidated(self, wx: float, wy: float) -> tuple[int, int] | tuple[None, None]:
        """Return the cell of a point [m], `(None, None)` where it is outside."""
        mx, my = self.worldToMap(wx, wy)
        inside = 0 <= mx < self.size_x and 0 <= my < self.size_y
        return (mx, my) if inside else (None, None)

    def getIndex(self, mx: int, my: int) -> int:
        return my * self.size_x + mx
