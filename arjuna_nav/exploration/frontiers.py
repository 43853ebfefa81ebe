"""Frontier exploration: where to drive next so that the map grows."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy import ndimage
from scipy.spatial import KDTree

from arjuna_core.arrays import Bools, Floats, Ints
from arjuna_core.config import length_param, param
from arjuna_core.grid import OccupancyGrid
from arjuna_core.se2 import SE2
from arjuna_nav.costmap.collision import collides
from arjuna_nav.costmap.costmap import Costmap
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.planners.waves.potential import NEUTRAL, traversal_costs, wavefront

_EIGHT_NEIGHBOURS = np.ones((3, 3), dtype=np.int8)


@dataclass(frozen=True)
class ExplorationConfig:
    """Parameters of exploration."""

    min_frontier_size: float = length_param(0.3, "Shortest frontier of interest.")
    view_distance: float = length_param(1.0, "How far from a frontier it may be looked at.")
    frontier_shift: float = length_param(
        0.3, "How far a frontier may move and still be the goal's."
    )
    start_radius: float = length_param(
        0.5, "How far from the robot, which stands in the unknown, the map may begin."
    )
    max_cost: int = param(120, "Greatest cost of a cell to stand on.", minimum=0, maximum=252)
    size_gain: float = param(1.0, "Gain of a metre of frontier, in metres of path.", minimum=0.0)
    open_distance: float = length_param(
        3.0,
        "Distance to the nearest obstacle from which a frontier is in the open and comes last: a"
        " lidar has nothing there to see where it is by.",
    )
    max_open_distance: float = length_param(
        12.0,
        "Distance to the nearest obstacle from which a frontier is left out: a lidar sees nothing"
        " there, or too little, and open ground may have no end. Of a robot whose file has a lidar"
        " that sees less far it is that range.",
    )
    blacklist_radius: float = length_param(
        0.5, "Distance to a goal tried before within which a cell is ruled out."
    )


def next_goal(
    grid: OccupancyGrid,
    costmap: Costmap,
    T_map_base: SE2,
    tried: Sequence[SE2],
    config: ExplorationConfig = ExplorationConfig(),
    footprint: Footprint | None = None,
) -> SE2 | None:
    """Return where to look from next, facing the frontier, or turned from it where need be.

    Args:
        costmap: Inflated costs of the same grid; unknown stays unknown.
        tried: Goals of before; none near one of them comes again, so that exploration ends.
        footprint: The robot's, which is free there; a point if None.

    Returns:
        The goal, or None where no frontier of interest can be reached.

    Raises:
        ValueError: Grid and costmap lie differently.

    Source: Yamauchi, A frontier-based approach for autonomous exploration, 1997.
    """
    if grid.frame != costmap.frame:
        raise ValueError(f"grid {grid.frame} and costmap {costmap.frame} must be one frame")
    start = grid.frame.to_cell(T_map_base.x, T_map_base.y)
    costs = traversal_costs(allow_unknown=False)
    if not grid.frame.contains(*start) or grid.unknown()[start]:
        free = np.isfinite(costs[costmap.data])
        start = _nearest(free, start, config.start_radius / grid.frame.resolution)
    if not grid.frame.contains(*start):
        return None
    seeds = np.array([[*start, 0.0]])  # the robot is where it is, whatever that costs
    potential = wavefront(costmap.data, costs, seeds)
    travel = potential.astype(np.float64) / NEUTRAL * grid.frame.resolution
    travel[costmap.data > config.max_cost] = np.inf
    for goal in tried:
        _rule_out(travel, grid, goal, config.blacklist_radius)
    touches = partial(collides, costmap, footprint or Footprint.circle(1e-3))
    for clusters in _near_and_open(grid, config):
        candidates = [_viewpoint(cells, travel, grid, config, touches) for cells in clusters]
        best = min((entry for entry in candidates if entry is not None), default=None)
        if best is not None:
            return SE2(*best[1:])
    return None


def frontiers(grid: OccupancyGrid, config: ExplorationConfig = ExplorationConfig()) -> list[Ints]:
    """Return the frontiers: clusters of free cells beside unknown ones, each `(N, 2) int64`.

    Those in the open come last. Clusters shorter than `min_frontier_size` are left out.
    """
    near, in_the_open = _near_and_open(grid, config)
    return near + in_the_open


def _near_and_open(grid: OccupancyGrid, config: ExplorationConfig) -> tuple[list[Ints], list[Ints]]:
    """Return the frontiers near obstacles and those in the open; all are near where none is."""
    edge = grid.free() & ndimage.binary_dilation(grid.unknown())  # by the four sides, not corners
    cells, obstacles = np.argwhere(edge), np.argwhere(grid.occupied())
    gaps = np.zeros(len(cells))
    if len(obstacles) and len(cells):
        gaps = KDTree(obstacles).query(cells)[0] * grid.frame.resolution
    is_seen = gaps < config.max_open_distance
    is_near = is_seen & (gaps < config.open_distance)
    is_open = is_seen & ~is_near
    return _clusters(grid, cells[is_near], config), _clusters(grid, cells[is_open], config)


def _clusters(grid: OccupancyGrid, cells: Ints, config: ExplorationConfig) -> list[Ints]:
    """Return cells that are neighbours together, where they are enough to be of interest."""
    mask = np.zeros(grid.frame.shape, bool)
    mask[tuple(cells.T)] = True
    labels, count = ndimage.label(mask, structure=_EIGHT_NEIGHBOURS)
    numbers = labels[tuple(cells.T)]
    ends = np.cumsum(np.bincount(numbers, minlength=count + 1)[1:])[:-1]
    clusters = np.split(cells[np.argsort(numbers, kind="stable")], ends) if count else []
    least = config.min_frontier_size / grid.frame.resolution
    return [cluster for cluster in clusters if len(cluster) >= least]


def _nearest(free: Bools, start: tuple[int, int], reach: float) -> tuple[int, int]:
    """Return the nearest cell that can be stood on, at most a reach [cells] off; else the start."""
    cells = np.argwhere(free)
    gaps = np.hypot(*(cells - np.array(start)).T)
    if len(cells) == 0 or gaps.min() > reach:
        return start
    row, column = cells[np.argmin(gaps)].tolist()
    return row, column


def _rule_out(travel: Floats, grid: OccupancyGrid, goal: SE2, radius: float) -> None:
    rows, columns = np.ogrid[: grid.frame.height, : grid.frame.width]
    row, column = grid.frame.to_cell(goal.x, goal.y)
    travel[(rows - row) ** 2 + (columns - column) ** 2 < (radius / grid.frame.resolution) ** 2] = (
        np.inf
    )


def _viewpoint(
    cells: Ints,
    travel: Floats,
    grid: OccupancyGrid,
    config: ExplorationConfig,
    touches: Callable[[SE2], bool],
) -> tuple[float, float, float, float] | None:
    """Return `(cost, x, y, yaw)` of the best free pose to see a frontier's middle cell from."""
    centre = cells.mean(axis=0)
    middle = cells[np.argmin(np.square(cells - centre).sum(axis=1))]
    reach = math.ceil(config.view_distance / grid.frame.resolution)
    row0, column0 = np.maximum(middle - reach, 0)
    window = travel[row0 : middle[0] + reach + 1, column0 : middle[1] + reach + 1]
    rows, columns = np.ogrid[: window.shape[0], : window.shape[1]]
    gap = np.hypot(rows + row0 - middle[0], columns + column0 - middle[1])
    score = window + gap * grid.frame.resolution  # as near as can be stood, without detours
    score[gap > reach] = np.inf
    best_first = np.argsort(score, axis=None, kind="stable")[: np.isfinite(score).sum()]
    at_x, at_y = grid.frame.to_point(int(middle[0]), int(middle[1]))
    size = len(cells) * grid.frame.resolution
    eighths = (0, 1, -1, 2, -2, 3, -3, 4)  # of a round, from the frontier
    for turn, index in itertools.product(eighths, best_first.tolist()):
        row, column = divmod(index, score.shape[1])
        x, y = grid.frame.to_point(int(row + row0), int(column + column0))
        yaw = math.atan2(at_y - y, at_x - x) + 0.25 * math.pi * turn
        if not touches(SE2(x, y, yaw)):
            return float(score[row, column]) - config.size_gain * size, x, y, yaw
    return None
