"""NavFn: a wave of potential from the robot to the goal, and the descent back."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from arjuna_core.arrays import Floats, Singles
from arjuna_core.config import param
from arjuna_core.se2 import SE2
from arjuna_nav.costmap.costmap import Costmap
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.planners.base import GridPlannerConfig, PlanResult, PlanStatus
from arjuna_nav.planners.nearby import Plan, nearby_first
from arjuna_nav.planners.query import Query, ask
from arjuna_nav.planners.theta_star import line_cost
from arjuna_nav.planners.waves.corridor import corridors, guided
from arjuna_nav.planners.waves.descent import descend
from arjuna_nav.planners.waves.potential import NEUTRAL, traversal_costs, wavefront

_SLACK, _SLACK_ASTAR = 0.005, 0.0  # of paths considered, over the best estimate


@dataclass(frozen=True)
class NavFnConfig(GridPlannerConfig):
    """Parameters of NavFn, by Nav2's names."""

    use_astar: bool = param(
        False,
        "Whether the wave keeps closer to the estimated path, as A* does: `bench planner` shows"
        " what that saves; its path at times 1 % costlier.",
    )
    use_final_approach_orientation: bool = param(
        False, "Whether the path ends in its own direction, not the goal's."
    )


class NavFn:
    """Plans by NavFn's potential.

    Args:
        footprint: The robot; the costs hold all that NavFn asks of it.

    Source: nav2_navfn_planner (K. Konolige); see `potential`.
    """

    Config: ClassVar[type[Any]] = NavFnConfig

    def __init__(self, config: NavFnConfig, footprint: Footprint | None = None) -> None:
        self._config = config

    def plan(self, costmap: Costmap, start: SE2, goal: SE2) -> PlanResult:
        """Plan between two poses in the costmap's frame.

        Where the goal cannot be reached, the path ends at the reachable cell nearest to it within
        `tolerance`. A start where the robot may not be, within an obstacle's inscribed radius, is
        led out of there first, within `escape_radius`.
        """
        costs = traversal_costs(self._config.allow_unknown)
        return nearby_first(
            lambda part: self._plan(part, costs, start, goal), costmap, costs, start, goal
        )

    def _plan(self, costmap: Costmap, costs: Singles, start: SE2, goal: SE2) -> Plan:
        query = ask(self._config, costmap, start, goal, self._config.use_final_approach_orientation)
        if isinstance(query, PlanResult):
            if query.status is PlanStatus.START_OCCUPIED:  # as Nav2's: then recoveries are tried
                query = replace(query, status=PlanStatus.NO_VALID_PATH)
            return Plan(query)
        direct = _straight(query, costs)
        if direct is not None:
            return Plan(query.answer(direct), 0.0)
        potential = self._potential(query, costs)
        end = query.reachable_end(potential)
        if end is None:
            return Plan(query.failure(potential))
        path_cost = float(potential[end]) if end == query.goal_cell else math.inf
        return Plan(query.answer(descend(potential, end)[::-1]), path_cost)

    def _potential(self, query: Query, costs: Singles) -> Singles:
        """Return the potential about the best path, or of the whole map where that is needed."""
        data, goal, seeds = query.costmap.data, query.goal_cell, query.out.seeds(NEUTRAL)
        slack = _SLACK_ASTAR if self._config.use_astar else _SLACK
        within = corridors(data, costs, query.out.nearest, goal, slack)
        if within is None:
            return query.approach(costs, seeds)
        return guided(
            lambda one: wavefront(data, costs, seeds, goal, one.open, one.shift),
            lambda potential: float(potential[goal] - seeds[0, 2]),
            within,
        )


def _straight(query: Query, costs: Singles) -> Floats | None:
    """Return the straight line `(N, 2)`, half a cell apart, if it crosses the cheapest cells alone.

    No path is shorter or cheaper, so that no wave need look for one.
    """
    (row0, column0), (row1, column1) = query.out.nearest, query.goal_cell
    length = math.hypot(row1 - row0, column1 - column0)
    cost = line_cost(query.costmap.data, costs, row0, column0, row1, column1)
    if len(query.out.exits) > 1 or cost > float(costs.min()) * length * (1.0 + 1e-6):
        return None
    return np.linspace((row0, column0), (row1, column1), max(math.ceil(2.0 * length), 1) + 1)
