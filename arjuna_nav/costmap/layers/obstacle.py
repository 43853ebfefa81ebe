"""The layer that marks what scans and clouds hit, and clears what their rays cross."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from arjuna_core.arrays import Bools, Bytes, Floats, Ints
from arjuna_core.config import duration_param, param, plugin_names
from arjuna_core.se2 import SE2
from arjuna_nav.costmap.costmap import FREE, LETHAL
from arjuna_nav.costmap.layers.base import (
    Input,
    Master,
    SensedLayer,
    absolute,
    combination_method,
    combine,
)
from arjuna_nav.costmap.layers.observations import (
    SOURCES,
    Observation,
    PlacedCloud,
    PlacedScan,
    SourceConfig,
    as_cloud,
    ranges_of,
    sources_of,
    used_points,
    with_ends,
)
from arjuna_nav.costmap.moving.tracker import Moving, Tracker
from arjuna_nav.costmap.moving.trails import free_trails
from arjuna_nav.costmap.raytrace import enter_points, enter_scan, fill_polygon
from arjuna_nav.costmap.window import Window, joined, within

Seen = tuple[str, Observation, bool]
"""A source's name, what it saw, and whether that is new."""


@dataclass(frozen=True)
class ObstacleConfig:
    """Parameters of the obstacle layer; those of each source stand below its name."""

    enabled: bool = param(True, "Whether the layer takes part.")
    footprint_clearing_enabled: bool = param(True, "Whether cells under the robot are set free.")
    min_obstacle_height: float = param(0.0, "Lowest point that marks.", unit="m")
    max_obstacle_height: float = param(2.0, "Highest point that marks.", unit="m")
    combination_method: int = combination_method("its")
    moving_time: float = duration_param(
        1.5,
        "How far ahead the paths of what moves cost, and its old marks fade; 0 takes all for"
        " standing, and of each source the latest alone, as Nav2.",
        theirs=0.0,
    )
    observation_sources: str = plugin_names("", "The sources, in a text.", SOURCES)


