"""The layer of voxels that fade with time, sooner where a sensor looks and sees nothing."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from arjuna_core.arrays import Bools, Floats, Ints
from arjuna_core.config import angle_param, fixed, length_param, param, plugin_names
from arjuna_core.plugins import NamedConfigs
from arjuna_core.pose3 import Pose3
from arjuna_core.se2 import SE2
from arjuna_nav.costmap.costmap import FREE, LETHAL, UNKNOWN
from arjuna_nav.costmap.layers.base import Master
from arjuna_nav.costmap.layers.observations import Observation, SensorSource, as_cloud, used_points
from arjuna_nav.costmap.layers.obstacle import ObstacleLayer
from arjuna_nav.costmap.window import Window, whole, within

_BITS = 21  # of a voxel's number along each axis in its key
_HALF, _MASK = 1 << (_BITS - 1), (1 << _BITS) - 1


@dataclass(frozen=True)
class FadingSource(SensorSource):
    """Parameters of one source: what it marks, and the frustum in which marks fade sooner."""

    data_type: str = fixed("PointCloud2", "Type of the data.", choices=("LaserScan", "PointCloud2"))
    enabled: bool = param(True, "Whether the source counts; `toggle_enabled` switches it.")
    max_obstacle_height: float = param(3.0, "Highest point that is used.", unit="m")
    obstacle_range: float = length_param(2.5, "Longest range that marks.")
    min_z: float = param(0.0, "Shortest range seen; below 0 as 0.", unit="m")
    max_z: float = length_param(10.0, "Longest range seen.")
    vertical_fov_angle: float = angle_param(0.7, "Angle seen up and down.")
    vertical_fov_padding: float = param(0.0, "Height a lidar misses within.", unit="m")
    horizontal_fov_angle: float = angle_param(1.04, "Angle seen sideways.")
    decay_acceleration: float = param(
        0.0, "How much sooner marks fade that it looks at.", unit="1/s^2", minimum=0.0
    )
    model_type: int = param(
        0, "Form of what it sees: 0 a depth camera's pyramid, 1 a lidar's ring.", choices=(0, 1)
    )
    filter: str = param(
        "passthrough",
        "Points that mark: passthrough those between the heights, voxel those of voxels with"
        " enough of them, else all.",
    )
    voxel_min_points: int = param(0, "Points that mark a voxel by that filter.", minimum=0)
    clear_after_reading: bool = param(False, "Whether what was seen counts once only.")


@dataclass(frozen=True)
class FadingConfig:
    """Parameters of the spatio-temporal layer; those of each source stand below its name."""

    enabled: bool = param(True, "Whether the layer takes part.")
    voxel_decay: float = param(-1.0, "How long a mark stays that nothing renews.", unit="s")
    decay_model: int = param(
        0,
        "How marks fade: 0 after voxel_decay, 1 exponentially, so that only a source's look ends"
        " them, -1 not by themselves.",
        choices=(-1, 0, 1),
    )
    voxel_size: float = length_param(0.05, "Edge of a voxel.", minimum=0.005)
    mark_threshold: int = param(0, "Marked voxels above a cell that make it lethal.", minimum=0)
    track_unknown_space: bool = param(True, "Whether unmarked cells are as the layers before say.")
    update_footprint_enabled: bool = param(True, "Whether cells under the robot are set free.")
    combination_method: int = param(
        1, "How its costs combine with those before: 0 its own, 1 the greater.", choices=(0, 1, 2)
    )
    mapping_mode: bool = param(False, "Whether nothing fades.")
    publish_voxel_map: bool = fixed(False, "Whether the voxels are published.")
    observation_sources: str = plugin_names(
        "", "The sources, in a text.", NamedConfigs(FadingSource, "topic")
    )


class SpatioTemporalVoxelLayer(ObstacleLayer):
    """Marks the voxels that points are in; a mark fades, and sooner in what a sensor looks at.

    No ray is traced: what a frustum holds and nothing marks again is gone soon, all else after
    `voxel_decay`. Voxels are of the world. Unlike in STVL, marks count in the same update.

    Source: Macenski, Tsai and Feinberg, Spatio-temporal voxel layer, Int. J. Advanced Robotic
    Systems 17, 2020; spatio_temporal_voxel_layer.
    """

    Config: ClassVar[type[Any]] = FadingConfig

    def __init__(self, config: Any, name: str, master: Master) -> None:
        super().__init__(config, name, master)
        self._keys: Ints
        self._marked_at: Floats
        self._forget()

    def reconfigure(self, config: Any) -> None:
        before, now = ((c.voxel_size, c.track_unknown_space) for c in (self.config, config))
        super().reconfigure(config)
        if before != now:
            self._forget()

    def switch(self, source: str, enabled: bool) -> None:
        """Switch a source on or off; where it goes off, all that was seen is forgotten."""
        config: Any = self.sources[source]
        self.sources[source] = replace(config, enabled=enabled)
        if not enabled:
            self._kept[source] = []
            self._forget()

    def clear(self, window: Window | None = None, outside: bool = False) -> None:
        super().clear(window, outside)
        if window is None:
            self._forget()
            return
        held, of_window = np.zeros(len(self._keys), bool), np.zeros(self.data.shape, bool)
        rows, columns, inside = self._cells()
        of_window[window] = True
        held[inside] = of_window[rows, columns]
        self._keep(held if outside else ~held)

    def voxels(self) -> Floats:
        """Return the middles of the marked voxels, `(N, 3)` of the costmap's frame [m]."""
        numbers = (self._keys[:, None] >> np.array([0, _BITS, 2 * _BITS])) & _MASK
        middles: Floats = (numbers - _HALF + 0.5) * self.config.voxel_size
        return middles

    def update(self, T_global_base: SE2, now: float) -> Window | None:
        seen = self._seen(now)
        if not self.config.mapping_mode:
            self._fade([one for one in seen if one[0].clearing], now)
        for source, one in seen:
            if source.marking:
                self._mark(one, source, now)
        before = self.data.copy()
        self.data.fill(self._untouched)
        rows, columns, _ = self._cells()
        counts = np.zeros(self.data.shape, np.int64)
        np.add.at(counts, (rows, columns), 1)
        self.data[counts >= max(self.config.mark_threshold, 1)] = LETHAL
        if self.config.update_footprint_enabled:
            self._free_below(T_global_base)
        return within(whole(self.data.shape), self.data != before)

    def _seen(self, now: float) -> list[tuple[Any, Observation]]:
        """Return what counts of each source that is on: its latest, or all that is kept."""
        seen: list[tuple[Any, Observation]] = []
        for name, values in self._take(now).items():
            source: Any = self.sources[name]
            if not source.enabled:
                continue
            since = now - source.observation_persistence
            known = [*self._kept[name], *values]
            keeps = source.observation_persistence > 0.0
            known = [one for one in known if one.stamp >= since] if keeps else known[-1:]
            self._kept[name] = [] if source.clear_after_reading else known
            seen += [(source, one) for one in known]
        return seen

    def _fade(self, looks: Iterable[tuple[Any, Observation]], now: float) -> None:
        """Take away the marks whose time is over, sooner in the frustums of what is seen."""
        decay, since = self.config.voxel_decay, now - self._marked_at
        of_model = {0: decay - since, 1: decay * np.exp(-since)}
        left = of_model.get(self.config.decay_model, np.full(len(since), decay))
        middles, looked_at = self.voxels(), np.zeros(len(since), bool)
        for source, seen in looks:
            inside = ~looked_at & _looks_at(source, seen, middles)
            sooner = source.decay_acceleration / 6.0 * since[inside] ** 3
            left[inside] -= sooner
            self._marked_at[inside] -= sooner
            looked_at |= inside
        self._keep(left >= 0.0)

    def _mark(self, seen: Observation, source: Any, now: float) -> None:
        cloud, limited = as_cloud(seen, source, False), source.filter in ("passthrough", "voxel")
        points = used_points(cloud, source) if limited else cloud.reading.points
        far = np.linalg.norm(points - cloud.reading.sensor, axis=1)
        points = points[(far > 0.01) & (far <= source.obstacle_range)]  # nearer is the sensor
        points[:, :2] = cloud.T_global_base.apply(points[:, :2])
        numbers = np.floor(points / self.config.voxel_size).astype(np.int64) + _HALF
        numbers = numbers[((numbers >= 0) & (numbers <= _MASK)).all(axis=1)]
        keys, counts = np.unique(numbers @ (1 << _BITS * np.arange(3)), return_counts=True)
        if source.filter == "voxel":
            keys = keys[counts >= source.voxel_min_points]
        every = np.concatenate((keys, self._keys))
        self._keys, first = np.unique(every, return_index=True)  # the first is the newest
        self._marked_at = np.concatenate((np.full(len(keys), now), self._marked_at))[first]

    def _cells(self) -> tuple[Ints, Ints, Bools]:
        """Return rows and columns of the voxels that are in the grid, and which are."""
        cells = self.master.frame.to_cells(self.voxels()[:, :2])
        inside = self.master.frame.inside(cells)
        rows, columns = cells[inside].T
        return rows, columns, inside

    def _keep(self, kept: Bools) -> None:
        self._keys, self._marked_at = self._keys[kept], self._marked_at[kept]

    def _forget(self) -> None:
        self._untouched = UNKNOWN if self.config.track_unknown_space else FREE
        self._keys, self._marked_at = np.zeros(0, np.int64), np.zeros(0)


