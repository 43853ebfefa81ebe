"""A query to a planner on a grid, and the path or failure that answers it."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arjuna_core.arrays import Floats, Singles
from arjuna_core.se2 import SE2
from arjuna_nav.costmap.costmap import INSCRIBED, UNKNOWN, Costmap
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.planners.base import GridPlannerConfig, Planner, PlanResult, PlanStatus
from arjuna_nav.planners.escape import Escape
from arjuna_nav.planners.outline import plan_for_outline
from arjuna_nav.planners.path import shifted
from arjuna_nav.planners.waves.potential import reachable, traversal_costs, wavefront

Cell = tuple[int, int]


@dataclass(frozen=True, eq=False)
class Query:
    """A start from which the robot can come to free cells, and a goal on the costmap.

    Attributes:
        out: Paths from the start to the cells where a robot may be.
        allow_unknown: True where paths may cross unknown space.
        tolerance: Greatest distance of the path's end from a blocked goal [m].
        ends_along: True where the path ends in its own direction.
        fits: Whether the robot may stand in a cell where the path ends.
    """

    costmap: Costmap
    start: SE2
    goal: SE2
    goal_cell: Cell
    out: Escape
    allow_unknown: bool
    tolerance: float
    ends_along: bool = False
    fits: Callable[[Cell], bool] = lambda cell: True

    def reachable_end(self, values: Singles) -> Cell | None:
        """Return the goal's cell, or the reached cell nearest to it within the tolerance that fits.

        Args:
            values: `(height, width)` cost to reach each cell, inf where none is known.
        """
        goal = self.goal_cell
        if math.isfinite(values[goal]) and self.fits(goal):
            return goal
        reach = int(self.tolerance / self.costmap.frame.resolution)
        row0, column0 = max(goal[0] - reach, 0), max(goal[1] - reach, 0)
        window = values[row0 : goal[0] + reach + 1, column0 : goal[1] + reach + 1]
        cells = np.argwhere(np.isfinite(window)) + np.array([row0, column0])
        distances = np.hypot(*(cells - np.array(goal)).T)
        order = np.lexsort((values[tuple(cells.T)], distances))
        near = cells[order[distances[order] <= reach]].tolist()
        return next(((row, column) for row, column in near if self.fits((row, column))), None)

    def approach(self, costs: Singles, seeds: Floats) -> Singles:
        """Return the potential as far as the goal or the reachable cell nearest to it.

        Where no cell within the tolerance can be reached, it is 0 in each that can be.

        Args:
            costs: Cost of crossing a cell by its value, `(256,) float32`.
            seeds: `(N, 3)` row, column and potential of the cells where the wave begins.
        """
        data = self.costmap.data
        reached = np.where(reachable(data, costs, seeds), np.float32(0.0), np.float32(np.inf))
        end = self.reachable_end(reached)
        return reached if end is None else wavefront(data, costs, seeds, end)

    def failure(self, values: Singles) -> PlanResult:
        """Say why nothing near the goal was reached."""
        goal_cost = self.costmap.cost_at(self.goal.x, self.goal.y)
        tolerance = f"within {self.tolerance:g} m"
        if _blocks(goal_cost, self.allow_unknown):
            message = (
                f"{_named('goal', self.goal)} has cost {goal_cost}, nothing reachable {tolerance}"
            )
            return PlanResult.failed(PlanStatus.GOAL_OCCUPIED, message)
        if not self.fits(self.goal_cell):
            message = (
                f"at {_named('goal', self.goal)} with its heading the outline touches something, so"
                f" it does wherever can be reached {tolerance}"
            )
            return PlanResult.failed(PlanStatus.GOAL_OCCUPIED, message)
        message = (
            f"no path from {_named('start', self.start)} to {_named('goal', self.goal)} or "
            f"{tolerance}; {int(np.isfinite(values).sum())} cells can be reached"
        )
        return PlanResult.failed(PlanStatus.NO_VALID_PATH, message)

    def answer(self, points: Floats) -> PlanResult:
        """Return the path along `(N, 2)` rows and columns from an exit of the start to the end."""
        first = round(points[0, 0]), round(points[0, 1])
        frame = self.costmap.frame
        metres = np.concatenate((self.out.to(first)[:, ::-1], points[:, ::-1]))
        metres += 0.5
        metres *= frame.resolution
        metres = frame.origin.apply(metres)
        end = round(points[-1, 0]), round(points[-1, 1])
        reached = end == self.goal_cell
        path = _with_ends(metres, self.start, self.goal, frame.resolution, reached)
        if self.ends_along:
            path[-1, 2] = path[-2, 2]
        return PlanResult(PlanStatus.SUCCEEDED, path)


def ask(
    config: GridPlannerConfig, costmap: Costmap, start: SE2, goal: SE2, ends_along: bool = False
) -> Query | PlanResult:
    """Return a query, or why there can be no answer."""
    frame = costmap.frame
    start_cell, goal_cell = frame.to_cell(start.x, start.y), frame.to_cell(goal.x, goal.y)
    for cell, pose, name, status in (
        (start_cell, start, "start", PlanStatus.START_OUTSIDE_MAP),
        (goal_cell, goal, "goal", PlanStatus.GOAL_OUTSIDE_MAP),
    ):
        if not frame.contains(*cell):
            message = f"{_named(name, pose)} lies outside the costmap, which spans {frame.span}"
            return PlanResult.failed(status, message)
    costs = traversal_costs(config.allow_unknown)
    out = Escape(costmap.data, costs, start_cell, config.escape_radius / frame.resolution)
    if not len(out.exits):
        cost = costmap.cost_at(start.x, start.y)
        message = f"{_named('start', start)} has cost {cost} and no way out"
        return PlanResult.failed(PlanStatus.START_OCCUPIED, message)
    return Query(
        costmap, start, goal, goal_cell, out, config.allow_unknown, config.tolerance, ends_along
    )


def _named(name: str, pose: SE2) -> str:
    return f"{name} ({pose.x:.2f}, {pose.y:.2f})"


def _blocks(cost: int | None, allow_unknown: bool) -> bool:
    """Return whether a cost keeps the robot's centre out."""
    if cost == UNKNOWN:
        return not allow_unknown
    return cost is not None and cost >= INSCRIBED


