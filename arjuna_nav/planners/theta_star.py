"""Theta*: paths of straight lines at any angle, round obstacles and their costs."""

from __future__ import annotations

import heapq
import itertools
import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numba import njit
from numpy.typing import NDArray

from arjuna_core.arrays import Bools, Bytes, Floats, Singles
from arjuna_core.config import param
from arjuna_core.se2 import SE2
from arjuna_nav.costmap.costmap import INSCRIBED, Costmap
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.planners.base import GridPlannerConfig, PlanResult, check_stopped, stop_flag
from arjuna_nav.planners.guide import guide
from arjuna_nav.planners.nearby import Plan, nearby_first
from arjuna_nav.planners.query import ask, traced
from arjuna_nav.planners.waves.potential import NEUTRAL, closed

_SLACK = 0.005  # of paths considered on large maps, over the best estimate


@dataclass(frozen=True)
class ThetaStarConfig(GridPlannerConfig):
    """Parameters of Theta*, by Nav2's names."""

    how_many_corners: int = param(8, "Neighbours of a cell.", choices=(4, 8))
    w_euc_cost: float = param(1.0, "Weight of length.", minimum=0.0)
    w_traversal_cost: float = param(2.0, "Weight of the costs crossed.", minimum=0.0)
    w_heuristic_cost: float = param(
        1.0, "Weight of the distance left; above 1 is faster, not shortest.", minimum=0.0
    )
    terminal_checking_interval: int = param(
        5000, "Cells looked at between two looks whether the plan is to stop.", minimum=1
    )
    use_final_approach_orientation: bool = param(
        False, "Whether the path ends in its own direction, not the goal's."
    )


class ThetaStar:
    """Plans by lazy Theta* with costs.

    Args:
        footprint: The robot; the costs hold all that is asked of it.

    Source: Nash, Daniel, Koenig and Felner, Theta*: any-angle path planning on grids, AAAI 2007;
        nav2_theta_star_planner.
    """

    Config: ClassVar[type[Any]] = ThetaStarConfig

    def __init__(self, config: ThetaStarConfig, footprint: Footprint | None = None) -> None:
        self._config = config

    def plan(self, costmap: Costmap, start: SE2, goal: SE2) -> PlanResult:
        """Plan between two poses in the costmap's frame; see `NavFn.plan` for both ends."""
        costs = _weights(self._config)
        scaled = costs * np.float32(NEUTRAL / self._config.w_euc_cost)
        return nearby_first(
            lambda part: self._plan(part, costs, start, goal), costmap, scaled, start, goal
        )

    def _plan(self, costmap: Costmap, costs: Singles, start: SE2, goal: SE2) -> Plan:
        config = self._config
        query = ask(config, costmap, start, goal, config.use_final_approach_orientation)
        if isinstance(query, PlanResult):
            return Plan(query)
        seeds, scale = query.out.seeds(1.0), np.float32(NEUTRAL / config.w_euc_cost)
        found = guide(query, costs * scale, seeds * (1.0, 1.0, scale), _SLACK)
        if isinstance(found, PlanResult):
            return Plan(found)
        data, options = costmap.data, (config.w_heuristic_cost / scale, config.how_many_corners)
        stop = stop_flag(), config.terminal_checking_interval
        parents = _theta_star(data, costs, seeds, found.end, found.remaining, *options, *stop)
        check_stopped()
        points = _spaced(traced(parents, found.end, data.shape[1]))
        return Plan(query.answer(points), found.path_cost)


def _weights(config: ThetaStarConfig) -> Singles:
    """Return what a cell's length costs by its value, `(256,) float32`, inf where none may be."""
    share = np.arange(256) / (INSCRIBED - 1)
    return closed(config.w_euc_cost + config.w_traversal_cost * share**2, config.allow_unknown)


