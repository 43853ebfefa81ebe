"""The path and the costs as MPPI's critics see them, in the robot's frame."""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
from numba import njit

from arjuna_core.arrays import Bools, Bytes, Floats
from arjuna_core.se2 import SE2
from arjuna_nav.controllers.mppi.rollouts import Array, Limits
from arjuna_nav.costmap.collision import collides_in_cells
from arjuna_nav.costmap.costmap import INSCRIBED, UNKNOWN, Costmap
from arjuna_nav.costmap.footprint import Footprint


class Grid(NamedTuple):
    """Costs, and where the robot is on them.

    Attributes:
        data: `(height, width) uint8`.
        x: The robot's column, a fraction [cells].
        y: The robot's row.
        theta: Its heading in the grid [rad].
        scale: Cells a metre.
        points: Its outline `(N, 2) float64` [cells].
        circular: Whether the outline is a circle.
        safe_cost: Cost below which no heading collides.
    """

    data: Bytes
    x: float
    y: float
    theta: float
    scale: float
    points: Floats
    circular: bool
    safe_cost: int


class Scene(NamedTuple):
    """The path ahead, the goal and the costs, seen from the robot.

    Attributes:
        path: `(N, 3) float32` [m, m, rad].
        free: `(N,) bool`: whether the robot may stand there.
        goal_distance: How far away it is [m].
        furthest: Index of the farthest pose of the path that a rollout's end is nearest to.
        clearances: The costmap's, `(256,) float64` [m].
        inscribed_radius: The robot's [m].
        dt: Time of a step [s].
        xy_goal_tolerance: Distance at which the position counts as reached [m].
        inflations: The costmap's `circumscribed_cost`, `clearances` and radius by each inflation
            layer.
        inflation_radius: Of the layer that counts [m]; 0 where there is none.
    """

    path: Array
    free: Bools
    goal: SE2
    goal_distance: float
    furthest: int
    grid: Grid
    clearances: Floats
    inscribed_radius: float
    limits: Limits
    dt: float
    xy_goal_tolerance: float = 0.0
    inflations: Mapping[str, tuple[int, Floats, float]] = MappingProxyType({})
    inflation_radius: float = 0.0

    def inflated_by(self, layer: str) -> Scene:
        """Return it with distances by the costs of an inflation layer; of none, the last's."""
        if layer not in self.inflations:
            radii = [each[2] for each in self.inflations.values()]
            return self._replace(inflation_radius=radii[-1] if radii else 0.0)
        safe_cost, clearances, radius = self.inflations[layer]
        grid = self.grid._replace(safe_cost=safe_cost)
        return self._replace(grid=grid, clearances=clearances, inflation_radius=radius)


def grid_seen(costmap: Costmap, footprint: Footprint, pose: SE2) -> Grid:
    """Return a costmap as the rollouts from a pose see it."""
    frame = costmap.frame
    at = frame.origin.inverse() @ pose
    return Grid(
        costmap.data,
        at.x / frame.resolution,
        at.y / frame.resolution,
        at.theta,
        1.0 / frame.resolution,
        footprint.points / frame.resolution,
        footprint.circular,
        costmap.circumscribed_cost,
    )


def path_seen(path: Floats, pose: SE2) -> Array:
    """Return a path `(N, 3)` in the frame of the robot at a pose."""
    seen: Array = _seen(path, (pose.x, pose.y, pose.theta))
    return seen


@njit(cache=True)
def _seen(path: Floats, pose: tuple[float, float, float]) -> Array:
    seen = np.empty(path.shape, np.float32)
    c, s = math.cos(pose[2]), math.sin(pose[2])
    for i in range(len(path)):
        x, y = path[i, 0] - pose[0], path[i, 1] - pose[1]
        seen[i, 0], seen[i, 1] = c * x + s * y, c * y - s * x
        seen[i, 2] = path[i, 2] - pose[2]
    return seen


@njit(cache=True)
def free_poses(path: Array, grid: Grid) -> Bools:
    """Return which poses of a path are on the costmap and not blocked."""
    free = np.zeros(len(path), np.bool_)
    c, s = math.cos(grid.theta) * grid.scale, math.sin(grid.theta) * grid.scale
    for i in range(len(path)):
        column = math.floor(grid.x + c * path[i, 0] - s * path[i, 1])
        row = math.floor(grid.y + s * path[i, 0] + c * path[i, 1])
        if 0 <= row < grid.data.shape[0] and 0 <= column < grid.data.shape[1]:
            cost = grid.data[row, column]
            free[i] = cost < INSCRIBED or cost == UNKNOWN
    return free


@njit(cache=True, fastmath=True)
def furthest_reached(x: Array, y: Array, path: Array) -> int:
    """Return the greatest index of a path's pose that is the nearest to some rollout's end."""
    batch = len(x)
    best, index = np.full(batch, np.float32(np.inf)), np.zeros(batch, np.int32)
    for i in range(len(path)):
        px, py = path[i, 0], path[i, 1]
        for b in range(batch):
            distance = (x[b] - px) * (x[b] - px) + (y[b] - py) * (y[b] - py)
            if distance < best[b]:
                best[b], index[b] = distance, i
    return int(index.max())


@njit(cache=True)
def touches(grid: Grid, x: float, y: float, yaw: float) -> bool:
    """Return whether the robot's outline, at a pose seen from where it is, meets an obstacle."""
    c, s = math.cos(grid.theta) * grid.scale, math.sin(grid.theta) * grid.scale
    pose = np.array([grid.x + c * x - s * y, grid.y + s * x + c * y, grid.theta + yaw])
    hit: bool = collides_in_cells(grid.data, pose, grid.points, grid.circular, grid.safe_cost)
    return hit
