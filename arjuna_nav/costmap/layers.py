"""The layers of a costmap that hold data of their own: the map, and what the scans saw."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from arjuna_core.grid import GridFrame, OccupancyGrid
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_nav.costmap.config import CostmapConfig, SourceConfig
from arjuna_nav.costmap.costmap import FREE, LETHAL, UNKNOWN
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.costmap.moving.tracker import Moving, Tracker
from arjuna_nav.costmap.moving.ways import free_trails
from arjuna_nav.costmap.raytrace import enter_scan, fill_polygon
from arjuna_nav.costmap.window import Window, clipped, joined, within

_NEAR = 0.35  # beyond the outline: where what moves may yet be when the robot comes [m]

T = TypeVar("T")
C = TypeVar("C", np.uint8, np.uint32)


@dataclass(frozen=True)
class PlacedScan:
    """A scan and where the robot was when it was taken.

    Attributes:
        scan: The scan.
        T_global_base: Pose of the base in the costmap's global frame at the scan's stamp.
    """

    scan: Scan
    T_global_base: SE2


def interpret_map(grid: OccupancyGrid, config: CostmapConfig) -> NDArray[np.uint8]:
    """Return the costs a map's cells have by themselves, `(height, width) uint8`.

    Source: nav2_costmap_2d, static layer: unknown, lethal from the threshold, else free or scaled.
    """
    threshold = config.lethal_cost_threshold
    between = np.zeros(grid.data.shape)
    if not config.trinary_costmap:
        between = np.floor(grid.data.astype(np.float64) / threshold * LETHAL)
    unknown = UNKNOWN if config.track_unknown_space else FREE
    states = [grid.data < 0, grid.data >= threshold]
    return np.select(states, [unknown, LETHAL], between).astype(np.uint8)


class SeenLayer(Generic[T]):
    """What sensors have seen on a grid; it stays until they see otherwise.

    Args:
        frame: Where the grid lies.
        config: The costmap's parameters.
    """

    def __init__(self, frame: GridFrame, config: CostmapConfig) -> None:
        self._untouched = UNKNOWN if config.track_unknown_space else FREE
        self._config = config.obstacle_layer
        self.frame = frame
        self.data: NDArray[np.uint8] = np.full(frame.shape, self._untouched, dtype=np.uint8)

    def move(self, frame: GridFrame) -> None:
        """Continue on another grid of the same resolution; what both cover is kept."""
        self.data = moved(self.data, self.frame, frame, self._untouched)
        self.frame = frame

    def clear(self, window: Window | None = None, outside: bool = False) -> None:
        """Forget what was seen: everywhere, in a window of cells, or outside that window."""
        if window is None:
            self.data.fill(self._untouched)
            return
        kept = self.data[window].copy() if outside else None
        (self.data if outside else self.data[window]).fill(self._untouched)
        if kept is not None:
            self.data[window] = kept

    def merge_into(self, master: NDArray[np.uint8], window: Window) -> None:
        """Take the greater cost of both in a window; what either does not know is the other's."""
        own = self.data[window]
        known = own != UNKNOWN
        take = known & ((master == UNKNOWN) | (own > master))
        master[take] = own[take]

    def update(self, T_global_base: SE2, footprint: Footprint, seen: Sequence[T]) -> Window | None:
        """Enter what was seen in order, then set the robot's own place free.

        Returns:
            The cells that have changed, at least; None where none has.
        """
        near = (T_global_base, footprint.circumscribed_radius)
        touched = self._window([near, *map(self._reach, seen)])
        before = self.data[touched].copy()
        for each in seen:
            self._enter(each)
        if self._config.footprint_clearing_enabled:
            corners = self.frame.origin.inverse().apply(footprint.at(T_global_base))
            self._free(corners / self.frame.resolution)
        return within(touched, self.data[touched] != before)

    def _reach(self, seen: T) -> tuple[SE2, float]:
        """Return a place and how far about it what was seen can change cells [m]."""
        raise NotImplementedError

    def _enter(self, seen: T) -> None:
        """Mark and clear."""
        raise NotImplementedError

    def _free(self, corners: NDArray[np.float64]) -> None:
        """Set the cells within a polygon free, `(N, 2)` x, y in cells."""
        fill_polygon(self.data, corners, FREE)

    def _window(self, boxes: Sequence[tuple[SE2, float]]) -> Window:
        """Return the cells within given distances of places [m]."""
        places = self.frame.origin.inverse().apply(np.array([(p.x, p.y) for p, _ in boxes]))
        reach = np.array([[radius] for _, radius in boxes])
        low, high = (places - reach).min(axis=0), (places + reach).max(axis=0)
        x0, y0 = (math.floor(v / self.frame.resolution) - 1 for v in low.tolist())
        x1, y1 = (math.ceil(v / self.frame.resolution) + 1 for v in high.tolist())
        return clipped(y0, y1, x0, x1, self.data.shape)


