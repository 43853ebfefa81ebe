"""Hybrid A*'s search: poses reached by arcs and straights, the likeliest first."""

from __future__ import annotations

import heapq
import math
from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from arjuna_nav.costmap.collision import collides_in_cells
from arjuna_nav.costmap.costmap import INSCRIBED, UNKNOWN
from arjuna_nav.planners.hybrid.curves import along, moved, shortest
from arjuna_nav.planners.pose_table import PoseTable, begun, rows_to, with_room

_MOVES = 6  # left, straight, right; then the same backwards
_STEP = 0.5  # between two poses that are looked at for collisions [cells]


class Terrain(NamedTuple):
    """Where the robot drives: the costs and its outline, in cells.

    Attributes:
        data: `(height, width) uint8`.
        left: `(height, width) float32` what it costs to come from a cell to the goal.
        points: `(N, 2)` the robot's corners.
        circular: Whether it is a circle.
        safe_cost: Cost below which no heading collides.
        allow_unknown: Whether it may cross unknown cells.
    """

    data: NDArray[np.uint8]
    left: NDArray[np.float32]
    points: NDArray[np.float64]
    circular: bool
    safe_cost: int
    allow_unknown: bool


class Rules(NamedTuple):
    """How it drives, and what that costs; lengths in cells. See `HybridConfig`."""

    bins: int
    radius: float
    piece: float
    reverse: bool
    reverse_penalty: float
    change_penalty: float
    bend_penalty: float
    cost_penalty: float
    straight: float
    direct_ratio: float
    direct_length: float
    direct_cost: float
    limit: int


@njit(cache=True)
def search(
    start: NDArray[np.float64], goal: NDArray[np.float64], terrain: Terrain, rules: Rules
) -> tuple[PoseTable, int, NDArray[np.float64], int]:
    """Search from a pose to another.

    Returns:
        The poses reached, the last row before the direct curve to the goal, that curve, and how
        many poses were looked at; the row is -1 where the goal was not reached.
    """
    nodes = begun(start)
    rows = {_key(start, terrain, rules): np.int64(0)}
    queue = [(_left(start, goal, terrain, rules), np.int64(0))]
    count, looked, until_direct = 1, 0, 0.0
    while len(queue) > 0 and looked < rules.limit:
        row = heapq.heappop(queue)[1]
        pose = nodes.poses[row].copy()
        if nodes.done[row] or rows[_key(pose, terrain, rules)] != row:
            continue
        nodes.done[row], looked = True, looked + 1
        until_direct -= 1.0
        if until_direct <= 0.0:
            curve = _direct(pose, goal, terrain, rules)
            if curve[1, 0] != np.inf:
                return nodes, row, curve, looked
            distance = math.hypot(pose[0] - goal[0], pose[1] - goal[1])
            until_direct = max(distance / rules.direct_ratio / rules.piece, 1.0)
        nodes = with_room(nodes, count, _MOVES)
        count = _expand(row, count, nodes, rows, queue, goal, terrain, rules)
    return nodes, -1, np.zeros((2, 5)), looked


