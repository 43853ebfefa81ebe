"""Costs left to the goal from the cells about the best path: they guide and bound searches."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arjuna_nav.planners.base import PlanResult
from arjuna_nav.planners.query import Cell, Query
from arjuna_nav.planners.waves.corridor import corridors, guided
from arjuna_nav.planners.waves.potential import spread


@dataclass(frozen=True, eq=False)
class Guide:
    """The end of a path, and the costs that are left to it.

    Attributes:
        end: The goal's cell, or the nearest to it that can be reached.
        left: `(height, width) float32` cost from each cell to the end, inf where that does not
            matter or no path leads there.
        whole: Whether it is known from everywhere, not about the likely path alone.
        path_cost: Cost from the likeliest start, inf where the end is not the goal.
    """

    end: Cell
    left: NDArray[np.float32]
    whole: bool
    path_cost: float


def guide(
    query: Query,
    costs: NDArray[np.float32],
    seeds: NDArray[np.float64],
    slack: float | None,
    width: float = 0.0,
) -> Guide | PlanResult:
    """Return a guide to the goal or the nearest to it within the tolerance, or why there is none.

    Args:
        query: What is asked.
        costs: Cost of crossing a cell by its value, `(256,) float32`, `NEUTRAL` where free.
        seeds: `(N, 3)` row, column and value of the cells where the search begins, the likeliest
            first.
        slack: Of `corridors`; None for a guide from everywhere.
        width: As `slack`.

    Source: a wave from the goal as heuristic is what Dolgov et al. (IJRR 2010) call the holonomic
        one with obstacles.
    """
    data, goal = query.costmap.data, query.goal_cell
    exits = seeds[:, :2].astype(np.int64)
    first = int(exits[0, 0]), int(exits[0, 1])
    within = () if slack is None else corridors(data, costs, first, goal, slack, width)
    if within is not None and np.isfinite(costs[data[goal]]):
        left = guided(
            lambda one: spread(data, costs, _seed(goal), corridor=one.open, shift=one.shift),
            lambda potential: float(potential[first]),
            within,
        )
        if np.isfinite(left[tuple(exits.T)]).any():
            return Guide(goal, left, not within, float(left[first]))
    reached = query.approach(costs, seeds)
    end = query.reachable_end(reached)
    if end is None:
        return query.failure(reached)
    left = spread(data, costs, _seed(end))
    return Guide(end, left, True, float(left[first]) if end == goal else math.inf)


def _seed(cell: Cell) -> NDArray[np.float64]:
    return np.array([[*cell, 0.0]])
