"""Costs left to the goal from the cells about the best path: they guide and bound searches."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from arjuna_core.arrays import Bytes, Floats, Singles
from arjuna_nav.planners.base import PlanResult
from arjuna_nav.planners.nearby import pooled
from arjuna_nav.planners.query import Cell, Query
from arjuna_nav.planners.waves.corridor import UNBOUNDED, Corridor, corridors, guided
from arjuna_nav.planners.waves.potential import wavefront


@dataclass(frozen=True, eq=False)
class Guide:
    """The end of a path, and the costs that are left to it.

    Attributes:
        end: The goal's cell, or the nearest to it that can be reached.
        remaining: `(height, width) float32` cost from each cell to the end, inf where that does not
            matter or no path leads there.
        whole: Whether it is known from everywhere, not about the likely path alone.
        path_cost: Cost from the likeliest start, inf where the end is not the goal.
    """

    end: Cell
    remaining: Singles
    whole: bool
    path_cost: float


def guide(
    query: Query,
    costs: Singles,
    seeds: Floats,
    slack: float | None,
    width: float = 0.0,
    coarseness: int = 1,
) -> Guide | PlanResult:
    """Return a guide to the goal or the nearest to it within the tolerance, or why there is none.

    Args:
        costs: Cost of crossing a cell by its value, `(256,) float32`, `NEUTRAL` where free.
        seeds: `(N, 3)` row, column and value of the cells where the search begins, the likeliest
            first.
        slack: Of `corridors`; None for a guide from everywhere.
        width: As `slack`.
        coarseness: 2 where the costs left are of cells twice as large, the cheapest of each four.

    Source: a wave from the goal as heuristic is what Dolgov et al. (IJRR 2010) call the holonomic
        one with obstacles.
    """
    data, goal = query.costmap.data, query.goal_cell
    exits = seeds[:, :2].astype(np.int64)
    first = int(exits[0, 0]), int(exits[0, 1])
    within = () if slack is None else corridors(data, costs, first, goal, slack, width)
    if within is not None and np.isfinite(costs[data[goal]]) and query.fits(goal):
        remaining = guided(
            lambda one: _costs_remaining(data, costs, goal, one, coarseness),
            lambda potential: float(potential[first]),
            within,
        )
        if np.isfinite(remaining[tuple(exits.T)]).any():
            return Guide(goal, remaining, not within, float(remaining[first]))
    reached = query.approach(costs, seeds)
    end = query.reachable_end(reached)
    if end is None:
        return query.failure(reached)
    remaining = _costs_remaining(data, costs, end, UNBOUNDED, coarseness)
    return Guide(end, remaining, True, float(remaining[first]) if end == goal else math.inf)


def _costs_remaining(
    data: Bytes, costs: Singles, end: Cell, within: Corridor, coarseness: int
) -> Singles:
    """Return the cost from each cell of a corridor to the end."""
    seed, shift = np.array([[end[0] // coarseness, end[1] // coarseness, 0.0]]), within.shift
    if coarseness == 1:
        return wavefront(data, costs, seed, corridor=within.open, shift=shift)
    coarse = pooled(data, coarseness, np.minimum)
    remaining = wavefront(coarse, costs, seed, corridor=within.open, shift=shift - 1)
    large = remaining.repeat(coarseness, axis=0).repeat(coarseness, axis=1)
    large *= np.float32(coarseness)
    return large[: data.shape[0], : data.shape[1]]