@njit(cache=True)
def _expand(
    row: int,
    count: int,
    nodes: PoseTable,
    rows: Any,
    queue: Any,
    goal: NDArray[np.float64],
    terrain: Terrain,
    rules: Rules,
) -> int:
    """Add the poses that one piece leads to from a row; return how many rows there are."""
    pose = nodes.poses[row].copy()
    for move in range(_MOVES if rules.reverse else _MOVES // 2):
        kind, length = _piece(move, rules)
        cost = _drive(pose, kind, length, terrain, rules)
        if cost == np.inf:
            continue
        value = nodes.values[row] + cost * _factor(move, nodes.kinds[row], rules)
        reached = np.array(moved(pose[0], pose[1], pose[2], kind, length, rules.radius))
        key = _key(reached, terrain, rules)
        if key in rows and (nodes.done[rows[key]] or nodes.values[rows[key]] <= value):
            continue
        rows[key] = count
        nodes.poses[count], nodes.values[count] = reached, value
        nodes.before[count], nodes.kinds[count] = row, move
        heapq.heappush(queue, (value + _left(reached, goal, terrain, rules), np.int64(count)))
        count += 1
    return count


@njit(cache=True)
def _piece(move: int, rules: Rules) -> tuple[float, float]:
    """Return what a move drives: 1 left, -1 right, 0 straight; and its length, below 0 back."""
    return float(move % 3 - 1), rules.piece if move < 3 else -rules.piece


@njit(cache=True)
def _key(pose: NDArray[np.float64], terrain: Terrain, rules: Rules) -> int:
    """Return the number of a pose's cell and heading."""
    width, turn = terrain.data.shape[1], 2.0 * math.pi
    heading = math.floor((pose[2] % turn) / turn * rules.bins + 0.5) % rules.bins
    key: int = (math.floor(pose[1]) * width + math.floor(pose[0])) * rules.bins + heading
    return key


@njit(cache=True)
def _left(
    pose: NDArray[np.float64], goal: NDArray[np.float64], terrain: Terrain, rules: Rules
) -> float:
    """Return the least that is left: by the costs round obstacles, or by the bends alone."""
    by_costs = float(terrain.left[math.floor(pose[1]), math.floor(pose[0])])
    dx, dy = (goal[0] - pose[0]) / rules.radius, (goal[1] - pose[1]) / rules.radius
    if by_costs > 12.0 * rules.radius + 2.0 * rules.radius * math.hypot(dx, dy):
        return by_costs  # more than any curve's length
    c, s = math.cos(pose[2]), math.sin(pose[2])
    curve = shortest(c * dx + s * dy, c * dy - s * dx, goal[2] - pose[2], rules.reverse)
    by_bends: float = np.abs(curve[1]).sum() * rules.radius * rules.straight
    return max(by_costs, by_bends)


@njit(cache=True)
def _drive(
    pose: NDArray[np.float64], kind: float, length: float, terrain: Terrain, rules: Rules
) -> float:
    """Return the length of a piece with the costs along it, inf where it collides."""
    steps = int(abs(length) / _STEP) + 1
    total, here = 0.0, pose.copy()
    for _ in range(steps):
        here[0], here[1], here[2] = moved(
            here[0], here[1], here[2], kind, length / steps, rules.radius
        )
        cost = cost_at(here, terrain)
        if cost == np.inf:
            return np.inf
        total += cost
    return abs(length) * (rules.straight + rules.cost_penalty * total / steps / (INSCRIBED - 1))


@njit(cache=True)
def cost_at(pose: NDArray[np.float64], terrain: Terrain) -> float:
    """Return the cost under the robot at a pose [cells, rad], inf where it may not be."""
    data = terrain.data
    if collides_in_cells(data, pose, terrain.points, terrain.circular, terrain.safe_cost):
        return np.inf
    cost = data[math.floor(pose[1]), math.floor(pose[0])]
    if cost == UNKNOWN:
        return float(INSCRIBED - 1) if terrain.allow_unknown else np.inf
    return float(cost)


@njit(cache=True)
def _factor(move: int, last: int, rules: Rules) -> float:
    """Return how dear a move is after another: bends, changes of side and driving back are."""
    factor = rules.reverse_penalty if move >= 3 else 1.0
    side = move % 3 - 1
    if side == 0:
        return factor
    changes = last >= 0 and last % 3 - 1 == -side
    return factor * (rules.bend_penalty + (rules.change_penalty if changes else 0.0))


@njit(cache=True)
def _direct(
    pose: NDArray[np.float64], goal: NDArray[np.float64], terrain: Terrain, rules: Rules
) -> NDArray[np.float64]:
    """Return the shortest curve to the goal; its first length is inf where it may not be driven."""
    dx, dy = (goal[0] - pose[0]) / rules.radius, (goal[1] - pose[1]) / rules.radius
    c, s = math.cos(pose[2]), math.sin(pose[2])
    curve = shortest(c * dx + s * dy, c * dy - s * dx, goal[2] - pose[2], rules.reverse)
    allowed = np.abs(curve[1]).sum() * rules.radius <= rules.direct_length
    if allowed:
        for reached in along(pose, curve, rules.radius, _STEP):
            if cost_at(reached, terrain) > rules.direct_cost:
                allowed = False
                break
    if not allowed:
        curve[1, 0] = np.inf
    return curve


@njit(cache=True)
def driven(
    nodes: PoseTable, row: int, curve: NDArray[np.float64], rules: Rules
) -> NDArray[np.float64]:
    """Return the poses from the start to the goal, `(N, 3)`, at most a cell apart."""
    rows = rows_to(nodes, row)
    pieces = [nodes.poses[:1].copy()]
    for k in range(1, len(rows)):
        kind, length = _piece(nodes.kinds[rows[k]], rules)
        piece = np.array([[kind], [length / rules.radius]])
        pieces.append(along(nodes.poses[rows[k - 1]], piece, rules.radius, 1.0))
    pieces.append(along(nodes.poses[row], curve, rules.radius, 1.0))
    total = 0
    for part in pieces:
        total += len(part)
    poses = np.empty((total, 3))
    at = 0
    for part in pieces:
        poses[at : at + len(part)] = part
        at += len(part)
    return poses
