"""Maps and costmaps, with their updates."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from arjuna_core.grid import OccupancyGrid
from arjuna_core.param import param
from arjuna_core.pose3 import Pose3
from bringup.viewing.displays.base import Display, Wanted, settings
from bringup.viewing.drawing.messages import DRAWN
from bringup.viewing.drawing.values import Grid, Parts


class Map(Display):
    """An occupancy grid; `_updates` change cells of it."""

    types = ("nav_msgs/msg/OccupancyGrid",)
    topic, latched = "map", True
    Config = settings(
        color_scheme=param("map", "Colours.", choices=("map", "costmap")),
        alpha=param(0.7, "Opacity of the costs.", minimum=0.0, maximum=1.0),
        height=param(0.0, "Height above the ground.", unit="m", minimum=-1.0, maximum=1.0),
    )
    _grid: Grid | None = None

    def wanted(self) -> tuple[Wanted, ...]:
        updates = Wanted(f"{self.name}_updates", ("map_msgs/msg/OccupancyGridUpdate",), every=True)
        return Wanted(self.name, self.types), updates

    def take(self, message: Any) -> Parts | None:
        if hasattr(message, "info"):
            drawn = DRAWN[self.types[0]]("", message)
            assert isinstance(drawn, Grid)
            self._grid = drawn
        elif self._grid is not None:
            self._grid = replace(self._grid, grid=_updated(self._grid.grid, message))
        else:
            return None
        opacity = self.config.alpha if self.config.color_scheme == "costmap" else None
        x, y, _ = self._grid.pose.position
        pose = Pose3((x, y, self.config.height), self._grid.pose.quaternion)
        return {"": replace(self._grid, opacity=opacity, pose=pose)}


def _updated(grid: OccupancyGrid, message: Any) -> OccupancyGrid:
    """Return a grid with a rectangle of other cells.

    Raises:
        ValueError: It does not lie within the grid.
    """
    x, y, width, height = message.x, message.y, message.width, message.height
    cells = np.asarray(message.data, dtype=np.int8)
    rows, columns = grid.data.shape
    if min(x, y) < 0 or x + width > columns or y + height > rows or cells.size != width * height:
        problem = f"an update of {width} x {height} cells at ({x}, {y})"
        raise ValueError(f"{problem} does not fit into a grid of {columns} x {rows}")
    data = grid.data.copy()
    data[y : y + height, x : x + width] = cells.reshape(height, width)
    return OccupancyGrid(grid.frame, data)
