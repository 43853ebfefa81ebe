"""A* over poses: ahead, in bends, straight back and turns on the spot, the outline checked."""

from __future__ import annotations

import heapq
import math
from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from arjuna_nav.costmap.collision import clearance_to_keep, collides_in_cells, comes_nearer
from arjuna_nav.planners.pose_table import PoseTable, begun, rows_to, with_room

_TURN = 2.0 * math.pi / 32  # between two headings that are told apart
_STRIDE = 1.5  # longer than a cell's diagonal: each leads to another cell [cells]
_STRIDES = (_STRIDE, _STRIDE, _STRIDE, -_STRIDE, 0.0, 0.0)
_BENDS = (0, 1, -1, 0, 1, -1)
_BEND = 1.1  # price of a bend against straight on
_LOOKS = 2  # at each move, for collisions
_DEAREST = 252  # of the costs that a centre may have


class Ground(NamedTuple):
    """What is driven on.

    Attributes:
        data: `(height, width) uint8` of a costmap.
        costs: `(256,) float32` of `traversal_costs`.
        left: `(height, width) float32` what it costs at the least from a cell to the goal.
        points: `(N, 2) float64` the outline's corners [cells].
        circular: Whether the outline is a circle.
        safe_cost: Cost below which no heading collides.
        reach: Distance of the farthest corner from the centre [cells].
    """

    data: NDArray[np.uint8]
    costs: NDArray[np.float32]
    left: NDArray[np.float32]
    points: NDArray[np.float64]
    circular: bool
    safe_cost: int
    reach: float


class Prices(NamedTuple):
    """What motions cost, in the ground's costs times cells.

    Attributes:
        turn: Of a turn by one radian on the spot.
        stop: Of each change between driving ahead, back and turning.
        back: Factor on what is driven back.
    """

    turn: float
    stop: float
    back: float


class Goal(NamedTuple):
    """Where to come: a pose, and how near to it.

    Attributes:
        pose: `(x, y, theta)` [cells, rad].
        distance: [cells].
        angle: [rad]
    """

    pose: NDArray[np.float64]
    distance: float
    angle: float


@njit(cache=True)
def search(
    start: NDArray[np.float64], goal: Goal, ground: Ground, prices: Prices, limit: int
) -> NDArray[np.float64]:
    """Return the poses of the cheapest way, `(N, 3)` [cells, rad], the start first; else none.

    Between two poses lies a stride ahead, straight or in a bend, a straight stride back, or a turn
    on the spot. A start that collides may be left over poses that lie no nearer to the obstacle;
    one whose centre is on a lethal cell by moves that each lead out of it.

    Args:
        start: `(x, y, theta)` [cells, rad].
        goal: Where to come.
        ground: Where to drive.
        prices: What motions cost.
        limit: Most poses looked at.

    Source: Hart, Nilsson and Raphael 1968; the states are those of a differential drive's lattice,
        Pivtoraiko, Knepper and Kelly, Differentially constrained mobile robot motion planning in
        state lattices, JFR 2009.
    """
    nodes = begun(start)
    rows = {_key(start, start[2], ground): np.int64(0)}
    queue = [(_left(start, goal, ground), np.int64(0))]
    # A plain 1 for the count has what takes it compiled twice.
    allowed, count, looked = _allowed(start, ground), np.int64(1), 0
    while len(queue) > 0 and looked < limit:
        row = heapq.heappop(queue)[1]
        if nodes.done[row] or rows[_key(nodes.poses[row], start[2], ground)] != row:
            continue
        if _is_reached(nodes.poses[row], goal):
            return nodes.poses[rows_to(nodes, row)]
        nodes.done[row], looked = True, looked + 1
        nodes = with_room(nodes, count, len(_STRIDES))
        count = _expand(row, count, nodes, rows, queue, allowed, start[2], goal, ground, prices)
    return np.empty((0, 3))