class ObstacleLayer(SensedLayer):
    """Marks what its sources hit and clears what their rays cross; marks stay until a ray clears.

    Of what has come since the last update, the latest of each source clears, then marks, all
    sources together; scans that came before it count too, one by one, for what moves is followed
    from scan to scan. What is known to move is marked near the robot alone, for where it is far it
    will have gone before the robot comes; and where it has been is free, seen or not. On a grid
    that does not follow the robot it is not marked at all: plans are made for long.

    Source: nav2_costmap_2d, obstacle layer.
    """

    Config: ClassVar[type[Any]] = ObstacleConfig

    def __init__(self, config: Any, name: str, master: Master) -> None:
        self.sources: dict[str, SourceConfig] = sources_of(config)
        super().__init__(config, name, master, master.untouched)
        self._kept: dict[str, list[Observation]] = {one: [] for one in self.sources}
        self._trackers: dict[str, Tracker] = {}
        self._freed: dict[str, Moving] = {}  # by whose trails cells were freed
        self._vacated: Window | None = None  # by what moves, in this update
        self._outside: dict[str, float] = {}  # sources whose scans lie too high or too low [m]

    def reconfigure(self, config: Any) -> None:
        super().reconfigure(config)
        self.sources = sources_of(config)

    def inputs(self) -> tuple[Input, ...]:
        return tuple(
            Input(name, source.topic, source.data_type, source.sensor_frame)
            for name, source in self.sources.items()
        )

    def receive(self, source: str, value: Observation) -> None:
        super().receive(source, with_ends(value, self.sources[source]))

    def problem(self, now: float) -> str:
        for name, source in self.sources.items():
            silent = now - self._received_at[name]
            if 0.0 < source.expected_update_rate < silent:
                what = "scan" if source.data_type == "LaserScan" else "cloud"
                return f"no {what} on {absolute(source.topic)} for {silent:.2f} s"
        return ""

    def warning(self) -> str:
        for name, height in self._outside.items():
            of_source, of_layer = self.sources[name].heights, self._heights
            unused = not of_source[0] <= height <= of_source[1]
            low, high = of_source if unused else of_layer
            what = "are not used:" if unused else "mark nothing: the layer's"
            limits = f"min_obstacle_height is {low:g}, max_obstacle_height {high:g}"
            return f"scans of '{name}', {height:.1f} m high, {what} {limits}"
        return ""

    @property
    def _heights(self) -> tuple[float, float]:
        """The heights of what marks [m]."""
        return self.config.min_obstacle_height, self.config.max_obstacle_height

    def start(self, now: float) -> None:
        super().start(now)
        self._kept = {source: [] for source in self._kept}

    def update(self, T_global_base: SE2, now: float) -> Window | None:
        outline, self._vacated = self.master.footprint, None
        batches = self._batches(now)
        self._free_trails_of_others()
        boxes = [(T_global_base, outline.circumscribed_radius)]
        for source, seen, _ in (one for batch in batches for one in batch):
            boxes.append((seen.T_global_sensor, self.sources[source].reach))
        touched = self._window(boxes)
        before = self.data[touched].copy()
        for batch in batches:
            self._enter(batch)
        if self.config.footprint_clearing_enabled:
            self._free_below(T_global_base)
        return joined(self._vacated, within(touched, self.data[touched] != before))

    def write(self, costs: Bytes, window: Window) -> None:
        combine(costs, self.data[window], self.config.combination_method)

    def _batches(self, now: float) -> list[list[Seen]]:
        """Return what clears and then marks together: older ones by themselves, then the latest.

        The latest of a source counts again with each new one of another, whose rays may cross what
        the first alone sees; Nav2 enters it even where nothing is new.
        """
        older: list[Seen] = []
        latest: list[Seen] = []
        for name, values in self._take(now).items():
            kept_for = self.sources[name].observation_persistence
            known = [(name, one, False) for one in self._kept[name]]
            known += [(name, one, True) for one in values]
            kept = [one for one in known if kept_for and one[1].stamp >= now - kept_for]
            if self.config.moving_time > 0.0 and not kept:
                scans = (one for one in values[:-1] if isinstance(one, PlacedScan))
                older += [(name, one, True) for one in scans]
            kept = kept or [one for one in known[-1:] if one[2] or not kept_for]
            self._kept[name] = [one for _, one, _ in kept]
            latest += kept
        batches = [[one] for one in sorted(older, key=lambda one: one[1].stamp)]
        due = any(new or self.sources[name].observation_persistence for name, _, new in latest)
        return [*batches, latest] if due else batches

    def _enter(self, batch: Sequence[Seen]) -> None:
        """Clear along all rays, then mark all ends but those of what moves far from the robot."""
        used = [one for one in batch if self._is_used(*one[:2])]
        passing = [self._follow(*one) for one in used]
        steps = ((True, True),) if len(used) == 1 else ((True, False), (False, True))
        for clearing, marking in steps:
            for source, seen, _ in used:
                config = self.sources[source]
                clears, marks = clearing and config.clearing, marking and config.marking
                self._enter_one(seen, config, clears, marks)
        for cells in filter(None, passing):
            self._set_free(*cells)

    def _is_used(self, source: str, seen: Observation) -> bool:
        """Return whether a scan lies between its source's heights; of clouds, points count."""
        self._outside.pop(source, None)
        if not (isinstance(seen, PlacedScan) and seen.is_planar):
            return True
        (low, high), (lowest, highest) = self.sources[source].heights, self._heights
        if not max(low, lowest) <= seen.height <= min(high, highest):
            self._outside[source] = seen.height
        return low <= seen.height <= high

    def _follow(self, source: str, seen: Observation, new: bool) -> tuple[Ints, Ints] | None:
        """Follow what moves in a scan; return the free cells in which it is, far from the robot."""
        key, horizon = f"{self.name}.{source}", self.config.moving_time
        if isinstance(seen, PlacedCloud) or horizon <= 0.0:
            return None
        if new:
            if source not in self._trackers:
                self._trackers[source] = Tracker()
            self._freed[key] = self._trackers[source].update(seen.reading, seen.T_global_base)
        moving = self._freed.get(key)
        if moving is None or moving.stamp != seen.stamp:
            return None
        self.master.moving[key], self.master.moving_times[key] = moving, horizon
        self._vacated = joined(self._vacated, self._free_trails(moving.things))
        ends = moving.points[moving.velocities.any(axis=1)]
        if not len(ends):
            return None
        cells = self.master.frame.to_cells(ends)
        inside = self.master.frame.inside(cells)
        rows, columns = cells[inside].T
        # A moving thing 0.35 m beyond the outline may still be there when the robot comes.
        near = self.master.footprint.circumscribed_radius + 0.35
        near = near if self.master.config.rolling_window else 0.0
        at, ends = seen.T_global_base, ends[inside]
        passing = np.hypot(ends[:, 0] - at.x, ends[:, 1] - at.y) > near
        passing &= self.data[rows, columns] != LETHAL
        return rows[passing], columns[passing]

    def _free_trails_of_others(self) -> None:
        """Free the cells where things have been that another layer follows."""
        for key, moving in self.master.moving.items():
            if self._freed.get(key) is not moving:
                self._freed[key] = moving
                self._vacated = joined(self._vacated, self._free_trails(moving.things))

    def _free_trails(self, things: Floats) -> Window | None:
        return free_trails(self.data, things, self.master.frame, FREE)

    def _set_free(self, rows: Ints, columns: Ints) -> None:
        self.data[rows, columns] = FREE

    def _free_below(self, T_global_base: SE2) -> None:
        """Set the cells under the robot free, of a body those that lie in it as a whole."""
        body, frame, outline = self.master.body, self.master.frame, self.master.footprint
        if body is not None:
            corner = frame.resolution * math.sqrt(0.5)  # of a cell, off its middle [m]
            outline = body.widened(-corner)
        corners = frame.origin.inverse().apply(outline.at(T_global_base)) / frame.resolution
        self._free(corners)

    def _free(self, corners: Floats) -> None:
        """Set the cells within a polygon free, `(N, 2)` x, y in cells."""
        fill_polygon(self.data, corners, FREE)

    def _enter_one(
        self, seen: Observation, source: SourceConfig, clearing: bool, marking: bool
    ) -> None:
        """Clear along the rays of an observation, mark their ends, or both in this order."""
        frame = self.master.frame
        if isinstance(seen, PlacedCloud) or not seen.is_planar:
            self._enter_cloud(seen, source, clearing, marking)
            return
        low, high = self._heights
        T_grid_sensor = frame.origin.inverse() @ seen.T_global_sensor
        enter_scan(
            self.data,
            self.master.hits,
            T_grid_sensor.array() / (frame.resolution, frame.resolution, 1.0),
            seen.reading.ranges / frame.resolution,
            seen.reading.angles,
            np.array(ranges_of(seen.reading, source)) / frame.resolution,
            clearing,
            marking and low <= seen.height <= high,
        )

    def _enter_cloud(
        self, seen: Observation, source: SourceConfig, clearing: bool, marking: bool
    ) -> None:
        """Do the same by points: those of a cloud, or the ends of a scan's beams."""
        limits, is_scan = self._limits(source), isinstance(seen, PlacedScan)
        used, points = np.zeros((0, 3)), np.zeros((0, 3))
        for clears in (True,) * clearing + (False,) * marking:
            if not len(points) or (is_scan and source.inf_is_valid):
                cloud = as_cloud(seen, source, clears)
                used = used_points(cloud, source)
                points = self._in_grid(cloud, used)
            ends = points[1:]
            if not (clears or is_scan):
                ends = ends[~self._is_own(used[:, :2])]
            self._enter_points(points[0], ends, limits, clears, is_scan)

    def _is_own(self, points: Floats, error: float = 0.01) -> Bools:
        """Return which points `(N, 2)` from the base are of the robot's own body, `(N,)`.

        Of a body that a camera sees the edges lie in cells that are not under it as a whole.

        Args:
            error: Of a point, and of the body's outline [m].
        """
        if self.master.body is None:
            return np.zeros(len(points), bool)
        body = self.master.body.widened(error)
        low, high = body.points.min(axis=0), body.points.max(axis=0)
        own: Bools = ((points >= low) & (points <= high)).all(axis=1)
        near = np.flatnonzero(own)
        own[near] = body.holds(points[near])
        return own

    def _enter_points(
        self, sensor: Floats, points: Floats, limits: Floats, clearing: bool, precise: bool
    ) -> None:
        """Clear along the rays to points, or mark the points; args as of `enter_points`.

        `precise`: whether points show where in their cells things lie.
        """
        enter_points(self.data, sensor, points, limits, clearing)

    @property
    def _edges(self) -> tuple[float, float]:
        """Height of a cell and of the lowest one's bottom [m]: here it is one, of any height."""
        return 1.0, 0.0

    def _in_grid(self, seen: PlacedCloud, used: Floats) -> Floats:
        """Return the sensor and the points that are used, `(1 + N, 3)` in cells."""
        (edge, bottom), frame = self._edges, self.master.frame
        points: Floats
        points = np.vstack((seen.reading.sensor, used))
        points[:, :2] = (frame.origin.inverse() @ seen.T_global_base).apply(points[:, :2])
        points[:, 2] -= bottom
        points /= np.array([frame.resolution, frame.resolution, edge])
        return points

    def _limits(self, source: SourceConfig) -> Floats:
        """Return what bounds clearing and marking, in cells as `enter_points` takes it."""
        edge, bottom = self._edges
        heights = np.array(self._heights)
        cells = np.array([*source.ranges, edge]) / self.master.frame.resolution
        return np.concatenate((cells[:4], (heights - bottom) / edge, cells[4:]))
