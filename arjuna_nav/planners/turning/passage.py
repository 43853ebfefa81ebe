"""Ways that the robot's outline can follow, heading by heading."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from arjuna_core.se2 import SE2
from arjuna_nav.costmap.collision import collides_in_cells
from arjuna_nav.costmap.costmap import INSCRIBED, LETHAL, MAX_NON_OBSTACLE, Costmap
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.costmap.window import clipped
from arjuna_nav.planners.base import Planner, PlanResult, PlanStatus
from arjuna_nav.planners.turning.search import Goal, Ground, Prices, search
from arjuna_nav.planners.waves.potential import NEUTRAL, spread, traversal_costs

_CHORD = 0.3  # over which a path's direction is taken; so far from its start it may turn [m]
_CLOSED = 3  # radius of what is closed to planners where the outline collides [cells]
_WAYS_ROUND = 6  # plans in which one more place is closed, until one has room to turn
_COARSENESS = (0.5, 1.1)  # that gaps may be wider than cells say: of one side, of both [cells]
_NEAREST = 1.5  # how near to its end a way can be asked to come [cells]


class Terms(NamedTuple):
    """What a way is worth, and where it may end.

    Attributes:
        turn: How much way a turn by one radian on the spot is worth [m/rad].
        stop: How much way a stop is worth [m].
        back: How much way a metre back is worth.
        distance: From the end [m].
        angle: From the end's heading [rad].
        limit: Most poses looked at.
    """

    turn: float
    stop: float
    back: float
    distance: float
    angle: float
    limit: int

    def worth(self, way: NDArray[np.float64]) -> float:
        """Return how much way [m] the poses of a way `(N, 3)` are worth."""
        steps, middle = np.diff(way[:, :2], axis=0), 0.5 * (way[1:, 2] + way[:-1, 2])
        ahead = steps[:, 0] * np.cos(middle) + steps[:, 1] * np.sin(middle)
        turns = np.abs(np.diff(way[:, 2]))[np.abs(ahead) < 1e-6].sum()
        stops = np.count_nonzero(np.diff(np.sign(np.round(ahead, 6))))
        driven = np.where(ahead < 0.0, -self.back * ahead, ahead).sum()
        return float(driven + self.turn * turns + self.stop * stops)


_PLAN = Terms(turn=0.5, stop=0.25, back=4.0, distance=0.0, angle=math.pi, limit=30000)


def plan_for_outline(
    planner: Planner, costmap: Costmap, start: SE2, goal: SE2, footprint: Footprint
) -> PlanResult:
    """Return a plan that the outline can follow where there is one, else the planner's own.

    A planner on the grid alone takes the robot for a circle of its inscribed radius: it leads one
    that is longer than wide through gaps before which it cannot turn. Then a way is looked for
    heading by heading, nearby; and where there is none, the planner is asked for ways elsewhere.

    Args:
        planner: Any.
        costmap: The costs.
        start: The robot's pose.
        goal: Where to plan to.
        footprint: The robot's outline.
    """
    plan = planner.plan(costmap, start, goal)
    if plan.status is PlanStatus.NO_VALID_PATH:
        return _through_gaps(planner, costmap, start, goal, footprint) or plan
    if plan.status is not PlanStatus.SUCCEEDED or footprint.circular:
        return plan
    blocked = first_blocked(plan.path, costmap, footprint)
    if blocked is None:
        return plan
    way = find_way(start, SE2.from_array(plan.path[-1]), costmap, footprint, _PLAN)
    if len(way) > 1:
        return replace(plan, path=np.vstack((way[:-1], plan.path[-1:])))
    closed = replace(costmap, data=costmap.data.copy())
    for _ in range(_WAYS_ROUND):
        _close(closed, blocked)
        other = planner.plan(closed, start, goal)
        if other.status is not PlanStatus.SUCCEEDED:
            break
        blocked = first_blocked(other.path, costmap, footprint)
        if blocked is None:
            return other
    return plan


def _through_gaps(
    planner: Planner, costmap: Costmap, start: SE2, goal: SE2, footprint: Footprint
) -> PlanResult | None:
    """Return a plan through gaps that only the coarseness of cells may close, None where none is.

    Walls lie somewhere in their cells, and the robot's centre need not lie in a cell's middle.
    """
    for coarseness in _COARSENESS:
        radius = footprint.inscribed_radius / costmap.frame.resolution - coarseness
        data = opened(costmap.data, radius)
        plan = planner.plan(replace(costmap, data=data), start, goal)
        if plan.status is PlanStatus.SUCCEEDED:
            return plan
    return None


@njit(cache=True)
def opened(data: NDArray[np.uint8], radius: float) -> NDArray[np.uint8]:
    """Return costs in which cells are the dearest, not closed, beyond a radius of lethal ones.

    Args:
        data: `(height, width) uint8` of a costmap.
        radius: Between the cells' middles [cells].
    """
    height, width = data.shape
    reach = math.floor(radius)
    result: NDArray[np.uint8] = data.copy()
    for row in range(height):
        for column in range(width):
            if data[row, column] != INSCRIBED:
                continue
            closed = False
            for r in range(max(row - reach, 0), min(row + reach + 1, height)):
                for c in range(max(column - reach, 0), min(column + reach + 1, width)):
                    near = (r - row) ** 2 + (c - column) ** 2 <= radius * radius
                    closed = closed or (near and data[r, c] == LETHAL)
            if not closed:
                result[row, column] = MAX_NON_OBSTACLE
    return result


def _close(costmap: Costmap, place: NDArray[np.float64]) -> None:
    """Close the cells about a place `(x, y, ...)` to planners."""
    row, column = costmap.frame.to_cell(float(place[0]), float(place[1]))
    ends = row - _CLOSED, row + _CLOSED + 1, column - _CLOSED, column + _CLOSED + 1
    window = clipped(*ends, costmap.data.shape)
    rows, columns = np.ogrid[window]
    near = (rows - row) ** 2 + (columns - column) ** 2 <= _CLOSED**2
    costs = costmap.data[window]
    costs[near & (costs < INSCRIBED)] = INSCRIBED


def find_way(
    start: SE2, end: SE2, costmap: Costmap, footprint: Footprint, terms: Terms
) -> NDArray[np.float64]:
    """Return the poses of the outline's cheapest way, `(N, 3)` [m, m, rad]; none where none is.

    Args:
        start: The robot's pose in the costmap's frame.
        end: Where to come.
        costmap: The costs.
        footprint: The outline.
        terms: What the way is worth, and where it may end.
    """
    frame, costs = costmap.frame, traversal_costs()
    if not all(frame.contains(*frame.to_cell(one.x, one.y)) for one in (start, end)):
        return np.empty((0, 3))
    first, last = _in_cells(np.array([start.array(), end.array()]), costmap)
    seed = np.array([[math.floor(last[1]), math.floor(last[0]), 0.0]])
    ground = Ground(
        costmap.data,
        costs,
        spread(costmap.data, costs, seed, (math.floor(first[1]), math.floor(first[0]))),
        footprint.points / frame.resolution,
        footprint.circular,
        costmap.circumscribed_cost,
        footprint.circumscribed_radius / frame.resolution,
    )
    metre = NEUTRAL / frame.resolution
    prices = Prices(terms.turn * metre, terms.stop * metre, terms.back)
    goal = Goal(last, max(terms.distance / frame.resolution, _NEAREST), terms.angle)
    way = search(first, goal, ground, prices, terms.limit)
    way[:, :2] = frame.origin.apply(way[:, :2] * frame.resolution)
    way[:, 2] += frame.origin.theta
    return way


def first_blocked(
    path: NDArray[np.float64], costmap: Costmap, footprint: Footprint
) -> NDArray[np.float64] | None:
    """Return the first pose of a path at which the outline, looking along it, meets an obstacle."""
    index = _meets(
        _in_cells(path, costmap),
        _CHORD / costmap.frame.resolution,
        costmap.data,
        footprint.points / costmap.frame.resolution,
        costmap.circumscribed_cost,
    )
    return path[index] if index < len(path) else None


def _in_cells(poses: NDArray[np.float64], costmap: Costmap) -> NDArray[np.float64]:
    """Return poses of the costmap's frame in its grid [cells, rad]."""
    T_grid = costmap.frame.origin.inverse()
    points = T_grid.apply(poses[:, :2]) / costmap.frame.resolution
    return np.column_stack((points, poses[:, 2] + T_grid.theta))


@njit(cache=True)
def _meets(
    poses: NDArray[np.float64],
    chord: float,
    data: NDArray[np.uint8],
    points: NDArray[np.float64],
    safe_cost: int,
) -> int:
    """Return where the outline collides in the middle of a stretch as long as a chord."""
    back, pose = 0, np.empty(3)
    for i in range(len(poses)):
        dx, dy = poses[i, 0] - poses[back, 0], poses[i, 1] - poses[back, 1]
        if math.hypot(dx, dy) < chord:
            continue
        pose[:2], pose[2] = poses[(i + back) // 2, :2], math.atan2(dy, dx)
        if collides_in_cells(data, pose, points, False, safe_cost):
            return (i + back) // 2
        back += 1
    return len(poses)
