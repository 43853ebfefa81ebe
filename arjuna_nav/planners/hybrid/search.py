"""Hybrid A*'s search: poses reached by pieces of a table, the likeliest first."""

from __future__ import annotations

import heapq
import math
from typing import Any, NamedTuple

import numpy as np
from numba import njit

from arjuna_core.arrays import Bools, Bytes, Floats, Singles
from arjuna_nav.costmap.collision import collides_in_cells
from arjuna_nav.costmap.costmap import INSCRIBED, UNKNOWN
from arjuna_nav.planners.base import check_stopped, stop_flag
from arjuna_nav.planners.hybrid.curves import along, length_to, shortest
from arjuna_nav.planners.hybrid.moves import STEP, Moves
from arjuna_nav.planners.pose_table import (
    PoseTable,
    RowIndex,
    indexed,
    new_table,
    row_at,
    slot_of,
    with_block,
    with_room,
)

_SPIN = 32  # poses of half a turn on the spot that are looked at for collisions
_LONGER = 8.4  # turning radii at most by which Dubins' curve is longer than the straight line

_LONGER_REVERSE = math.pi + 1e-6  # and Reeds and Shepp's, which all but turns on the spot


class Terrain(NamedTuple):
    """The costs that the robot drives on and its outline, in cells.

    Attributes:
        data: `(height, width) uint8`.
        remaining: `(height, width) float32` cost from a cell to the goal.
        points: `(N, 2)` the robot's corners.
        circular: Whether it is a circle.
        safe_cost: Cost below which no heading collides.
        allow_unknown: Whether it may cross unknown cells.
    """

    data: Bytes
    remaining: Singles
    points: Floats
    circular: bool
    safe_cost: int
    allow_unknown: bool


class Rules(NamedTuple):
    """Motions of the robot and their costs; lengths in cells. See `HybridConfig`.

    Attributes:
        straight: Cost of a cell of a straight where nothing is near.
        bends: Factor on bends.
        spins: Whether it turns on the spot.
        turn: Cost of a turn by one radian on the spot.
        back: Factor on what is driven straight back.
        shortcuts: Whether any arc of the radius may be driven, not only the pieces.
        bends_within: Turning radii from the goal along each axis within which bends are estimated.
        any_cost_within: How near to the goal a direct curve may cross any cost.
        tolerance: How near to the goal a pose must be for the path to end there, below 0 for none.
        near_limit: How many poses are expanded from the first so near on.
        coarse: How many of the goal's headings are tried before one is found free.
        interval: How many poses are expanded between two looks at the flag that stops a search.
    """

    radius: float
    reverse: bool
    cost_penalty: float
    straight: float
    bends: float
    direct_ratio: float
    direct_length: float
    direct_cost: float
    limit: int
    heuristic_weight: float
    spins: bool
    turn: float
    back: float
    shortcuts: bool
    bends_within: float = np.inf
    any_cost_within: float = 0.0
    tolerance: float = -1.0
    near_limit: int = 0
    coarse: int = 1
    interval: int = 5000


def search(
    start: Floats, goals: Floats, terrain: Terrain, rules: Rules, moves: Moves
) -> tuple[PoseTable, int, Floats, int]:
    """Search from a pose, whose heading is the one where the moves start, to another.

    Args:
        start: `(3,)` [cells, cells, rad].
        goals: `(K, 3)` a pose, and the same with other headings that will do.

    Returns:
        The poses reached, the last row before the direct curve to the goal, the poses of that
        curve, and how many poses were expanded; the row is -1 where the goal was not reached.

    Raises:
        PlanStoppedError: It is to stop.
    """
    found: tuple[PoseTable, int, Floats, int]
    found = _search(start, goals, terrain, rules, moves, stop_flag())
    check_stopped()
    return found


