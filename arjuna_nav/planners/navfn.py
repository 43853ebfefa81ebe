"""NavFn: a wave of potential from the robot to the goal, and the way back down."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from arjuna_core.config import param
from arjuna_core.se2 import SE2
from arjuna_nav.costmap.costmap import Costmap
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.planners.base import PlanResult
from arjuna_nav.planners.query import ask
from arjuna_nav.planners.waves.corridor import corridors, guided
from arjuna_nav.planners.waves.descent import descend
from arjuna_nav.planners.waves.potential import NEUTRAL, spread, traversal_costs
from arjuna_nav.planners.way_out import WayOut

_SLACK, _SLACK_ASTAR = 0.005, 0.0  # of ways that are looked at, over the best estimate


@dataclass(frozen=True)
class NavFnConfig:
    """Parameters of NavFn, by Nav2's names."""

    tolerance: float = param(
        0.5, "How far from a blocked goal the path may end.", unit="m", minimum=0.0
    )
    use_astar: bool = param(
        False,
        "Whether the wave keeps closer to the estimated way, as A* does: on large maps it is"
        " faster, and its path at times 1 % dearer.",
    )
    escape_radius: float = param(
        3.0, "How far a start too near to an obstacle is led out of it.", unit="m", minimum=0.0
    )
    allow_unknown: bool = param(True, "Whether paths may cross unknown space.")


class NavFn:
    """Plans by NavFn's potential.

    Args:
        config: Parameters.
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
        config = self._config
        costs = traversal_costs(config.allow_unknown)
        query = ask(config, costmap, start, goal)
        if isinstance(query, PlanResult):
            return query
        potential = self._potential(costmap.data, costs, query.out, query.goal_cell)
        end = query.reachable_end(potential)
        if end is None:
            return query.failure(potential)
        return query.answer(descend(potential, end)[::-1])

    def _potential(
        self,
        data: NDArray[np.uint8],
        costs: NDArray[np.float32],
        out: WayOut,
        goal: tuple[int, int],
    ) -> NDArray[np.float32]:
        """Return the potential about the best way, or of the whole map where that is needed."""
        seeds = out.seeds(NEUTRAL)
        slack = _SLACK_ASTAR if self._config.use_astar else _SLACK
        return guided(
            lambda within: spread(data, costs, seeds, goal, within.open, within.shift),
            lambda potential: float(potential[goal] - seeds[0, 2]),
            corridors(data, costs, out.nearest, goal, slack),
        )
