"""NavFn: a wave of potential from the robot to the goal, and the way back down."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from arjuna_core.config import param
from arjuna_core.se2 import SE2
from arjuna_nav.costmap.costmap import INSCRIBED, LETHAL, UNKNOWN, Costmap
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.planners.base import PlanResult, PlanStatus
from arjuna_nav.planners.potential import COST_FACTOR, NEUTRAL, descend, spread, traversal_costs


@dataclass(frozen=True)
class NavFnConfig:
    """Parameters of NavFn, by Nav2's names."""

    tolerance: float = param(
        0.5, "How far from a blocked goal the path may end.", unit="m", minimum=0.0
    )
    use_astar: bool = param(
        False, "A* search, not offered: it re-expands and is slower here.", choices=(False,)
    )
    escape_radius: float = param(
        0.15, "How deep in an inscribed zone a start is still led out.", unit="m", minimum=0.0
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
        `tolerance`. The start's own cell counts as free, and a start slightly inside an inscribed
        zone is led out of it.
        """
        frame = costmap.frame
        start_cell, goal_cell = frame.to_cell(start.x, start.y), frame.to_cell(goal.x, goal.y)
        for cell, pose, name, status in (
            (start_cell, start, "start", PlanStatus.START_OUTSIDE_MAP),
            (goal_cell, goal, "goal", PlanStatus.GOAL_OUTSIDE_MAP),
        ):
            if not frame.contains(*cell):
                return PlanResult.failed(status, f"{_place(name, pose)} lies outside the costmap")
        costs = traversal_costs(costmap.data, self._config.allow_unknown)
        _open_start(costs, costmap, start_cell, self._config.escape_radius)
        potential = spread(costs, start_cell, goal_cell)
        end = self._reachable_end(costmap, potential, goal_cell)
        if end is None:
            return self._failure(costmap, potential, start, goal)
        cells = descend(potential, end, start_cell)[::-1]
        points = frame.origin.apply((cells[:, ::-1] + 0.5) * frame.resolution)
        return PlanResult(
            PlanStatus.SUCCEEDED,
            _with_ends(points, start, goal, frame.resolution, reached=end == goal_cell),
        )

    def _reachable_end(
        self, costmap: Costmap, potential: NDArray[np.float64], goal: tuple[int, int]
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
        self, costmap: Costmap, potential: NDArray[np.float64], start: SE2, goal: SE2
    ) -> PlanResult:
        """Say why the wave did not come near the goal."""
        start_cost, goal_cost = (costmap.cost_at(pose.x, pose.y) for pose in (start, goal))
        reached = int(np.isfinite(potential).sum())
        if _blocks(start_cost, allow_unknown=True) and not _left_inscribed(costmap, potential):
            message = f"{_place('start', start)} has cost {start_cost} and no way out"
            return PlanResult.failed(PlanStatus.START_OCCUPIED, message)
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


def _left_inscribed(costmap: Costmap, potential: NDArray[np.float64]) -> bool:
    """Tell whether the wave came to a cell that is not within an obstacle's inscribed zone."""
    data = costmap.data[np.isfinite(potential)]
    return bool(((data < INSCRIBED) | (data == UNKNOWN)).any())


def _open_start(
    costs: NDArray[np.float64], costmap: Costmap, start: tuple[int, int], radius: float
) -> None:
    """Let the robot out of where it stands: its own cell, and inscribed cells close by."""
    dear = NEUTRAL + COST_FACTOR * (INSCRIBED - 1)
    if not math.isfinite(costs[start]):
        reach = int(radius / costmap.frame.resolution)
        rows, columns = (slice(max(v - reach, 0), v + reach + 1) for v in start)
        window, data = costs[rows, columns], costmap.data[rows, columns]
        window[(data >= INSCRIBED) & (data < LETHAL)] = dear
        costs[start] = dear


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
