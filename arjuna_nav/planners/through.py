"""Plans through several poses, leg by leg."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from arjuna_core.se2 import SE2
from arjuna_nav.costmap.costmap import Costmap
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.planners.base import Planner, PlanResult, PlanStatus
from arjuna_nav.planners.outline import plan_for_outline


def plan_through(
    planner: Planner,
    costmap: Costmap,
    start: SE2,
    goals: Sequence[SE2],
    footprint: Footprint | None = None,
) -> PlanResult:
    """Plan through poses to the last; without any, NO_VALID_PATH.

    Where a footprint is given, a path that its outline could not follow is replaced by one
    that it can, if there is one.
    """
    if not goals:
        return PlanResult.failed(PlanStatus.NO_VALID_PATH, "no goals were given")
    pieces: list[NDArray[np.float64]] = []
    expansions: list[NDArray[np.float64]] = []
    for goal in goals:
        result = (
            planner.plan(costmap, start, goal)
            if footprint is None
            else plan_for_outline(planner, costmap, start, goal, footprint)
        )
        if result.status is not PlanStatus.SUCCEEDED:
            return result
        pieces.append(result.path)
        if result.expansions is not None:
            expansions.append(result.expansions)
        start = SE2.from_array(result.path[-1])
    expanded = np.vstack(expansions) if expansions else None
    return PlanResult(PlanStatus.SUCCEEDED, np.vstack(pieces), expansions=expanded)
