"""The layer of what clouds of points show: table tops and thresholds that no planar scan sees."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arjuna_core.grid import GridFrame
from arjuna_core.readings import Cloud
from arjuna_core.se2 import SE2
from arjuna_nav.costmap.config import CloudConfig, CostmapConfig
from arjuna_nav.costmap.costmap import FREE
from arjuna_nav.costmap.layers import SeenLayer, moved
from arjuna_nav.costmap.moving.ways import free_trails
from arjuna_nav.costmap.raytrace import fill_polygon
from arjuna_nav.costmap.voxel_rays import enter_cloud
from arjuna_nav.costmap.window import Window


@dataclass(frozen=True, eq=False)
class PlacedCloud:
    """A cloud and where the robot was when it was seen.

    Attributes:
        cloud: The cloud.
        T_global_base: Pose of the base in the costmap's global frame at the cloud's stamp.
    """

    cloud: Cloud
    T_global_base: SE2


class VoxelLayer(SeenLayer[PlacedCloud]):
    """Marks the voxels that points are in and clears those that the rays to them cross.

    Only rays of clouds clear what clouds have marked: the lidar looks through below a table.

    Args:
        frame: Where the grid lies.
        config: The costmap's parameters.

    Source: nav2_costmap_2d, voxel layer.
    """

    def __init__(self, frame: GridFrame, config: CostmapConfig) -> None:
        super().__init__(frame, config)
        self._voxels: NDArray[np.uint32] = np.zeros(frame.shape, np.uint32)

    def move(self, frame: GridFrame) -> None:
        """Continue on another grid of the same resolution; what both cover is kept."""
        self._voxels = moved(self._voxels, self.frame, frame, 0)
        super().move(frame)

    def clear(self, window: Window | None = None, outside: bool = False) -> None:
        """Forget what was seen: everywhere, in a window of cells, or outside that window."""
        super().clear(window, outside)
        self._voxels[self.data == self._untouched] = 0

    def leave(self, things: NDArray[np.float64]) -> Window | None:
        """Free the cells where things have just been, as `free_trails` does; return where."""
        free_trails(self._voxels, things, self.frame, 0)
        return free_trails(self.data, things, self.frame, FREE)

    def _reach(self, seen: PlacedCloud) -> tuple[SE2, float]:
        source, off = self._config.cloud, np.hypot(*seen.cloud.sensor[:2])
        far = max(source.raytrace_max_range, source.obstacle_max_range)
        return seen.T_global_base, far + float(off)

    def _free(self, corners: NDArray[np.float64]) -> None:
        super()._free(corners)
        fill_polygon(self._voxels, corners, 0)

    def _enter(self, seen: PlacedCloud) -> None:
        config, source, cell = self._config, self._config.cloud, self.frame.resolution
        T_grid_base = self.frame.origin.inverse() @ seen.T_global_base
        level = np.array([cell, cell, config.z_resolution])
        places = np.vstack((seen.cloud.sensor, seen.cloud.points))
        places[:, :2] = T_grid_base.apply(places[:, :2])
        places[:, 2] -= config.origin_z
        places /= level
        enter_cloud(
            self._voxels,
            self.data,
            places[0],
            places[1:],
            _limits(source, cell, config.origin_z, config.z_resolution),
            config.z_voxels,
            config.mark_threshold,
        )


def _limits(
    source: CloudConfig, cell: float, origin_z: float, z_resolution: float
) -> NDArray[np.float64]:
    """Return what bounds clearing and marking, as `enter_cloud` takes it."""
    ranges = (
        source.raytrace_min_range,
        source.raytrace_max_range,
        source.obstacle_min_range,
        source.obstacle_max_range,
    )
    heights = source.min_obstacle_height, source.max_obstacle_height
    levels = [(height - origin_z) / z_resolution for height in heights]
    return np.array([*(r / cell for r in ranges), *levels, source.clearing, source.marking])