def _with_ends(points: Floats, start: SE2, goal: SE2, spacing: float, reached: bool) -> Floats:
    """Return the path as poses that look along it, from the exact start to the goal's heading."""
    first = np.array([start.x, start.y])
    last = np.array([goal.x, goal.y]) if reached else points[-1]
    begin = _count_near(points, first, spacing)  # cells beside the exact ends make kinks
    end = max(len(points) - _count_near(points[::-1], last, spacing), begin)
    return oriented(np.vstack((first, points[begin:end], last)), goal.theta)


def _count_near(points: Floats, end: Floats, radius: float) -> int:
    for count, (x, y) in enumerate(points):
        if (x - end[0]) * (x - end[0]) + (y - end[1]) * (y - end[1]) > radius**2:
            return count
    return len(points)


def oriented(points: Floats, final_yaw: float) -> Floats:
    """Return points `(N, 2)` as poses `(N, 3)`: each looks at the next, the last as given [rad]."""
    poses = np.empty((len(points), 3))
    poses[:, :2], poses[-1, 2] = points, final_yaw
    x, y = (points[1:] - points[:-1]).T
    np.arctan2(y, x, out=poses[:-1, 2])
    return poses


def traced(before: NDArray[np.int32], end: Cell, width: int) -> Floats:
    """Return the cells from a search's seed to the end, `(N, 2)` rows and columns.

    Args:
        before: The number of the cell before each, `(height * width,)`; a seed's own.
    """
    cells = [end[0] * width + end[1]]
    while before[cells[-1]] != cells[-1]:
        cells.append(int(before[cells[-1]]))
    numbers = np.array(cells[::-1])
    return np.column_stack((numbers // width, numbers % width)).astype(np.float64)


def plan_through(
    planner: Planner,
    costmap: Costmap,
    start: SE2,
    goals: Sequence[SE2],
    footprint: Footprint | None = None,
    fits: bool = True,
) -> PlanResult:
    """Plan through poses to the last; without any, NO_VALID_PATH.

    Where a footprint is given and the path is to fit it, one that its outline could not follow is
    replaced by one that it can, if there is one. Planned is for its axle, of which the planner has
    the outline too.
    """
    if not goals:
        return PlanResult.failed(PlanStatus.NO_VALID_PATH, "no goals were given")
    axle = 0.0 if footprint is None else footprint.axle
    if footprint is not None and axle:
        start, *goals = (pose @ SE2(axle) for pose in (start, *goals))
        footprint = footprint.of_axle
    pieces: list[Floats] = []
    expansions: list[Floats] = []
    for goal in goals:
        result = (
            planner.plan(costmap, start, goal)
            if footprint is None or not fits
            else plan_for_outline(planner, costmap, start, goal, footprint)
        )
        if result.status is not PlanStatus.SUCCEEDED:
            return result
        pieces.append(result.path)
        if result.expansions is not None:
            expansions.append(result.expansions)
        start = SE2.from_array(result.path[-1])
    expanded = np.vstack(expansions) if expansions else None
    path = shifted(np.vstack(pieces), -axle)
    return PlanResult(PlanStatus.SUCCEEDED, path, expansions=expanded)
