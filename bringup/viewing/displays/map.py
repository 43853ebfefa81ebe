"""Maps and costmaps, with their updates, and cells."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from arjuna_core.grid import replace_cells
from arjuna_core.param import param, share_param
from arjuna_core.pose3 import Pose3
from arjuna_core.readings import grid_from_msg
from bringup.viewing.displays.base import Display, Wanted
from bringup.viewing.drawing.messages import frame_of
from bringup.viewing.drawing.solids import solids
from bringup.viewing.drawing.values import Colour, Grid, Parts


class Map(Display):
    """An occupancy grid; `_updates` change cells of it."""

    types = ("nav_msgs/msg/OccupancyGrid",)
    topic, latched = "map", True

    @dataclass(frozen=True)
    class Config:
        color_scheme: str = param("map", "Colours.", choices=("map", "costmap"))
        alpha: float = share_param(0.7, "Opacity of the costs.")
        height: float = param(0.0, "Height above the ground.", unit="m", minimum=-1.0, maximum=1.0)

    _grid: Grid | None = None

    def wanted(self) -> tuple[Wanted, ...]:
        updates = Wanted(f"{self.name}_updates", ("map_msgs/msg/OccupancyGridUpdate",), every=True)
        return Wanted(self.name, self.types), updates

    def take(self, message: Any) -> Parts | None:
        if hasattr(message, "info"):
            self._grid = Grid(frame=frame_of(message), grid=grid_from_msg(message))
        elif self._grid is not None:
            data = self._grid.grid.data.copy()
            size = message.width, message.height
            replace_cells(data, message.x, message.y, *size, message.data)
            self._grid = replace(self._grid, grid=replace(self._grid.grid, data=data))
        else:
            return None
        opacity = self.config.alpha if self.config.color_scheme == "costmap" else None
        pose = Pose3.from_se2(self._grid.grid.frame.origin, self.config.height)
        return {"": replace(self._grid, opacity=opacity, pose=pose)}


class GridCells(Display):
    """Cells as flat squares."""

    types = ("nav_msgs/msg/GridCells",)
    topic = "grid_cells"

    @dataclass(frozen=True)
    class Config:
        color: Colour = param((25, 255, 0), "Colour.")
        alpha: float = share_param(1.0, "Opacity.")

    def take(self, message: Any) -> Parts:
        size = (message.cell_width, message.cell_height, 0.01)
        if not min(size) > 0.0:
            raise ValueError(f"its cells are {size[0]:g} x {size[1]:g} m")
        style = (1.0, 0.0, 0.0, 0.0), size, self.config.color, self.config.alpha
        rows = [((at.x, at.y, at.z), *style) for at in message.cells]
        return {"": solids("box", rows, frame=frame_of(message))}
