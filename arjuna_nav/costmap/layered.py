"""The costmap of layers: map, then obstacles, cleaned of noise, then inflation."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from arjuna_core.grid import GridFrame, OccupancyGrid
from arjuna_core.se2 import SE2
from arjuna_nav.costmap.config import CostmapConfig
from arjuna_nav.costmap.costmap import FREE, UNKNOWN, Costmap
from arjuna_nav.costmap.denoise import denoise
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.costmap.inflation import Inflation, clearances, cost_at_distance
from arjuna_nav.costmap.layers import ObstacleLayer, PlacedScan, interpret_map
from arjuna_nav.costmap.moving.ways import Patch, ways
from arjuna_nav.costmap.ranges import PlacedRange, RangeLayer
from arjuna_nav.costmap.voxels import PlacedCloud, VoxelLayer
from arjuna_nav.costmap.window import Window, grown, joined, seen_in, whole


class LayeredCostmap:
    """Combines the layers into one costmap, fixed to the map or rolling with the robot.

    A change costs what its window costs, not what the map does: only there the layers are composed
    and inflated again, in place.

    Args:
        config: Parameters.
    """

    def __init__(self, config: CostmapConfig) -> None:
        self._config = config
        self.footprint = Footprint.parse(
            config.footprint, config.robot_radius, config.footprint_padding
        )
        frame = _own_frame(config)
        self._map: NDArray[np.uint8] | None = None
        self._obstacles = ObstacleLayer(frame, config)
        uses_clouds = "cloud" in config.obstacle_layer.observation_sources
        self._voxels = VoxelLayer(frame, config) if uses_clouds else None
        self._ranges = RangeLayer(frame, config) if "range_layer" in config.plugins else None
        seen = (self._obstacles, self._voxels, self._ranges)
        self._seen = [layer for layer in seen if layer is not None]
        self._inflation = self._make_inflation()
        self._stamp = 0.0
        self._changed: Window | None = None
        self._laid: Patch | None = None
        self._compose_all()

    @property
    def costmap(self) -> Costmap:
        """The costs as of now; the next change may be made in the same array."""
        return self._costmap

    def take_changed(self) -> Window | None:
        """Return what has changed since the last call, None where nothing has."""
        changed, self._changed = self._changed, None
        return changed

    @property
    def has_map(self) -> bool:
        """Whether the map came that the static layer needs; True where there is no such layer."""
        return self._map is not None or not self._uses("static_layer")

    def set_footprint(self, footprint: Footprint) -> None:
        """Take another outline of the robot from now on."""
        self.footprint = footprint
        self._inflation = self._make_inflation()
        self._compose_all()

    def set_map(self, grid: OccupancyGrid) -> None:
        """Take a map; the costmap takes its size and place, and keeps the obstacles seen."""
        self._map = interpret_map(grid, self._config)
        self._move(grid.frame)
        self._inflation = self._make_inflation()
        self._compose_all()

    def update(
        self,
        T_global_base: SE2,
        now: float,
        scans: Sequence[PlacedScan],
        clouds: Sequence[PlacedCloud] = (),
        ranges: Sequence[PlacedRange] = (),
    ) -> None:
        """Bring the costmap up to date.

        Args:
            T_global_base: Pose of the robot in the costmap's global frame.
            now: Time of the update [s].
            scans: What came since the last update, oldest first.
            clouds: The same.
            ranges: The same.
        """
        self._stamp = now
        self._lift()
        before, changed = self._obstacles.frame, None
        if self._config.rolling_window:
            self._move(_rolled(before, T_global_base))
        if self._uses("obstacle_layer"):
            changed = self._obstacles.update(T_global_base, self.footprint, scans)
            if self._voxels is not None and scans:
                changed = joined(changed, self._voxels.leave(self._obstacles.moving.things))
        if self._voxels is not None and self._uses("obstacle_layer"):
            changed = joined(changed, self._voxels.update(T_global_base, self.footprint, clouds))
        if self._ranges is not None and self._uses("range_layer"):
            changed = joined(changed, self._ranges.update(T_global_base, self.footprint, ranges))
        if self._obstacles.frame != before:
            self._compose_all()
        else:
            self._compose(changed)
        self._tell_moving()
        self._lay()

    def clear_entirely(self) -> None:
        """Forget all obstacles seen; the map stays."""
        for layer in self._seen:
            layer.clear()
        self._compose_all()

    def clear_around(self, T_global_base: SE2, reset_distance: float) -> None:
        """Forget the obstacles in a square of edge `reset_distance` [m] round a pose."""
        for layer in self._seen:
            layer.clear(self._square(T_global_base, reset_distance))
        self._compose_all()

    def clear_except(self, T_global_base: SE2, reset_distance: float) -> None:
        """Forget the obstacles outside a square of edge `reset_distance` [m] round a pose."""
        for layer in self._seen:
            layer.clear(self._square(T_global_base, reset_distance), outside=True)
        self._compose_all()

    def _move(self, frame: GridFrame) -> None:
        for layer in self._seen:
            layer.move(frame)

    def _compose_all(self) -> None:
        """Make the whole costmap anew."""
        frame = self._obstacles.frame
        data = self._layers(whole(frame.shape))
        self._costmap = Costmap(
            frame,
            data,
            self._stamp,
            self._circumscribed_cost(),
            self._clearances(),
            self._obstacles.hits,
        )
        self._changed, self._laid = whole(frame.shape), None

    def _compose(self, changed: Window | None) -> None:
        """Compose what is within the inflation's reach of a change."""
        self._costmap = replace(self._costmap, stamp=self._stamp)
        if changed is None:
            return
        shape = self._costmap.data.shape
        reach = self._inflation.reach if self._uses("inflation_layer") else 0
        if self._uses("denoise_layer"):  # a group that is small lies wholly within so much
            reach += self._config.denoise_layer.minimal_group_size
        window = grown(changed, reach, shape)
        source = grown(window, reach, shape)
        self._costmap.data[window] = self._layers(source)[seen_in(window, source)]
        self._changed = joined(self._changed, window)

    def _tell_moving(self) -> None:
        """Say in the costmap where things are that move."""
        things = self._obstacles.moving.things
        places = self._obstacles.frame.origin.inverse().apply(things[:, :2])
        self._costmap = replace(self._costmap, moving=np.column_stack((places, things[:, 4])))

    def _lay(self) -> None:
        """Lay the costs of ways over the others; they change by themselves, and are not mixed."""
        layer, moving = self._config.obstacle_layer, self._obstacles.moving
        since = self._stamp - moving.stamp
        if not self._uses("obstacle_layer") or not 0.0 <= since <= layer.moving_time:
            return
        radius, frame = self.footprint.inscribed_radius, self._obstacles.frame
        patch = ways(moving.things, since, layer.moving_time, radius, frame)
        if patch is not None:
            below = self._costmap.data[patch.window]
            self._laid = Patch(patch.window, below.copy())
            np.maximum(below, patch.costs, out=below)
            self._changed = joined(self._changed, patch.window)

    def _lift(self) -> None:
        """Take off what was laid over."""
        if self._laid is not None:
            self._costmap.data[self._laid.window] = self._laid.costs
            self._changed = joined(self._changed, self._laid.window)
            self._laid = None

    def _layers(self, window: Window) -> NDArray[np.uint8]:
        """Return the costs of a window, as if there were nothing outside it."""
        unknown = UNKNOWN if self._config.track_unknown_space else FREE
        shape = (window[0].stop - window[0].start, window[1].stop - window[1].start)
        data = np.full(shape, unknown, dtype=np.uint8)
        if self._map is not None and self._uses("static_layer"):
            data[:] = self._map[window]
        for layer in self._seen:
            if self._uses("range_layer" if layer is self._ranges else "obstacle_layer"):
                layer.merge_into(data, window)
        if self._uses("denoise_layer"):
            denoise(data, self._config.denoise_layer)
        if self._uses("inflation_layer"):
            self._inflation.apply(data)
        return data

    def _make_inflation(self) -> Inflation:
        return Inflation(
            self._config.inflation_layer,
            self.footprint.inscribed_radius,
            self._obstacles.frame.resolution,
        )

    def _circumscribed_cost(self) -> int:
        """Return the cost below which no heading collides, 0 where inflation does not tell."""
        inflation, radius = self._config.inflation_layer, self.footprint.circumscribed_radius
        margin = self._obstacles.frame.resolution  # centres of cells against corners of cells
        if not self._uses("inflation_layer") or radius + margin > inflation.inflation_radius:
            return 0
        inscribed = self.footprint.inscribed_radius
        return cost_at_distance(radius + margin, inscribed, inflation.cost_scaling_factor)

    def _clearances(self) -> NDArray[np.float64]:
        uses = self._uses("inflation_layer")
        return clearances(self._config.inflation_layer.cost_scaling_factor if uses else 0.0)

    def _uses(self, layer: str) -> bool:
        return layer in self._config.plugins and bool(getattr(self._config, layer).enabled)

    def _square(self, T_global_base: SE2, edge: float) -> Window:
        frame = self._obstacles.frame
        row, column = frame.to_cell(T_global_base.x, T_global_base.y)
        half = int(edge / 2.0 / frame.resolution)
        rows = slice(max(row - half, 0), max(row + half + 1, 0))
        return rows, slice(max(column - half, 0), max(column + half + 1, 0))


def _own_frame(config: CostmapConfig) -> GridFrame:
    """Return the grid a costmap has before any map came."""
    width, height = (round(edge / config.resolution) for edge in (config.width, config.height))
    return GridFrame(config.resolution, width, height, SE2(config.origin_x, config.origin_y))


def _rolled(frame: GridFrame, T_global_base: SE2) -> GridFrame:
    """Return the grid centred on the robot, moved by whole cells so that no cell is resampled."""
    half_x, half_y = frame.width * frame.resolution / 2.0, frame.height * frame.resolution / 2.0
    columns = math.floor((T_global_base.x - half_x) / frame.resolution)
    rows = math.floor((T_global_base.y - half_y) / frame.resolution)
    origin = SE2(columns * frame.resolution, rows * frame.resolution)
    return GridFrame(frame.resolution, frame.width, frame.height, origin)