class ObstacleLayer(SeenLayer[PlacedScan]):
    """Marks what scans hit and clears what their rays cross; marks stay until a ray clears them.

    What is known to move is marked near the robot alone, for where it is far it will have gone
    before the robot comes; and where it has been is free, seen or not. On a grid that does not go
    with the robot, which ways are planned on, it is not marked at all: to plan round somebody who
    walks by is to turn to and fro, and who drives the way waits for them.

    Attributes:
        hits: `(height, width) uint32` where in its cell each mark lies, as `hit_points` reads it.
        moving: What moves in the last scan.

    Source: nav2_costmap_2d, obstacle layer.
    """

    def __init__(self, frame: GridFrame, config: CostmapConfig) -> None:
        super().__init__(frame, config)
        self.hits: NDArray[np.uint32] = np.zeros(frame.shape, np.uint32)
        self._tracker, self.moving = Tracker(), Moving.nothing()
        self._left: Window | None = None  # by what moves, in this update
        self._goes_along = config.rolling_window
        self._near = 0.0  # as far as it is marked [m]

    def move(self, frame: GridFrame) -> None:
        """Continue on another grid of the same resolution; what both cover is kept."""
        self.hits = moved(self.hits, self.frame, frame, 0)
        super().move(frame)

    def update(
        self, T_global_base: SE2, footprint: Footprint, seen: Sequence[PlacedScan]
    ) -> Window | None:
        """Enter scans in order, then set the robot's own place free.

        Returns:
            The cells that have changed, at least; None where none has.
        """
        self._left = None
        self._near = footprint.circumscribed_radius + _NEAR if self._goes_along else 0.0
        changed = super().update(T_global_base, footprint, seen)
        return joined(self._left, changed)

    def _cells(self, points: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Return the rows and the columns of points `(N, 2)`."""
        places = self.frame.origin.inverse().apply(points) / self.frame.resolution
        columns, rows = np.floor(places).astype(np.int64).T
        return rows, columns

    def _on_grid(self, points: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Tell which points `(N, 2)` lie on the grid."""
        rows, columns = self._cells(points)
        height, width = self.data.shape
        inside: NDArray[np.bool_] = (
            (rows >= 0) & (rows < height) & (columns >= 0) & (columns < width)
        )
        return inside

    def _reach(self, seen: PlacedScan) -> tuple[SE2, float]:
        limits = _limits(seen.scan, self._config.scan)
        return seen.T_global_base @ seen.scan.T_base_sensor, max(limits[3:])

    def _enter(self, seen: PlacedScan) -> None:
        if self._config.moving_time > 0.0:
            self.moving = self._tracker.update(seen.scan, seen.T_global_base)
        left = free_trails(self.data, self.moving.things, self.frame, FREE)
        self._left = joined(self._left, left)
        ends = self.moving.points[self.moving.velocities.any(axis=1)]
        ends = ends[self._on_grid(ends)]
        rows, columns = self._cells(ends)
        free = self.data[rows, columns] != LETHAL
        self._enter_scan(seen)
        at = seen.T_global_base
        far = free & (np.hypot(ends[:, 0] - at.x, ends[:, 1] - at.y) > self._near)
        self.data[rows[far], columns[far]] = FREE

    def _enter_scan(self, seen: PlacedScan) -> None:
        source, scan = self._config.scan, seen.scan
        T_grid_sensor = self.frame.origin.inverse() @ seen.T_global_base @ scan.T_base_sensor
        enter_scan(
            self.data,
            self.hits,
            T_grid_sensor.array() / (self.frame.resolution, self.frame.resolution, 1.0),
            scan.ranges / self.frame.resolution,
            scan.angles,
            np.array(_limits(scan, source)) / self.frame.resolution,
            source.clearing,
            source.marking,
        )


def _limits(scan: Scan, source: SourceConfig) -> tuple[float, ...]:
    """Return the ranges [m] that bound a scan's validity, clearing and marking."""
    return (
        scan.range_min,
        scan.range_max,
        source.raytrace_min_range,
        source.raytrace_max_range if source.inf_is_valid else -1.0,
        source.raytrace_max_range,
        source.obstacle_min_range,
        source.obstacle_max_range,
    )


def moved(data: NDArray[C], old: GridFrame, new: GridFrame, fill: int) -> NDArray[C]:
    """Return what a grid holds on another of the same resolution, where both cover it.

    Args:
        data: `(height, width)`; returned itself where the grids are the same.
        old: Where it lies.
        new: Where the result lies.
        fill: What else the result holds.
    """
    if new == old:
        return data
    result = np.full(new.shape, fill, dtype=data.dtype)
    shift = old.origin.inverse() @ new.origin
    row, column = (round(v / new.resolution) for v in (shift.y, shift.x))
    turned = abs(shift.theta) * max(new.width, new.height) > 0.5
    if new.resolution == old.resolution and not turned:
        _copy_overlap(data, result, row, column)
    return result


def _copy_overlap(old: NDArray[C], new: NDArray[C], row: int, column: int) -> None:
    """Copy what lies in both, where `new[0, 0]` lies at `old[row, column]`."""
    rows = slice(max(row, 0), min(row + new.shape[0], old.shape[0]))
    columns = slice(max(column, 0), min(column + new.shape[1], old.shape[1]))
    if rows.start < rows.stop and columns.start < columns.stop:
        target = (
            slice(rows.start - row, rows.stop - row),
            slice(columns.start - column, columns.stop - column),
        )
        new[target] = old[rows, columns]
