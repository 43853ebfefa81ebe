"""The costmap of layers, in the order in which they are listed."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from arjuna_core.arrays import Bytes
from arjuna_core.grid import GridFrame, OccupancyGrid
from arjuna_core.se2 import SE2
from arjuna_nav.costmap.collision import outside_grid
from arjuna_nav.costmap.config import CostmapConfig
from arjuna_nav.costmap.costmap import INSCRIBED, Costmap
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.costmap.inflation import clearances
from arjuna_nav.costmap.layers.base import Layer, Master, SensedLayer, moved
from arjuna_nav.costmap.layers.container import LayerGroup
from arjuna_nav.costmap.layers.inflation import InflationLayer
from arjuna_nav.costmap.layers.static import PlacedMap
from arjuna_nav.costmap.moving.trails import Patch, path_costs
from arjuna_nav.costmap.window import Window, grown, joined, seen_in, whole


class LayeredCostmap:
    """Combines the layers into one costmap, fixed to the map or rolling with the robot.

    A change costs what its window costs, not what the map does: only there the layers are composed
    again, in place.

    Args:
        config: Parameters, as `arjuna_core.config.load` made them.
        transform: Returns the latest `T_target_source` of two frames; raises a TransformError.

    Attributes:
        group: The layers together: what they lack, why they are not current, what is odd.
        layers: By name, in order.
    """

    def __init__(
        self, config: CostmapConfig, transform: Callable[[str, str], SE2] | None = None
    ) -> None:
        width, height = (round(edge / config.resolution) for edge in (config.width, config.height))
        frame = GridFrame(config.resolution, width, height, SE2(config.origin_x, config.origin_y))
        hits = np.zeros(frame.shape, np.uint32)
        self._master = Master(config, frame, config.outline(), config.own_body(), hits)
        if transform is not None:
            self._master.transform = transform
        # One of both lists, as an inflation that is to spread from zones too, counts at the last.
        backwards = dict.fromkeys(reversed((*config.plugins, *config.filters)))
        self.group = LayerGroup(config, "", self._master, list(backwards)[::-1])
        self.layers = self.group.layers
        self._stamp = 0.0
        self._robot = np.zeros((0, 2))
        self._changed: Window | None = None
        self._overlaid: list[Patch] = []
        self.compose_again()

    @property
    def costmap(self) -> Costmap:
        """The costs as of now; the next change may be made in the same array."""
        return self._costmap

    @property
    def footprint(self) -> Footprint:
        """The robot's outline."""
        return self._master.footprint

    @property
    def body(self) -> Footprint:
        """The robot's own outline, without padding."""
        return self._master.body or self.footprint.without(self._master.config.footprint_padding)

    def take_changed(self) -> Window | None:
        """Return what has changed since the last call, None where nothing has."""
        changed, self._changed = self._changed, None
        return changed

    def reconfigure(self, config: CostmapConfig) -> None:
        """Take other parameters; what sensors have seen is kept, maps have to be received again."""
        before, self._master.config = self._master.config, config
        if _footprint_of(config) != _footprint_of(before):
            self._master.footprint = config.outline()
        self._master.body = config.own_body()
        self.group.reconfigure(config)
        self.compose_again()

    def warnings(self) -> list[str]:
        """Return what is odd about the costs, though they are current."""
        outside = outside_grid(self._master.frame, self._robot)
        robot = [f"the robot is {outside}"] if outside else []
        return [*robot, *self.group.warning().splitlines()]

    def set_footprint(self, footprint: Footprint) -> None:
        """Take another outline of the robot from now on."""
        self._master.footprint, self._master.body = footprint, None
        self.group.on_footprint()
        self.compose_again()

    def set_map(self, grid: OccupancyGrid, frame_id: str = "") -> None:
        """Give a map to each layer that listens to one."""
        for name, layer in self.layers.items():
            for one in layer.inputs():
                if one.data_type == "OccupancyGrid":
                    self.receive(name, one.source, PlacedMap(grid, frame_id))

    def receive(self, layer: str, source: str, value: Any) -> None:
        """Give what has come from a source to the layer that listens to it.

        What sensors have seen counts from the next update on; of a map, a costmap that does not
        follow the robot takes size and position at once, and keeps the obstacles seen.
        """
        self.layers[layer].receive(source, value)
        frame = self.layers[layer].frame
        if (
            isinstance(value, PlacedMap)
            and frame is not None
            and not self._master.config.rolling_window
        ):
            self._move(frame)
            self.compose_again()

    def update(self, T_global_base: SE2, now: float) -> None:
        """Bring the costmap up to date with what was received.

        Args:
            T_global_base: Pose of the robot in the costmap's global frame.
            now: Time of the update [s].
        """
        self._stamp, self._robot = now, np.array([[T_global_base.x, T_global_base.y]])
        for patch in reversed(self._overlaid):  # restores the costs below
            self._costmap.data[patch.window] = patch.costs
            self._changed = joined(self._changed, patch.window)
        self._overlaid = []
        before = self._master.frame
        if self._master.config.rolling_window:
            self._move(_rolled(before, T_global_base))
        changed = self.group.update(T_global_base, now)
        if self._master.frame != before:
            self.compose_again()
        else:
            self._compose(changed)
        self._note_moving()
        self._overlay()

    def is_blocked_for_good(self, pose: SE2) -> bool:
        """Return whether the costs forbid a pose even when all that sensors saw is forgotten."""
        frame = self._master.frame
        row, column = frame.to_cell(pose.x, pose.y)
        if not frame.contains(row, column):
            return False
        cell = slice(row, row + 1), slice(column, column + 1)
        window = grown(cell, self.group.reach, frame.shape)
        lasting = [one for one in self.group.in_use if not isinstance(one, SensedLayer)]
        costs = self._composed(window, lasting)[seen_in(cell, window)]
        return bool((costs >= INSCRIBED).any())

    def clear_entirely(self) -> None:
        """Forget all obstacles seen; the map stays."""
        self._clear(None)

    def clear_around(self, T_global_base: SE2, reset_distance: float) -> None:
        """Forget the obstacles in a square of edge `reset_distance` [m] round a pose."""
        self._clear(self._square(T_global_base, reset_distance))

    def clear_except(self, T_global_base: SE2, reset_distance: float) -> None:
        """Forget the obstacles outside a square of edge `reset_distance` [m] round a pose."""
        self._clear(self._square(T_global_base, reset_distance), outside=True)

    def _clear(self, window: Window | None, outside: bool = False) -> None:
        self.group.clear(window, outside)
        self.compose_again()

    def _move(self, frame: GridFrame) -> None:
        self.group.move(frame)
        self._master.hits = moved(self._master.hits, self._master.frame, frame, 0)
        self._master.frame = frame

    def compose_again(self) -> None:
        """Make the whole costmap again: a layer has been switched."""
        frame, in_use = self._master.frame, self.group.in_use
        inflations = {
            one.name: (
                one.circumscribed_cost() if one is in_use[-1] else 0,
                one.clearances(),
                float(one.config.inflation_radius),
            )
            for one in in_use
            if isinstance(one, InflationLayer)
        }
        nothing = 0, clearances(0.0), 0.0
        circumscribed_cost, distances, _ = [nothing, *inflations.values()][-1]
        self._costmap = Costmap(
            frame,
            self._composed(whole(frame.shape), in_use),
            self._stamp,
            circumscribed_cost,
            self._master.footprint.circumscribed_radius,
            distances,
            self._master.hits,
            leaves=self._master.config.leave_obstacles,
            inflations=inflations,
        )
        self._changed, self._overlaid = whole(frame.shape), []

    def _compose(self, changed: Window | None) -> None:
        """Compose what is within the layers' reach of a change."""
        self._costmap = replace(self._costmap, stamp=self._stamp)
        if changed is None:
            return
        shape = self._costmap.data.shape
        reach = self.group.reach
        window = grown(changed, reach, shape)
        source = grown(window, reach, shape)
        costs = self._composed(source, self.group.in_use)
        self._costmap.data[window] = costs[seen_in(window, source)]
        self._changed = joined(self._changed, window)

    def _composed(self, window: Window, layers: Sequence[Layer]) -> Bytes:
        """Return the costs of a window by some layers, as if there were nothing outside it."""
        shape = (window[0].stop - window[0].start, window[1].stop - window[1].start)
        costs = np.full(shape, self._master.untouched, dtype=np.uint8)
        for layer in layers:
            layer.write(costs, window)
        return costs

    def _note_moving(self) -> None:
        several = [moving.things for moving in self._master.moving.values() if len(moving.things)]
        if not several and not len(self._costmap.moving):
            return
        things = np.vstack([np.zeros((0, 5)), *several])
        points = self._master.frame.origin.inverse().apply(things[:, :2])
        self._costmap = replace(self._costmap, moving=np.column_stack((points, things[:, 4])))

    def _overlay(self) -> None:
        """Overlay the costs of moving things' paths, which change with time alone."""
        radius, frame = self.footprint.inscribed_radius, self._master.frame
        for key, moving in self._master.moving.items():
            since, ahead = self._stamp - moving.stamp, self._master.moving_times[key]
            if not 0.0 <= since <= ahead or not self.layers[key.partition(".")[0]].enabled:
                continue
            patch = path_costs(moving.things, since, ahead, radius, frame)
            if patch is not None:
                below = self._costmap.data[patch.window]
                self._overlaid.append(Patch(patch.window, below.copy()))
                np.maximum(below, patch.costs, out=below)
                self._changed = joined(self._changed, patch.window)

    def _square(self, T_global_base: SE2, edge: float) -> Window:
        frame = self._master.frame
        row, column = frame.to_cell(T_global_base.x, T_global_base.y)
        half = int(edge / 2.0 / frame.resolution)
        rows = slice(max(row - half, 0), max(row + half + 1, 0))
        return rows, slice(max(column - half, 0), max(column + half + 1, 0))


def _footprint_of(config: CostmapConfig) -> tuple[str, float, float, float]:
    return config.footprint, config.robot_radius, config.footprint_padding, config.axle


def _rolled(frame: GridFrame, T_global_base: SE2) -> GridFrame:
    """Return the grid centred on the robot, moved by whole cells so that no cell is resampled."""
    half_x, half_y = frame.width * frame.resolution / 2.0, frame.height * frame.resolution / 2.0
    columns = math.floor((T_global_base.x - half_x) / frame.resolution)
    rows = math.floor((T_global_base.y - half_y) / frame.resolution)
    origin = SE2(columns * frame.resolution, rows * frame.resolution)
    return GridFrame(frame.resolution, frame.width, frame.height, origin)