@njit(cache=True)
def _expand(
    row: int,
    count: int,
    nodes: PoseTable,
    rows: Any,
    queue: Any,
    allowed: float,
    first: float,
    goal: Goal,
    ground: Ground,
    prices: Prices,
) -> int:
    """Add the poses that one move leads to from a row; return how many rows there are."""
    if allowed < np.inf and not _touches(nodes.poses[row], ground):
        allowed = np.inf  # it has left the place
    elif allowed < 0.0:
        allowed = _allowed(nodes.poses[row], ground)
    for kind in range(len(_STRIDES)):
        reached = nodes.poses[row].copy()
        value = nodes.values[row] + _move(reached, kind, allowed, ground, prices)
        if value == np.inf:
            continue
        last = nodes.kinds[row]
        if last >= 0 and np.sign(_STRIDES[kind]) != np.sign(_STRIDES[last]):
            value += prices.stop
        key = _key(reached, first, ground)
        if key in rows and nodes.values[rows[key]] <= value:
            continue
        rows[key] = count
        nodes.poses[count], nodes.values[count] = reached, value
        nodes.before[count], nodes.kinds[count] = row, kind
        heapq.heappush(queue, (value + _left(reached, goal, ground), np.int64(count)))
        count += 1
    return count


@njit(cache=True)
def _allowed(start: NDArray[np.float64], ground: Ground) -> float:
    """Return what `comes_nearer` allows from a pose on, inf where none may collide."""
    if not _touches(start, ground):
        return np.inf
    kept: float = clearance_to_keep(ground.data, start, ground.reach)
    return kept


@njit(cache=True)
def _touches(pose: NDArray[np.float64], ground: Ground) -> bool:
    hit: bool = collides_in_cells(
        ground.data, pose, ground.points, ground.circular, ground.safe_cost
    )
    return hit


@njit(cache=True)
def _move(
    pose: NDArray[np.float64], kind: int, allowed: float, ground: Ground, prices: Prices
) -> float:
    """Move a pose, and return the price; inf where it collides."""
    stride, turn = _STRIDES[kind], _TURN * _BENDS[kind]
    if allowed < 0.0 and stride == 0.0:
        return np.inf  # a turn does not lead out of what the centre is on
    for _ in range(_LOOKS):
        pose[2] += 0.5 * turn / _LOOKS
        pose[0] += stride / _LOOKS * math.cos(pose[2])
        pose[1] += stride / _LOOKS * math.sin(pose[2])
        pose[2] += 0.5 * turn / _LOOKS
        if allowed < 0.0 and comes_nearer(ground.data, pose, allowed):
            return np.inf
        if not _touches(pose, ground):
            allowed = np.inf
        elif comes_nearer(ground.data, pose, allowed):
            return np.inf
    if stride == 0.0:
        return prices.turn * _TURN
    cost = ground.costs[ground.data[math.floor(pose[1]), math.floor(pose[0])]]
    if cost == np.inf:  # it leaves where it may not be, at the dearest
        cost = ground.costs[_DEAREST]
    factor = prices.back if stride < 0.0 else 1.0 if turn == 0.0 else _BEND
    return abs(stride) * float(cost) * factor


@njit(cache=True)
def _is_reached(pose: NDArray[np.float64], goal: Goal) -> bool:
    near = math.hypot(pose[0] - goal.pose[0], pose[1] - goal.pose[1]) <= goal.distance
    off = (pose[2] - goal.pose[2] + math.pi) % (2.0 * math.pi) - math.pi
    return near and abs(off) <= goal.angle


@njit(cache=True)
def _left(pose: NDArray[np.float64], goal: Goal, ground: Ground) -> float:
    """Return what the way from a pose to the goal costs at the least."""
    by_costs = float(ground.left[math.floor(pose[1]), math.floor(pose[0])])
    if by_costs < np.inf:
        return by_costs
    gap = math.hypot(pose[0] - goal.pose[0], pose[1] - goal.pose[1])
    return float(ground.costs[0]) * max(gap - goal.distance, 0.0)


@njit(cache=True)
def _key(pose: NDArray[np.float64], first: float, ground: Ground) -> int:
    """Return the number of a pose's cell and heading; headings count from the start's."""
    headings = round(2.0 * math.pi / _TURN)
    heading = math.floor((pose[2] - first) / _TURN + 0.5) % headings
    cell = math.floor(pose[1]) * ground.data.shape[1] + math.floor(pose[0])
    key: int = cell * headings + heading
    return key