@njit(cache=True, nogil=True)
def _search(
    start: Floats, goals: Floats, terrain: Terrain, rules: Rules, moves: Moves, stop: Bools
) -> tuple[PoseTable, int, Floats, int]:
    """Search as `search` says.

    Source: what is left weighs a little more than it is, as in weighted A* (Pohl 1970), the more
        the longer it takes (`bench planner --scenarios`, random512-35: as good, much sooner): the
        path costs at most so much more than the best, though no pose is expanded twice (Likhachev,
        Gordon and Thrun, ARA*, NIPS 2003). With turns on the spot the cheapest direct rest counts.
    """
    nodes, (height, width) = new_table(start), terrain.data.shape
    index = indexed(height, width, len(moves.angles))
    most = np.max(moves.first[1:] - moves.first[:-1])
    queue = [(0.0, np.int64(0), -1.0)]  # the last is what a row cost, until its bends are looked at
    count, looked, until_direct = np.int64(1), 0, 0.0  # a plain 1 has what takes it compiled twice
    best, last, rest, weight = np.inf, np.int64(-1), np.empty((0, 3)), rules.heuristic_weight
    goal, nearest, nearest_row, near = goals[0], np.inf, np.int64(0), 0
    until = min(rules.interval, rules.limit)
    while len(queue) > 0:
        if looked >= until:
            if until == rules.limit or stop[0]:
                break
            until = min(until + rules.interval, rules.limit)
        key, row, cost = heapq.heappop(queue)
        if best <= weight * key:
            break
        if nodes.done[row]:
            continue
        if cost >= 0.0:  # half of all rows are never asked for their bends
            with_bends = cost + _cost_to_go(nodes.poses[row], goal, terrain, rules)
            if with_bends > key:
                heapq.heappush(queue, (with_bends, row, -1.0))
                continue
        nodes.done[row], looked, pose = True, looked + 1, nodes.poses[row]
        distance = math.hypot(pose[0] - goal[0], pose[1] - goal[1])
        if rules.tolerance >= 0.0:
            if distance < nearest:
                nearest, nearest_row = distance, row
            near += nearest <= rules.tolerance
            if near > rules.near_limit:
                break
        until_direct -= 1.0
        if until_direct <= 0.0 and distance <= rules.direct_length:
            curve, cost = _direct(pose, goals, terrain, rules)
            if len(curve) > 0 and nodes.values[row] + cost < best:
                best, last, rest = nodes.values[row] + cost, row, curve
                if not rules.spins:
                    break
            until_direct = max(distance / rules.direct_ratio, 1.0)
        nodes = with_room(nodes, count, most)
        # After 200 000 expanded poses the cost to go weighs twice as much.
        weight = rules.heuristic_weight * (1.0 + looked / 200_000)
        count, index = _expand(row, count, nodes, index, queue, terrain, rules, moves, weight)
    if last < 0 and nearest <= rules.tolerance:
        last, rest = nearest_row, nodes.poses[nearest_row : nearest_row + 1].copy()
    return nodes, last, rest, looked


@njit(cache=True)
def _expand(
    row: int,
    count: int,
    nodes: PoseTable,
    index: RowIndex,
    queue: Any,
    terrain: Terrain,
    rules: Rules,
    moves: Moves,
    weight: float,
) -> tuple[int, RowIndex]:
    """Add the poses that one piece leads to from a row; return how many rows there are."""
    pose, last = nodes.poses[row], nodes.kinds[row]
    heading = moves.ends[last] if last >= 0 else moves.start
    side = moves.sides[last] if last >= 0 else 0
    height, width = terrain.data.shape
    for move in range(moves.first[heading], moves.first[heading + 1]):
        cost, end = moves.costs[move], moves.begins[move + 1] - 1
        if side != 0 and moves.sides[move] == -side:
            cost += moves.changes[move]
        r, c = math.floor(pose[1] + moves.poses[end, 1]), math.floor(pose[0] + moves.poses[end, 0])
        if not (0 <= r < height and 0 <= c < width) or terrain.remaining[r, c] == np.inf:
            continue
        other = row_at(index, r, c, moves.ends[move])  # most are known: before they are driven to
        least = nodes.values[row] + cost * rules.straight
        if other >= 0 and (nodes.done[other] or nodes.values[other] <= least):
            continue
        value = nodes.values[row] + cost * _drive(pose, move, terrain, rules, moves)
        if value == np.inf or (other >= 0 and nodes.values[other] <= value):
            continue
        reached = nodes.poses[count]
        for k in range(3):
            reached[k] = pose[k] + moves.poses[end, k]
        if other >= 0:
            nodes.done[other] = True
        index = with_block(index, r, c)
        index.slots[slot_of(index, r, c, moves.ends[move])] = count
        nodes.values[count], nodes.before[count], nodes.kinds[count] = value, row, move
        remaining = float(terrain.remaining[math.floor(reached[1]), math.floor(reached[0])])
        heapq.heappush(queue, (value / weight + remaining, np.int64(count), value / weight))
        count += 1
    return count, index