def _looks_at(source: Any, seen: Observation, points: Floats) -> Bools:
    """Return which points of the costmap's frame `(N, 3)` lie in what a sensor looks at, `(N,)`.

    A camera looks along its z axis, and its near and far ends go through the frustum's corners; a
    lidar looks about its x axis.
    """
    cloud = as_cloud(seen, source, False)
    x, y, z = cloud.reading.sensor.tolist()
    T = Pose3.from_se2(cloud.T_global_base) @ (cloud.mount or Pose3((x, y, z)))
    px, py, pz = T.inverse().apply(points).T
    up, aside = source.vertical_fov_angle / 2.0, source.horizontal_fov_angle / 2.0
    if source.model_type == 0:
        ends = math.cos(up) * math.cos(aside)
        within_ends = (source.min_z * ends <= pz) & (pz <= source.max_z * ends)
        across = np.abs(px) * math.cos(up) <= pz * math.tan(aside)
        camera: Bools = within_ends & across & (np.abs(py) <= pz * math.tan(up))
        return camera
    far = np.hypot(px, py)
    ring = (source.min_z <= far) & (far <= source.max_z)
    ring &= np.abs(pz) + source.vertical_fov_padding <= far * math.tan(up)
    all_round = source.horizontal_fov_angle > 6.27  # as STVL takes it
    lidar: Bools = ring & (all_round | (np.abs(np.arctan2(py, px)) <= aside))
    return lidar
