"""The layer of what clouds and scans show in space: table tops that no planar scan sees."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numba import njit
from numpy.typing import NDArray

from arjuna_core.arrays import Bytes, Floats, Ints
from arjuna_core.config import fixed, length_param, param
from arjuna_core.grid import GridFrame
from arjuna_nav.costmap.costmap import FREE, LETHAL, UNKNOWN, blended
from arjuna_nav.costmap.layers.base import Master, moved
from arjuna_nav.costmap.layers.observations import Observation, SourceConfig
from arjuna_nav.costmap.layers.obstacle import ObstacleConfig, ObstacleLayer
from arjuna_nav.costmap.moving.trails import free_trails
from arjuna_nav.costmap.raytrace import fill_polygon
from arjuna_nav.costmap.window import Window

_ALL = 15  # Nav2's unknown_threshold from which on a free cell is never unknown
_MOST = 32  # bits of a column here
VOXELS_SHOWN = 16
"""The lowest ones: a column's number in a VoxelGrid message has room for no more."""


@dataclass(frozen=True)
class VoxelConfig(ObstacleConfig):
    """Parameters of the voxel layer; those of each source stand below its name."""

    origin_z: float = param(0.0, "Height of the lowest voxel.", unit="m")
    z_resolution: float = length_param(0.2, "Height of a voxel.", minimum=0.01)
    z_voxels: int = param(
        10, "Voxels one above the other; more than 32 count as 32, of which Nav2 has 16.", minimum=1
    )
    unknown_threshold: int = param(
        _ALL, "Unknown voxels above a cell that is yet free.", minimum=0, maximum=32
    )
    mark_threshold: int = param(
        0, "Marked voxels above a cell that is yet free.", minimum=0, maximum=32
    )
    publish_voxel_map: bool = fixed(False, "Whether the voxels are published.")


class VoxelLayer(ObstacleLayer):
    """Marks the voxels that points are in and clears those that the rays to them cross.

    Attributes:
        voxels: `(height, width) uint32` which are marked, the lowest voxel the lowest bit.
        known: Likewise which were ever seen.

    Source: nav2_costmap_2d, voxel layer.
    """

    Config: ClassVar[type[Any]] = VoxelConfig

    def __init__(self, config: Any, name: str, master: Master) -> None:
        super().__init__(config, name, master)
        self.voxels: NDArray[np.uint32] = np.zeros(master.frame.shape, np.uint32)
        self.known: NDArray[np.uint32] = np.zeros(master.frame.shape, np.uint32)
        self._cleared = master.frame, np.zeros((0, 3))  # by which rays, in cells

    @property
    def _column(self) -> tuple[int, int, int]:
        """Voxels above a cell, and how many may be marked or unknown in a free one."""
        count, unknown = min(self.config.z_voxels, _MOST), self.config.unknown_threshold
        return count, self.config.mark_threshold, count if unknown >= _ALL else unknown

    def reconfigure(self, config: Any) -> None:
        edges, count = self._edges, self.config.z_voxels
        super().reconfigure(config)
        if (edges, count) != (self._edges, config.z_voxels):
            self.clear()

    def move(self, frame: GridFrame) -> None:
        self.voxels = moved(self.voxels, self.master.frame, frame, 0)
        self.known = moved(self.known, self.master.frame, frame, 0)
        super().move(frame)

    def clear(self, window: Window | None = None, outside: bool = False) -> None:
        super().clear(window, outside)
        forgotten = self.data == self._untouched
        self.voxels[forgotten] = self.known[forgotten] = 0

    def columns(self) -> NDArray[np.uint32]:
        """Return the voxels as nav2_msgs/VoxelGrid has them, `(height, width) uint32`.

        The upper half of a number says which voxels are marked, the lower which are marked or
        unknown; there is room for 16.
        """
        low = np.uint32((1 << VOXELS_SHOWN) - 1)
        unclear: NDArray[np.uint32] = (self.voxels | ~self.known) & low
        columns: NDArray[np.uint32] = (self.voxels & low) << np.uint32(VOXELS_SHOWN) | unclear
        return columns

    def cleared_to(self) -> Floats:
        """Return where the rays that cleared last lead to, `(N, 3)` of the costmap's frame [m]."""
        (frame, points), (edge, bottom) = self._cleared, self._edges
        planar = frame.origin.apply(points[:, :2] * frame.resolution)
        return np.column_stack((planar, points[:, 2] * edge + bottom))

    def _free_trails(self, things: Floats) -> Window | None:
        free_trails(self.voxels, things, self.master.frame, 0)
        return super()._free_trails(things)

    def _set_free(self, rows: Ints, columns: Ints) -> None:
        super()._set_free(rows, columns)
        self.voxels[rows, columns] = 0

    def _free(self, corners: Floats) -> None:
        super()._free(corners)
        fill_polygon(self.voxels, corners, 0)

    @property
    def _edges(self) -> tuple[float, float]:
        """Height of a voxel and of the lowest one's bottom [m]."""
        return self.config.z_resolution, self.config.origin_z

    def _enter_one(
        self, seen: Observation, source: SourceConfig, clearing: bool, marking: bool
    ) -> None:
        """Enter scans as clouds too: their rays have a height."""
        self._enter_cloud(seen, source, clearing, marking)

    def _enter_points(
        self, sensor: Floats, points: Floats, limits: Floats, clearing: bool, precise: bool
    ) -> None:
        """Clear along the rays to points, or mark the points, voxel by voxel."""
        ground, seen = (self.voxels, self.known, self.data), (sensor, points, limits)
        if clearing:
            self._cleared = self.master.frame, points
            clear_cloud(*ground, *seen, self._column)
        else:
            mark_cloud(*ground, self.master.hits, *seen, self._column, precise)


