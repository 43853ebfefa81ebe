"""The layer that holds a map, wherever its frame lies in the costmap's."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numba import njit
from numpy.typing import NDArray

from arjuna_core.arrays import Bools, Bytes, Floats
from arjuna_core.config import fixed, param
from arjuna_core.grid import GridFrame, OccupancyGrid
from arjuna_core.se2 import IDENTITY, SE2
from arjuna_core.transforms import TransformError
from arjuna_nav.costmap.config import CostmapConfig
from arjuna_nav.costmap.costmap import FREE, LETHAL, UNKNOWN
from arjuna_nav.costmap.layers.base import Input, Layer, Master, absolute, combine
from arjuna_nav.costmap.raytrace import fill_polygon
from arjuna_nav.costmap.window import Window, clipped, joined, whole, within


@dataclass(frozen=True)
class StaticConfig:
    """Parameters of the static layer."""

    enabled: bool = param(True, "Whether the layer takes part.")
    map_topic: str = fixed("", "Topic of the map; empty takes the costmap's own.")
    map_subscribe_transient_local: bool = fixed(True, "Whether the map's publisher latches.")
    subscribe_to_updates: bool = fixed(
        False, "Whether to take parts of the map from its topic with '_updates'."
    )
    transform_tolerance: float = param(
        0.0, "Unused: the latest transform is taken, and nothing waits for it.", unit="s"
    )
    footprint_clearing_enabled: bool = param(
        False, "Whether the map is free where the robot stands."
    )
    restore_cleared_footprint: bool = param(
        True, "Whether the map is as before where the robot has left."
    )


def interpret_map(data: NDArray[np.int8], config: CostmapConfig) -> Bytes:
    """Return the costs that a map's cells have by themselves, `(height, width) uint8`.

    Source: nav2_costmap_2d, static layer: unknown, lethal from the threshold, else free or scaled.
    """
    threshold = min(max(config.lethal_cost_threshold, 0), 100)
    occupancy = data.astype(np.uint8)  # as there: -1 is 255
    between = np.zeros(data.shape)
    if not config.trinary_costmap:
        between = np.floor(occupancy.astype(np.float64) / max(threshold, 1) * LETHAL)
    unknown = UNKNOWN if config.track_unknown_space else FREE
    states = [occupancy == config.unknown_cost_value & 255, occupancy >= threshold]
    return np.select(states, [unknown, LETHAL], between).astype(np.uint8)


class MapLayer(Layer):
    """A layer that holds a map, and what its cells cost."""

    def __init__(self, config: Any, name: str, master: Master) -> None:
        super().__init__(config, name, master)
        self._map: PlacedMap | None = None
        self._costs: Bytes = np.zeros((0, 0), np.uint8)  # of the map's cells
        self._placement: Placement | None = None
        self._shown: Bytes = self._costs  # of the costmap's cells
        self._dropped = False  # since the last update, so that what was shown changes
        self._problem = ""

    def problem(self, now: float) -> str:
        return self._problem

    def _locate(self) -> SE2 | None:
        """Return where the map's frame lies in the costmap's; None where that is not known."""
        assert self._map is not None
        try:
            T_global_map, self._problem = self.master.locate(self._map.frame_id), ""
        except TransformError as error:
            self._problem = str(error)
            return None
        return T_global_map

    def _drop(self) -> None:
        """Show nothing until the map is placed again: it is another."""
        self._placement, self._dropped = None, True

    def _place(self, T_global_map: SE2 | None) -> None:
        """Read the map's costs at the costmap's cells, where either has moved."""
        frame, placement = self.master.frame, self._placement
        if self._map is None or T_global_map is None:
            self._placement = None
        elif placement is None or (placement.frame, placement.T_global_map) != (
            frame,
            T_global_map,
        ):
            self._placement = Placement(frame, T_global_map, self._map.grid.frame)
            self._shown = self._read(self._placement)

    def _read(self, placement: Placement) -> Bytes:
        """Return the map's costs at the costmap's cells."""
        return placement.read(self._costs, UNKNOWN)


class StaticLayer(MapLayer):
    """Holds a map. A fixed costmap takes its grid, a rolling one a part of it.

    Source: nav2_costmap_2d, static layer.
    """

    Config: ClassVar[type[Any]] = StaticConfig

    def __init__(self, config: StaticConfig, name: str, master: Master) -> None:
        super().__init__(config, name, master)
        self._T_global_map = None if master.config.rolling_window else IDENTITY
        self._before: tuple[Window, Bytes] | None = None  # where it is cleared
        self._updated: Window | None = None  # cells of the map that have changed

    @property
    def frame(self) -> GridFrame | None:
        return self._map.grid.frame if self._map is not None else None

    def inputs(self) -> tuple[Input, ...]:
        config = self.config
        topic = config.map_topic or self.master.config.map_topic
        latched = config.map_subscribe_transient_local
        updates = Input("updates", f"{topic}_updates", "OccupancyGridUpdate")
        taken = (updates,) if config.subscribe_to_updates else ()
        return (Input("map", topic, "OccupancyGrid", latched=latched), *taken)

    def receive(self, source: str, value: PlacedMap | MapUpdate) -> None:
        if isinstance(value, PlacedMap):
            self._map, self._before, self._updated = value, None, None
            self._drop()
            self._costs = interpret_map(value.grid.data, self.master.config)
            return
        rows, columns = (
            slice(start, start + size)
            for start, size in zip((value.row, value.column), value.data.shape, strict=True)
        )
        height, width = self._costs.shape
        if rows.start >= 0 and rows.stop <= height and columns.start >= 0 and columns.stop <= width:
            self._restore()
            self._costs[rows, columns] = interpret_map(value.data, self.master.config)
            self._updated = joined(self._updated, (rows, columns))

    def missing(self) -> str:
        topic = self.inputs()[0].topic
        return "" if self._map is not None else f"no map has come on {absolute(topic)}"

    def update(self, T_global_base: SE2, now: float) -> Window | None:
        if self._map is None:
            return None
        if self.master.config.rolling_window:
            self._T_global_map = self._locate()
        if self._T_global_map is not None and self.config.footprint_clearing_enabled:
            self._clear_footprint(self._T_global_map.inverse() @ T_global_base)
        before, changed, self._updated = self._placement, self._updated, None
        if before is not None and before.covered is not None and changed is not None:
            self._placement = None
        self._place(self._T_global_map)
        same, self._dropped = self._placement is before and not self._dropped, False
        return changed if same else whole(self.master.frame.shape)

    def write(self, costs: Bytes, window: Window) -> None:
        self._place(self._T_global_map)
        self._dropped &= window != whole(self.master.frame.shape)
        if self._placement is None:
            return
        own, covered = self._shown[window], self._placement.covered
        if self.master.config.use_maximum:
            combine(costs, own, 1)
        elif covered is None:
            costs[:] = own
        else:
            np.copyto(costs, own, where=covered[window])

    def own_costs(self) -> Bytes | None:
        return self._shown if self._placement is not None else None

    def _clear_footprint(self, T_map_base: SE2) -> None:
        assert self._map is not None
        self._restore()
        frame = self._map.grid.frame
        corners = frame.origin.inverse().apply(self.master.footprint.at(T_map_base))
        corners /= frame.resolution
        (x0, y0), (x1, y1) = np.floor(corners.min(axis=0)), np.ceil(corners.max(axis=0))
        window = clipped(int(y0), int(y1), int(x0), int(x1), frame.shape)
        before = self._costs[window].copy()
        fill_polygon(self._costs, corners, FREE)
        if self.config.restore_cleared_footprint:
            self._before = window, before
        self._updated = joined(self._updated, within(window, self._costs[window] != before))

    def _restore(self) -> None:
        """Undo the clearing under the robot."""
        if self._before is not None:
            window, costs = self._before
            self._costs[window], self._before = costs, None
            self._updated = joined(self._updated, window)


@dataclass(frozen=True, eq=False)
class PlacedMap:
    """A map and the frame it lies in.

    Attributes:
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
    """Cells of a map in which the cells of a costmap lie.

    Attributes:
        T_global_map: As given.
        covered: `(height, width) bool` which cells of the costmap lie in the map; None for all, and
            the map is the same grid.
    """

    def __init__(self, frame: GridFrame, T_global_map: SE2, own: GridFrame) -> None:
        self.frame, self.T_global_map, self._own = frame, T_global_map, own
        self.covered: Bools | None = None
        if T_global_map == IDENTITY and frame == own:
            return
        self._T_own_frame = own.origin.inverse() @ T_global_map.inverse() @ frame.origin
        columns, rows = np.meshgrid(*(np.arange(n) + 0.5 for n in frame.shape[::-1]))
        centres = np.column_stack((columns.ravel(), rows.ravel())) * frame.resolution
        x, y = np.floor(self._T_own_frame.apply(centres) / own.resolution).astype(np.int64).T
        inside = (y >= 0) & (y < own.height) & (x >= 0) & (x < own.width)
        self.covered = inside.reshape(frame.shape)
        self._cells = y[inside], x[inside]

    def read(self, values: Bytes, outside: int) -> Bytes:
        """Return a map's values at the costmap's cells; the same array where both are one grid."""
        if self.covered is None:
            return values
        result = np.full(self.frame.shape, outside, values.dtype)
        result[self.covered] = values[self._cells]
        return result

    def read_worst(self, costs: Bytes) -> Bytes:
        """Return the greatest known cost of a map in each of the costmap's cells, as `read` does.

        At points no farther apart than the map's cells; those that only share an edge do not count.
        """
        if self.covered is None:
            return costs
        edge, result = self._own.resolution, np.empty(self.frame.shape, np.uint8)
        steps = np.linspace(0.01, 0.99, max(math.ceil(self.frame.resolution / edge) + 1, 3))
        transform = self._T_own_frame.array() / (edge, edge, 1.0)
        _read_worst(costs, result, transform, self.frame.resolution / edge, steps)
        return result


@njit(cache=True)
def _read_worst(
    costs: Bytes, result: Bytes, transform: Floats, scale: float, steps: Floats
) -> None:
    """Write the greatest known cost at points of each cell of a grid.

    Args:
        costs: Of a map's cells.
        result: Written to.
        transform: `(3,)` of the result's grid in the map's [cells, cells, rad].
        scale: Edge of the result's cells [cells of the map].
        steps: Where the points lie along the edges of a cell.
    """
    c, s = scale * math.cos(transform[2]), scale * math.sin(transform[2])
    for row in range(result.shape[0]):
        for column in range(result.shape[1]):
            worst = -1
            for dy in steps:
                for dx in steps:
                    x, y = column + dx, row + dy
                    i = math.floor(s * x + c * y + transform[1])
                    j = math.floor(c * x - s * y + transform[0])
                    if 0 <= i < costs.shape[0] and 0 <= j < costs.shape[1]:
                        cost = int(costs[i, j])
                        worst = max(worst, cost if cost != UNKNOWN else -1)
            result[row, column] = worst if worst >= 0 else UNKNOWN
