"""Plans on the part of a costmap about the start and the goal, or on cells of another size."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from arjuna_core.arrays import Bytes, Singles
from arjuna_core.se2 import SE2
from arjuna_nav.costmap.costmap import Costmap
from arjuna_nav.costmap.window import Window, clipped
from arjuna_nav.planners.base import PlanResult

_SHARE = 0.5  # of the map; a larger window saves nothing, by `bench planner --sizes`


class Plan(NamedTuple):
    """A planner's answer.

    Attributes:
        path_cost: Cost of the path, inf where it does not end at the goal.
    """

    result: PlanResult
    path_cost: float = math.inf


def nearby_first(
    plan: Callable[[Costmap], Plan], costmap: Costmap, costs: Singles, start: SE2, goal: SE2
) -> PlanResult:
    """Return a plan from about the start and the goal if no path beyond can be better, else of all.

    Args:
        costs: Cost of crossing a cell by its value, `(256,) float32`.

    Source: an ellipse holds all points by which a path of a length may lead; here its box.
    """
    ends = [costmap.frame.to_cell(one.x, one.y) for one in (start, goal)]
    if all(costmap.frame.contains(*end) and costs[costmap.data[end]] < np.inf for end in ends):
        # A margin of 40 cells about both ends, where they are side by side.
        reach = max(40, math.ceil(math.dist(*ends)))
        rows, columns = zip(*ends, strict=True)
        window = clipped(
            min(rows) - reach,
            max(rows) + reach + 1,
            min(columns) - reach,
            max(columns) + reach + 1,
            costmap.data.shape,
        )
        if costmap.data[window].size < _SHARE * costmap.data.size:
            found = plan(_part(costmap, window))
            # The fit of `potential` gives a straight line at least 0.99 of its length.
            if found.path_cost <= 0.99 * float(costs.min()) * math.hypot(
                math.dist(*ends), 2 * reach
            ):
                return found.result
    return plan(costmap).result


def coarser(costmap: Costmap, factor: int) -> Costmap:
    """Return the greatest cost of so many cells along each side, as one cell."""
    if factor <= 1:
        return costmap
    return _resampled(
        costmap, pooled(costmap.data, factor, np.maximum), costmap.frame.resolution * factor
    )


def finer(costmap: Costmap, factor: int) -> Costmap:
    """Return the same costs, each cell divided into so many along each side."""
    if factor <= 1:
        return costmap
    data = costmap.data.repeat(factor, axis=0).repeat(factor, axis=1)
    return _resampled(costmap, data, costmap.frame.resolution / factor)


def pooled(data: Bytes, factor: int, choose: np.ufunc) -> Bytes:
    """Return the greatest or least of so many cells along each side; the last may be of fewer."""
    rows, columns = (np.arange(0, size, factor) for size in data.shape)
    result: Bytes = choose.reduceat(choose.reduceat(data, rows, axis=0), columns, axis=1)
    return result


def _resampled(costmap: Costmap, data: Bytes, resolution: float) -> Costmap:
    height, width = data.shape
    frame = replace(costmap.frame, resolution=resolution, width=width, height=height)
    return replace(costmap, frame=frame, data=data, hits=None)


def _part(costmap: Costmap, window: Window) -> Costmap:
    frame, data = costmap.frame, np.ascontiguousarray(costmap.data[window])
    corner = SE2(window[1].start * frame.resolution, window[0].start * frame.resolution)
    frame = replace(frame, width=data.shape[1], height=data.shape[0], origin=frame.origin @ corner)
    return replace(costmap, frame=frame, data=data, hits=None)