@njit(cache=True)
def _cost_to_go(pose: Floats, goal: Floats, terrain: Terrain, rules: Rules) -> float:
    """Return a lower bound of the rest: by the costs round obstacles, or by the bends alone.

    Source: Savla, Frazzoli and Bullo, Traveling salesperson problems for the Dubins vehicle, IEEE
        TAC 2008, on how much longer than the straight line a curve can be.
    """
    by_costs = float(terrain.remaining[math.floor(pose[1]), math.floor(pose[0])])
    if rules.spins:
        return by_costs
    dx, dy = (goal[0] - pose[0]) / rules.radius, (goal[1] - pose[1]) / rules.radius
    unit = rules.radius * rules.straight
    longer, enough = _LONGER_REVERSE if rules.reverse else _LONGER, by_costs / unit
    if enough >= math.hypot(dx, dy) + longer or max(abs(dx), abs(dy)) > rules.bends_within:
        return by_costs
    c, s = math.cos(pose[2]), math.sin(pose[2])
    turn = goal[2] - pose[2]
    length = length_to(c * dx + s * dy, c * dy - s * dx, turn, rules.reverse, enough)
    return max(by_costs, length * unit)


@njit(cache=True)
def _drive(pose: Floats, move: int, terrain: Terrain, rules: Rules, moves: Moves) -> float:
    """Return the factor on a piece's cost by the costs along it, inf where it collides."""
    data, total = terrain.data, 0.0
    first, end = moves.begins[move], moves.begins[move + 1]
    plain = INSCRIBED if terrain.circular else min(terrain.safe_cost, INSCRIBED)
    for k in range(first, end):
        x, y = pose[0] + moves.poses[k, 0], pose[1] + moves.poses[k, 1]
        row, column = math.floor(y), math.floor(x)
        inside = 0 <= row < data.shape[0] and 0 <= column < data.shape[1]
        if inside and data[row, column] < plain:  # most
            total += data[row, column]
            continue
        cost = cost_at(x, y, pose[2] + moves.poses[k, 2], terrain)
        if cost == np.inf:
            return np.inf
        total += cost
    share: float = total / (end - first) / (INSCRIBED - 1)
    return rules.straight + rules.cost_penalty * share


@njit(cache=True)
def cost_at(x: float, y: float, theta: float, terrain: Terrain) -> float:
    """Return the cost under the robot at a pose [cells, rad], inf where it may not be."""
    data = terrain.data
    row, column = math.floor(y), math.floor(x)
    if not (0 <= row < data.shape[0] and 0 <= column < data.shape[1]):
        return np.inf
    cost = float(data[row, column])
    if cost == UNKNOWN:
        if not terrain.allow_unknown:
            return np.inf
        cost = float(INSCRIBED - 1)
    if cost >= INSCRIBED:
        return np.inf
    if terrain.circular or data[row, column] < terrain.safe_cost:
        return cost
    pose = np.array([x, y, theta])
    if collides_in_cells(data, pose, terrain.points, False, terrain.safe_cost):
        return np.inf
    return cost