@njit(cache=True, nogil=True)
def _theta_star(
    data: Bytes,
    costs: Singles,
    seeds: Floats,
    goal: tuple[int, int],
    remaining: Singles,
    weight: float,
    corners: int,
    stop: Bools,
    interval: int,
) -> NDArray[np.int32]:
    """Return the number of the corner before each cell, until the goal; cells need a cost to it.

    A cell that is taken from the queue looks past its parent to its parent's parent.
    """
    height, width = data.shape
    values = np.full((height, width), np.inf, np.float32)
    parents = np.full(height * width, -1, np.int32)
    closed = np.zeros((height, width), np.bool_)
    queue, until_look = [(0.0, np.int64(0))], interval
    queue.pop()
    for row, column, value in seeds:
        r, c = int(row), int(column)
        values[r, c], parents[r * width + c] = value, r * width + c
        heapq.heappush(queue, (value + weight * remaining[r, c], np.int64(r * width + c)))
    while len(queue) > 0:
        cell = heapq.heappop(queue)[1]
        row, column = cell // width, cell % width
        if closed[row, column]:
            continue
        closed[row, column] = True
        until_look -= 1
        if until_look == 0:
            if stop[0]:
                break
            until_look = interval
        _look_past(data, costs, cell, values, parents)
        if row == goal[0] and column == goal[1]:
            break
        for k in range(corners):
            r, c = _neighbour(row, column, k)
            if not (0 <= r < height and 0 <= c < width) or closed[r, c]:
                continue
            if remaining[r, c] == np.inf:
                continue
            value = values[row, column] + line_cost(data, costs, row, column, r, c)
            if value < values[r, c]:
                values[r, c], parents[r * width + c] = value, cell
                heapq.heappush(queue, (value + weight * remaining[r, c], np.int64(r * width + c)))
    return parents


@njit(cache=True)
def _look_past(
    data: Bytes, costs: Singles, cell: int, values: Singles, parents: NDArray[np.int32]
) -> None:
    """Make the parent's parent a cell's parent where the straight line from there costs no more."""
    beyond, width = parents[parents[cell]], data.shape[1]
    if beyond == parents[cell]:
        return
    row, column, r, c = cell // width, cell % width, beyond // width, beyond % width
    value = values[r, c] + line_cost(data, costs, r, c, row, column)
    if value <= values[row, column] + 1e-3:
        values[row, column], parents[cell] = value, beyond


@njit(cache=True)
def _neighbour(row: int, column: int, k: int) -> tuple[int, int]:
    """Return a neighbour: four beside, then four across corners."""
    if k < 4:
        return row + (k == 0) - (k == 1), column + (k == 2) - (k == 3)
    return row + (1 if k < 6 else -1), column + (1 if k % 2 else -1)


@njit(cache=True)
def line_cost(data: Bytes, costs: Singles, r0: int, c0: int, r1: int, c1: int) -> float:
    """Return the cost of a straight line between cells' centres, inf where a cell on it blocks.

    Its length times the mean cost of all cells that it touches, corners among them.
    """
    d_r, d_c = abs(r1 - r0), abs(c1 - c0)
    step_r, step_c = (1 if r1 > r0 else -1), (1 if c1 > c0 else -1)
    row, column, error, total, count = r0, c0, d_c - d_r, 0.0, 0
    while True:
        cost = costs[data[row, column]]
        if cost == np.inf:
            return np.inf
        total += cost
        count += 1
        if row == r1 and column == c1:
            length: float = total / count * math.hypot(d_r, d_c)
            return length
        if error > 0:
            column += step_c
            error -= 2 * d_r
        elif error < 0:
            row += step_r
            error += 2 * d_c
        else:
            blocked = costs[data[row + step_r, column]] == np.inf
            if blocked or costs[data[row, column + step_c]] == np.inf:
                return np.inf
            row += step_r
            column += step_c
            error += 2 * (d_c - d_r)


def _spaced(corners: Floats) -> Floats:
    """Return points at most a cell apart on the lines between corners `(N, 2)`."""
    pieces = [corners[:1]]
    for before, after in itertools.pairwise(corners):
        count = max(math.ceil(float(np.hypot(*(after - before)))), 1)
        pieces.append(before + (after - before) * np.arange(1, count + 1)[:, None] / count)
    return np.vstack(pieces)
