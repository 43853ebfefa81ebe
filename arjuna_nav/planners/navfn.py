"""NavFn: a wave of potential from the robot to the goal, and the way back down."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from arjuna_core.config import param
from arjuna_core.se2 import SE2
from arjuna_nav.costmap.costmap import INSCRIBED, UNKNOWN, Costmap
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.planners.base import PlanResult, PlanStatus
from arjuna_nav.planners.corridor import SHIFT, corridor
from arjuna_nav.planners.descent import descend
from arjuna_nav.planners.potential import NEUTRAL, spread, traversal_costs
from arjuna_nav.planners.way_out import WayOut

_SLACK, _SLACK_ASTAR = 0.005, 0.0  # of ways that are looked at, over the best estimate
_ESCAPE = 20.0 * NEUTRAL  # cost of a cell where the robot may not be: the nearest way out wins


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
        frame = costmap.frame
        start_cell, goal_cell = frame.to_cell(start.x, start.y), frame.to_cell(goal.x, goal.y)
        for cell, pose, name, status in (
            (start_cell, start, "start", PlanStatus.START_OUTSIDE_MAP),
            (goal_cell, goal, "goal", PlanStatus.GOAL_OUTSIDE_MAP),
        ):
            if not frame.contains(*cell):
                return PlanResult.failed(status, f"{_place(name, pose)} lies outside the costmap")
        costs = traversal_costs(self._config.allow_unknown)
        radius = self._config.escape_radius / frame.resolution
        out = WayOut(costmap.data, costs, start_cell, radius)
        if not len(out.exits):
            cost = costmap.cost_at(start.x, start.y)
            message = f"{_place('start', start)} has cost {cost} and no way out"
            return PlanResult.failed(PlanStatus.START_OCCUPIED, message)
        potential = self._potential(costmap.data, costs, out, goal_cell)
        end = self._reachable_end(costmap, potential, goal_cell)
        if end is None:
            return self._failure(costmap, potential, start, goal)
        way = descend(potential, end)[::-1]
        cells = np.vstack((out.to((int(way[0, 0]), int(way[0, 1]))), way))
        points = frame.origin.apply((cells[:, ::-1] + 0.5) * frame.resolution)
        return PlanResult(
            PlanStatus.SUCCEEDED,
            _with_ends(points, start, goal, frame.resolution, reached=end == goal_cell),
        )

    def _potential(
        self,
        data: NDArray[np.uint8],
        costs: NDArray[np.float32],
        out: WayOut,
        goal: tuple[int, int],
    ) -> NDArray[np.float32]:
        """Return the potential about the best way, or that of the whole map where that is needed.

        A wave through a corridor is believed unless it came to the goal not at all, or at a price
        that says that the estimate took a door for wider than it is.
        """
        exits = out.exits.astype(np.float64)
        seeds: NDArray[np.float64] = np.column_stack((exits, _ESCAPE * out.distances))
        nearest = int(out.exits[0, 0]), int(out.exits[0, 1])
        if math.isfinite(costs[data[goal]]):
            slack = _SLACK_ASTAR if self._config.use_astar else _SLACK
            found = corridor(data, costs, nearest, goal, slack)
            if found is not None:
                potential = spread(data, costs, seeds, goal, found[0], SHIFT)
                if potential[goal] - seeds[0, 2] <= found[1]:
                    return potential
        return spread(data, costs, seeds, goal)

    def _reachable_end(
        self, costmap: Costmap, potential: NDArray[np.float32], goal: tuple[int, int]
    ) -> tuple[int, int] | None:
        """Return the goal's cell, or the reached cell nearest to it within the tolerance."""
        if math.isfinite(potential[goal]):
            return goal
        reach = int(self._config.tolerance / costmap.frame.resolution)
        row0, column0 = max(goal[0] - reach, 0), max(goal[1] - reach, 0)
        window = potential[row0 : goal[0] + reach + 1, column0 : goal[1] + reach + 1]
        cells = np.argwhere(np.isfinite(window)) + np.array([row0, column0])
        distances = np.hypot(*(cells - np.array(goal)).T)
        if not len(cells) or distances.min() > reach:
            return None
        row, column = cells[np.lexsort((potential[tuple(cells.T)], distances))[0]]
        return int(row), int(column)

    def _failure(
        self, costmap: Costmap, potential: NDArray[np.float32], start: SE2, goal: SE2
    ) -> PlanResult:
        """Say why the wave did not come near the goal."""
        goal_cost, reached = costmap.cost_at(goal.x, goal.y), int(np.isfinite(potential).sum())
        tolerance = f"within {self._config.tolerance:g} m"
        if _blocks(goal_cost, self._config.allow_unknown):
            message = f"{_place('goal', goal)} has cost {goal_cost}, nothing reachable {tolerance}"
            return PlanResult.failed(PlanStatus.GOAL_OCCUPIED, message)
        message = (
            f"no path from {_place('start', start)} to {_place('goal', goal)} or {tolerance}; "
            f"{reached} cells can be reached"
        )
        return PlanResult.failed(PlanStatus.NO_VALID_PATH, message)


def _place(name: str, pose: SE2) -> str:
    return f"{name} ({pose.x:.2f}, {pose.y:.2f})"


def _blocks(cost: int | None, allow_unknown: bool) -> bool:
    """Tell whether a cost keeps the robot's centre out."""
    if cost == UNKNOWN:
        return not allow_unknown
    return cost is not None and cost >= INSCRIBED


def _with_ends(
    points: NDArray[np.float64], start: SE2, goal: SE2, spacing: float, reached: bool
) -> NDArray[np.float64]:
    """Return the path as poses that look along it, from the exact start to the goal's heading."""
    first = np.array([start.x, start.y])
    last = np.array([goal.x, goal.y]) if reached else points[-1]
    distances = np.minimum(np.hypot(*(points - first).T), np.hypot(*(points - last).T))
    between = points[distances > spacing]  # centres of cells beside the exact ends make kinks
    return oriented(np.vstack((first, between, last)), goal.theta)


def oriented(points: NDArray[np.float64], final_yaw: float) -> NDArray[np.float64]:
    """Return points `(N, 2)` as poses `(N, 3)`: each looks at the next, the last as given [rad]."""
    steps = np.diff(points, axis=0)
    yaw = np.append(np.arctan2(steps[:, 1], steps[:, 0]), final_yaw)
    return np.column_stack((points, yaw))
