"""Smac 2D: A* over cells and their costs, then a smoother."""

from __future__ import annotations

import heapq
import math
from dataclasses import dataclass, replace
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from arjuna_core.arrays import Bools, Bytes, Floats, Singles
from arjuna_core.config import duration_param, length_param, param
from arjuna_core.se2 import SE2
from arjuna_nav.costmap.costmap import INSCRIBED, Costmap
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.planners.base import PlanResult, PlanStatus, check_stopped, stop_flag
from arjuna_nav.planners.hybrid.config import DownsamplingConfig, SmacConfig
from arjuna_nav.planners.nearby import Plan, coarser, nearby_first
from arjuna_nav.planners.query import ask, oriented, traced
from arjuna_nav.planners.relaxation import smoothed
from arjuna_nav.planners.waves.corridor import Corridor, corridors, guided, is_outside
from arjuna_nav.planners.waves.potential import NEUTRAL, closed

_ACROSS = math.sqrt(2.0)
_SCALE = np.float32(NEUTRAL)  # of a free cell's cost in a corridor's estimate


@dataclass(frozen=True)
class Smac2DConfig(DownsamplingConfig, SmacConfig):
    """Parameters of Smac 2D, by Nav2's names."""

    tolerance: float = length_param(0.125, "How far from a blocked goal the path may end.")
    cost_travel_multiplier: float = param(1.0, "Weight of the costs crossed.", minimum=0.0)
    max_planning_time: float = duration_param(
        2.0, "After which a plan ends with TIMEOUT. In lock-step plans take no time."
    )
    use_final_approach_orientation: bool = param(
        False, "Whether the path ends in its own direction, not the goal's."
    )


class _Limits(NamedTuple):
    """The ends of a search: after so many cells, so many within a tolerance [cells], a stop."""

    cells: int
    near: int
    tolerance: float
    interval: int


class Smac2D:
    """Plans by A* over the eight neighbours of each cell, cost-aware.

    Args:
        footprint: The robot; the costs hold all that is asked of it.

    Source: Hart, Nilsson and Raphael 1968; nav2_smac_planner, SmacPlanner2D.
    """

    Config: ClassVar[type[Any]] = Smac2DConfig

    def __init__(self, config: Smac2DConfig, footprint: Footprint | None = None) -> None:
        self._config = config

    def plan(self, costmap: Costmap, start: SE2, goal: SE2) -> PlanResult:
        """Plan between two poses in the costmap's frame; see `NavFn.plan` for both ends."""
        costs, grid = self._costs(), coarser(costmap, self._config.coarseness)
        found = nearby_first(
            lambda part: self._plan(part, costs, start, goal), grid, costs, start, goal
        )
        if found.status is not PlanStatus.SUCCEEDED:
            return found
        points = smoothed(found.path[:, :2], costmap, self._config.smoother)
        return replace(found, path=oriented(points, float(found.path[-1, 2])))

    def _plan(self, costmap: Costmap, costs: Singles, start: SE2, goal: SE2) -> Plan:
        config = self._config
        query = ask(config, costmap, start, goal, config.use_final_approach_orientation)
        if isinstance(query, PlanResult):
            return Plan(query)
        seeds = query.out.seeds(1.0)
        limit = config.max_iterations if config.max_iterations > 0 else costmap.data.size
        limits = _Limits(
            limit,
            max(config.max_on_approach_iterations, 0),
            config.tolerance_on_approach(costmap.frame.resolution),
            config.terminal_checking_interval,
        )
        data, goal_cell, stop = costmap.data, query.goal_cell, stop_flag()
        values, before, spent = guided(
            lambda within: _a_star(data, costs, seeds, goal_cell, limits, within, stop),
            lambda found: float((found[0][goal_cell] - seeds[0, 2]) * _SCALE),
            # Slack 0: on large maps only the best estimate is considered.
            corridors(data, costs * _SCALE, query.out.nearest, goal_cell, 0.0) or (),
        )
        check_stopped()
        end = query.reachable_end(values)
        if end is None and spent:
            message = f"no path within max_iterations = {limit} cells"
            return Plan(PlanResult.failed(PlanStatus.TIMEOUT, message))
        if end is None:
            return Plan(query.failure(values))
        path_cost = float(values[end]) if end == goal_cell else math.inf
        return Plan(query.answer(traced(before, end, data.shape[1])), path_cost)

    def _costs(self) -> Singles:
        """Return what a cell's length costs by its value, `(256,) float32`."""
        costs = 1.0 + self._config.cost_travel_multiplier * np.arange(256) / (INSCRIBED - 1)
        return closed(costs, self._config.allow_unknown)


@njit(cache=True, nogil=True)
def _a_star(
    data: Bytes,
    costs: Singles,
    seeds: Floats,
    goal: tuple[int, int],
    limits: _Limits,
    within: Corridor,
    stop: Bools,
) -> tuple[Singles, NDArray[np.int32], bool]:
    """Return the cost of each cell until the goal, the cell before it, whether a limit came."""
    height, width = data.shape
    values = np.full((height, width), np.inf, np.float32)
    before = np.full(height * width, -1, np.int32)
    closed = np.zeros((height, width), np.bool_)
    queue = [(0.0, np.int64(0))]
    queue.pop()
    for row, column, value in seeds:
        r, c = int(row), int(column)
        values[r, c], before[r * width + c] = value, r * width + c
        heapq.heappush(queue, (value + _octile(r, c, goal), np.int64(r * width + c)))
    count, near, until = 0, 0, min(limits.interval, limits.cells)
    while len(queue) > 0:
        cell = heapq.heappop(queue)[1]
        row, column = cell // width, cell % width
        if closed[row, column]:
            continue
        closed[row, column] = True
        count += 1
        if row == goal[0] and column == goal[1]:
            break
        if limits.tolerance >= 0.0:
            near += near > 0 or math.hypot(row - goal[0], column - goal[1]) <= limits.tolerance
        if count >= until or near > limits.near:
            if until == limits.cells or stop[0] or near > limits.near:
                return values, before, True
            until = min(until + limits.interval, limits.cells)
        for d_r in range(-1, 2):
            for d_c in range(-1, 2):
                r, c = row + d_r, column + d_c
                inside = 0 <= r < height and 0 <= c < width
                if not inside or closed[r, c] or is_outside(within, r, c):
                    continue
                value = values[row, column] + costs[data[r, c]] * (_ACROSS if d_r * d_c else 1.0)
                if value >= values[r, c]:
                    continue
                if costs[data[row, c]] == np.inf or costs[data[r, column]] == np.inf:
                    continue
                values[r, c], before[r * width + c] = value, cell
                heapq.heappush(queue, (value + _octile(r, c, goal), np.int64(r * width + c)))
    return values, before, False


@njit(cache=True)
def _octile(row: int, column: int, goal: tuple[int, int]) -> float:
    d_r, d_c = abs(row - goal[0]), abs(column - goal[1])
    return max(d_r, d_c) + (math.sqrt(2.0) - 1.0) * min(d_r, d_c)