@njit(cache=True)
def clear_cloud(
    voxels: NDArray[np.uint32],
    known: NDArray[np.uint32],
    data: Bytes,
    sensor: Floats,
    points: Floats,
    limits: Floats,
    column: tuple[int, int, int],
) -> None:
    """Clear along the rays to all points, in place.

    Coordinates are in voxels: the floor of a point's coordinates is its voxel.

    Args:
        voxels: `(height, width) uint32` which are marked.
        known: Likewise which were ever seen.
        data: `(height, width) uint8` costs of the cells.
        sensor: `(3,)` where the points were seen from.
        points: `(N, 3)`.
        limits: As `enter_points` has them, in voxels.
        column: How many voxels are above a cell, how many of them may be marked in a free cell,
            and how many unknown.
    """
    height, width = data.shape
    levels, allowed, unknown = column
    ends = np.zeros(data.shape, np.uint32)  # one ray to each voxel will do
    crossed = np.zeros(data.shape, np.uint32)
    for i in range(len(points)):
        px, py, pz = points[i]
        x, y, z = math.floor(px), math.floor(py), math.floor(pz)
        if 0 <= y < height and 0 <= x < width and 0 <= z < levels:
            if ends[y, x] >> z & 1:
                continue
            ends[y, x] |= np.uint32(1 << z)
        _cross(crossed, levels, (sensor[0], sensor[1], sensor[2]), (px, py, pz), limits[:2])
    for y in range(height):
        for x in range(width):
            if crossed[y, x]:
                voxels[y, x] &= ~crossed[y, x]
                known[y, x] |= crossed[y, x]
                if _count(voxels[y, x]) > allowed:
                    data[y, x] = LETHAL
                elif unknown < levels and levels - _count(known[y, x]) > unknown:
                    data[y, x] = UNKNOWN
                else:
                    data[y, x] = FREE


@njit(cache=True)
def mark_cloud(
    voxels: NDArray[np.uint32],
    known: NDArray[np.uint32],
    data: Bytes,
    hits: NDArray[np.uint32],
    sensor: Floats,
    points: Floats,
    limits: Floats,
    column: tuple[int, int, int],
    precise: bool,
) -> None:
    """Mark the voxels that points are in, in place; points below the lowest voxel mark that.

    Args as `clear_cloud`, and:
        hits: `(height, width) uint32` where in its cell each mark lies; see `hit_points`.
        precise: Whether the points say where in their cells things lie.
    """
    _, _, mark_min, mark_max, low, high, unit = limits
    height, width = data.shape
    levels, allowed, _ = column
    for i in range(len(points)):
        px, py, pz = points[i]
        x, y, z = math.floor(px), math.floor(py), max(math.floor(pz), 0)
        inside = 0 <= y < height and 0 <= x < width and z < levels
        far = math.hypot(px - sensor[0], py - sensor[1])
        far = math.hypot(far, (pz - sensor[2]) * unit)
        if inside and low <= pz <= high and mark_min <= far <= mark_max:
            voxels[y, x] |= np.uint32(1 << z)
            known[y, x] |= np.uint32(1 << z)
            if _count(voxels[y, x]) > allowed:
                data[y, x] = LETHAL
                if precise:
                    hits[y, x] = blended(hits[y, x], px - x, py - y)


@njit(cache=True)
def _cross(
    crossed: NDArray[np.uint32],
    levels: int,
    start: tuple[float, float, float],
    end: tuple[float, float, float],
    reach: Floats,
) -> None:
    """Set the voxels along a ray, up to the one it ends in.

    Source: nav2_voxel_grid's ray tracing, a step for each voxel of the longest axis.
    """
    height, width = crossed.shape
    (x, y, z), (nearest, farthest) = start, (reach[0], reach[1])
    dx, dy, dz = end[0] - x, end[1] - y, end[2] - z
    count = math.ceil(max(abs(dx), abs(dy), abs(dz)))
    length = math.hypot(dx, dy)
    last = math.floor(end[0]), math.floor(end[1]), math.floor(end[2])
    entered = False
    for k in range(count):
        share = k / count
        if share * length < nearest:
            continue
        if share * length > farthest:
            return
        px, py, pz = x + share * dx, y + share * dy, z + share * dz
        if 0.0 <= px < width and 0.0 <= py < height and 0.0 <= pz < levels:
            entered = True
            column, row, level = int(px), int(py), int(pz)
            if column == last[0] and row == last[1] and level == last[2]:
                return
            crossed[np.uint32(row), np.uint32(column)] |= np.uint32(1 << level)
        elif entered:  # a ray that has left the grid does not come back
            return


@njit(cache=True)
def _count(bits: int) -> int:
    """Return how many bits are set (Kernighan)."""
    count = 0
    while bits:
        bits &= bits - 1
        count += 1
    return count
