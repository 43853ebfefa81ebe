"""Poses where a robot may stand on a map, and the shortest paths between them."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from scipy.ndimage import distance_transform_edt, label

from arjuna_core.arrays import Bools, Floats
from arjuna_core.errors import ArjunaError
from arjuna_core.grid import OccupancyGrid
from arjuna_core.se2 import SE2
from arjuna_nav.costmap.costmap import LETHAL
from arjuna_nav.planners.waves.descent import descend
from arjuna_nav.planners.waves.potential import traversal_costs, wavefront


class FreeSpace:
    """Poses where a robot may stand on a map, and the shortest paths between them.

    Args:
        grid: The map.
        radius: The robot's inscribed radius, that no path goes nearer to a wall [m].
        clearance: From a goal to the nearest wall [m]: there is room to turn.
        sight: From a goal to the nearest wall at most [m], where any goal is so near: in the open
            a lidar sees nothing by which to know the robot's pose.

    Attributes:
        grid: The map.

    Raises:
        ArjunaError: No pose has so much room.
    """

    def __init__(
        self,
        grid: OccupancyGrid,
        radius: float,
        clearance: float = 0.5,
        sight: float = math.inf,
    ) -> None:
        self.grid, self.frame = grid, grid.frame
        # between the edges of cells, not their centres
        gaps = (distance_transform_edt(grid.free()) - 0.5) * grid.frame.resolution
        self._open: Bools = gaps >= radius
        regions, _ = label(self._open)
        sizes = np.bincount(regions[self._open])
        largest = self._open & (regions == np.argmax(sizes)) if len(sizes) else self._open
        goals = (gaps >= clearance) & largest
        walls = grid.occupied()
        near = goals & (distance_transform_edt(~walls) * grid.frame.resolution <= sight)
        near &= walls.any()  # without any, there are no distances
        self._cells = np.argwhere(near if near.any() else goals)
        if not len(self._cells):
            raise ArjunaError(f"the map has no pose that lies {clearance:g} m from walls")

    def draw(self, rng: np.random.Generator) -> SE2:
        """Return a random pose in the greatest connected part of the free space."""
        cell = self._cells[rng.integers(len(self._cells))]
        x, y = self.frame.to_point(int(cell[0]), int(cell[1]))
        return SE2(x, y, float(rng.uniform(-math.pi, math.pi)))

    def draw_beyond(
        self,
        before: SE2,
        rng: np.random.Generator,
        shortest: float = 1.0,
        tries: int = 1000,
        is_clear: Callable[[SE2], bool] = lambda pose: True,
    ) -> SE2:
        """Return a random pose to which the path is so long [m]: a nearer one says little of it.

        Raises:
            ArjunaError: None is found.
        """
        for _ in range(tries):
            goal = self.draw(rng)
            if self.shortest(before, goal) >= shortest and is_clear(goal):
                return goal
        raise ArjunaError(f"the map has no goals {shortest:g} m from each other")

    def nearest(self, x: float, y: float) -> SE2:
        """Return the nearest position with room for the radius, the given one where it has [m]."""
        row, column = self.frame.to_cell(x, y)
        height, width = self._open.shape
        cell = min(max(row, 0), height - 1), min(max(column, 0), width - 1)
        if cell == (row, column) and self._open[cell]:
            return SE2(x, y)
        indices = distance_transform_edt(~self._open, return_distances=False, return_indices=True)
        return SE2(*self.frame.to_point(*indices[:, cell[0], cell[1]].tolist()))

    def sees(self, start: SE2, goal: SE2) -> bool:
        """Return whether the straight line between two positions has room for the radius."""
        ends = np.array([self.frame.to_cell(pose.x, pose.y) for pose in (start, goal)])
        inside = (ends >= 0).all() and (ends < self._open.shape).all()
        return bool(inside) and _sees(self._open, *ends.astype(np.float64))

    def shortest(self, start: SE2, goal: SE2) -> float:
        """Return the length [m] of the shortest path for the radius, NaN where there is none.

        The path down a potential without costs, pulled tight between cells that see each other.
        """
        path = self.shortest_path(start, goal)
        return math.nan if path is None else length_of(path)

    def shortest_path(self, start: SE2, goal: SE2) -> Floats | None:
        """Return the corners of the shortest path from the goal to the start, `(N, 2)` [m]."""
        ends = [self.frame.to_cell(pose.x, pose.y) for pose in (start, goal)]
        data = np.where(self._open, 0, LETHAL).astype(np.uint8)
        potential = wavefront(data, traversal_costs(), np.array([[*ends[0], 0.0]]))
        if not math.isfinite(potential[ends[1]]):
            return None
        path = descend(potential, ends[1])
        kept = path[_tight(np.isfinite(potential), path)]
        frame = self.frame
        cells: Floats = (kept[:, ::-1] + 0.5) * frame.resolution
        return frame.origin.apply(cells)


def length_of(path: Floats) -> float:
    """Return the length of a path of points `(N, 2)` [m]."""
    return float(np.hypot(*np.diff(path, axis=0).T).sum())


def _tight(open_: Bools, path: Floats) -> list[int]:
    """Return the corners of a path whose ends are drawn together from both sides."""
    kept, last = [0], len(path) - 1
    while kept[-1] < last:
        here = kept[-1]
        seen = (k for k in range(last, here + 1, -1) if _sees(open_, path[here], path[k]))
        kept.append(next(seen, here + 1))
    return kept


def _sees(open_: Bools, a: Floats, b: Floats, samples: int = 4) -> bool:
    """Return whether the straight line between two cells is open, by some samples a cell."""
    count = int(math.hypot(*(b - a)) * samples) + 1
    points = a + (b - a) * np.arange(count + 1)[:, None] / count
    rows, columns = np.floor(points + 0.5).astype(np.int64).T
    return bool(open_[rows, columns].all())