@njit(cache=True)
def can_turn(pose: Floats, turn: float, terrain: Terrain) -> bool:
    """Return whether the robot can turn on the spot by an angle [rad] from a pose."""
    steps = math.ceil(abs(turn) / math.pi * _SPIN)
    for k in range(1, steps + 1):
        if cost_at(pose[0], pose[1], pose[2] + turn * k / steps, terrain) == np.inf:
            return False
    return True


@njit(cache=True)
def _direct(pose: Floats, goals: Floats, terrain: Terrain, rules: Rules) -> tuple[Floats, float]:
    """Return the cheapest free curve to the goal with any of its headings, and its cost."""
    best, least = _direct_to(pose, goals[0], terrain, rules)
    for k in range(1, len(goals)):
        if k == rules.coarse and len(best) == 0:
            break
        curve, cost = _direct_to(pose, goals[k], terrain, rules)
        if len(curve) > 0 and (len(best) == 0 or cost < least):
            best, least = curve, cost
    return best, least


@njit(cache=True)
def _direct_to(pose: Floats, goal: Floats, terrain: Terrain, rules: Rules) -> tuple[Floats, float]:
    """Return the poses of the shortest curve to a goal and its cost, none if it is not free."""
    dx, dy = goal[0] - pose[0], goal[1] - pose[1]
    near = math.hypot(dx, dy) < rules.any_cost_within
    most = float(INSCRIBED - 1) if near else rules.direct_cost
    if rules.spins:
        best, least = np.empty((0, 3)), np.inf
        for back in (False, True):
            poses, turned = _straight(pose, goal, back)
            cost = rules.turn * turned + math.hypot(dx, dy) * (rules.back if back else 1.0)
            if cost < least and len(_free(poses, terrain, most)) > 0:
                best, least = poses, cost
        return best, least
    dx, dy = dx / rules.radius, dy / rules.radius
    c, s = math.cos(pose[2]), math.sin(pose[2])
    curve = shortest(c * dx + s * dy, c * dy - s * dx, goal[2] - pose[2], rules.reverse)
    length = np.abs(curve[1]).sum() * rules.radius
    if length > rules.direct_length:
        return np.empty((0, 3)), np.inf
    return _free(along(pose, curve, rules.radius, STEP), terrain, most), length


@njit(cache=True)
def _free(poses: Floats, terrain: Terrain, most: float) -> Floats:
    """Return poses if all may be driven, else none; above the most only at their end.

    Source: nav2_smac_planner's analytic expansion: a goal may lie where all costs more, which a
        curve then enters once.
    """
    entered = False
    for k in range(len(poses) - 1, -1, -1):
        cost = cost_at(poses[k, 0], poses[k, 1], poses[k, 2], terrain)
        if cost == np.inf or (entered and cost > most):
            return poses[:0]
        entered = entered or cost <= most
    return poses


@njit(cache=True)
def _straight(pose: Floats, goal: Floats, back: bool) -> tuple[Floats, float]:
    """Return a turn towards the goal, or away, the straight line, a turn; and the angle turned."""
    dx, dy = goal[0] - pose[0], goal[1] - pose[1]
    bearing = math.atan2(dy, dx) + (math.pi if back else 0.0)
    if math.hypot(dx, dy) <= STEP:
        bearing = pose[2]
    parts = ((0.0, 0.0, bearing), (dx, dy, bearing), (0.0, 0.0, goal[2]))
    result = np.empty((math.ceil(math.hypot(dx, dy) / STEP) + 2 * _SPIN + 1, 3))
    at, count, turned = pose.copy(), 0, 0.0
    for x, y, heading in parts:
        turn = (heading - at[2] + math.pi) % (2.0 * math.pi) - math.pi
        turn = turn if abs(turn) > 1e-6 else 0.0  # rounding is no turn to stop for
        steps = max(math.ceil(math.hypot(x, y) / STEP), math.ceil(abs(turn) / math.pi * _SPIN))
        for k in range(steps):
            ratio = (k + 1) / steps
            result[count] = at + ratio * np.array([x, y, turn])
            count += 1
        at += np.array([x, y, turn])
        turned += abs(turn)
    return result[:count], turned
