"""Plans that the robot's outline can follow, heading by heading."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numba import njit

from arjuna_core.arrays import Bytes, Floats
from arjuna_core.se2 import SE2
from arjuna_nav.costmap.collision import collides_in_cells
from arjuna_nav.costmap.costmap import INSCRIBED, LETHAL, MAX_NON_OBSTACLE, Costmap
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.costmap.window import clipped
from arjuna_nav.planners.base import Planner, PlanResult, PlanStatus
from arjuna_nav.planners.escape import lead_out
from arjuna_nav.planners.hybrid.moves import STEP, Moves, arcs
from arjuna_nav.planners.hybrid.search import Rules, Terrain, search
from arjuna_nav.planners.hybrid.shortcuts import driven
from arjuna_nav.planners.waves.potential import COST_FACTOR, NEUTRAL, traversal_costs, wavefront


class Drive(NamedTuple):
    """Motions of a differential or a steered drive, and their costs in metres driven ahead.

    Attributes:
        turn: Of a turn by one radian on the spot [m/rad].
        reversal: Of a change between ahead and back [m].
        back: Factor on what is driven back.
        bend: Factor on what is driven in a bend.
        headings: Number of headings.
        stride: Length of a motion; more than a cell's diagonal leads to another cell [cells].
        direct: Greatest distance over which the end is tried to be reached by a turn, a straight
            and a turn [m].
        limit: Greatest number of poses expanded.
        radius: Of the tightest bend; 0 for a drive that turns on the spot [m].
    """

    turn: float = 1.0
    reversal: float = 0.25
    back: float = 4.0
    bend: float = 1.02
    headings: int = 32
    stride: float = 1.5
    direct: float = 0.15
    limit: int = 2400
    radius: float = 0.0


def plan_for_outline(
    planner: Planner,
    costmap: Costmap,
    start: SE2,
    goal: SE2,
    footprint: Footprint,
    *,
    closed_radius: int = 3,
    attempts: int = 6,
) -> PlanResult:
    """Return a plan that the outline can follow where there is one, else the planner's own.

    A planner on the grid alone takes the robot for a circle of its inscribed radius: it leads one
    that is longer than wide through gaps before which it cannot turn. Then a path is searched
    heading by heading, nearby; and where there is none, the planner is asked for paths elsewhere.

    Args:
        closed_radius: Of what is closed to the planner where the outline collides [cells].
        attempts: Greatest number of plans in which one more collision is closed.
    """
    plan = planner.plan(costmap, start, goal)
    if plan.status is PlanStatus.NO_VALID_PATH:
        return _through_gaps(planner, costmap, start, goal, footprint) or plan
    checked = footprint.circular or getattr(planner, "checks_outline", False)
    if checked or plan.status is not PlanStatus.SUCCEEDED:
        return plan
    blocked = first_blocked(plan.path, costmap, footprint)
    if blocked is None:
        return plan
    if len(path := find_path(start, _end_of(plan.path), costmap, footprint, Drive())) > 1:
        return replace(plan, path=np.vstack((path[:-1], plan.path[-1:])))
    closed = replace(costmap, data=costmap.data.copy())
    for _ in range(attempts):
        _close(closed, blocked, closed_radius)
        other = planner.plan(closed, start, goal)
        if other.status is not PlanStatus.SUCCEEDED:
            return plan
        blocked = first_blocked(other.path, costmap, footprint)
        if blocked is None:
            return other
    return plan


def _end_of(path: Floats) -> SE2:
    """Return the last pose of a path `(N, 3)`, heading along its last step."""
    (x, y), (dx, dy) = path[-1, :2], path[-1, :2] - path[-2, :2]
    return SE2(float(x), float(y), math.atan2(dy, dx))


def _through_gaps(
    planner: Planner, costmap: Costmap, start: SE2, goal: SE2, footprint: Footprint
) -> PlanResult | None:
    """Return a plan through gaps that only the coarseness of cells may close, None where none is.

    Walls lie somewhere in their cells, and the robot's centre need not lie in a cell's middle: a
    gap may be wider than cells say by half a cell where one side is mapped, by one for both.
    """
    for coarseness in (0.5, 1.1):
        radius = footprint.inscribed_radius / costmap.frame.resolution - coarseness
        data = relaxed_inscribed(costmap.data, radius)
        plan = planner.plan(replace(costmap, data=data), start, goal)
        if plan.status is PlanStatus.SUCCEEDED:
            return plan
    return None


@njit(cache=True, nogil=True)
def relaxed_inscribed(data: Bytes, radius: float) -> Bytes:
    """Return costs in which inscribed cells are open, at the highest cost, beyond a radius.

    Args:
        data: `(height, width) uint8` of a costmap.
        radius: Between a cell's centre and those of lethal cells [cells].
    """
    height, width = data.shape
    reach = math.floor(radius)
    result: Bytes = data.copy()
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


def _close(costmap: Costmap, pose: Floats, radius: int) -> None:
    row, column = costmap.frame.to_cell(float(pose[0]), float(pose[1]))
    ends = row - radius, row + radius + 1, column - radius, column + radius + 1
    window = clipped(*ends, costmap.data.shape)
    rows, columns = np.ogrid[window]
    near = (rows - row) ** 2 + (columns - column) ** 2 <= radius**2
    costs = costmap.data[window]
    costs[near & (costs < INSCRIBED)] = INSCRIBED


def find_path(start: SE2, end: SE2, costmap: Costmap, footprint: Footprint, drive: Drive) -> Floats:
    """Return the poses from one to another, `(N, 3)` [m, m, rad]; none where no path leads there.

    It is driven ahead, straight or in bends, straight back, and by turns on the spot; by a steered
    drive ahead and back, straight or in bends. A start that collides is left ahead or back first.

    Args:
        start: The robot's pose in the costmap's frame.
        end: Where to come, with its heading.
    """
    frame, costs = costmap.frame, traversal_costs()
    cells = [frame.to_cell(one.x, one.y) for one in (start, end)]
    if not all(frame.contains(*cell) for cell in cells):
        return np.empty((0, 3))
    lead = lead_out(start, costmap, footprint, drive.radius)
    first, last = _in_cells(np.array([lead[-1], end.array()]), costmap)
    distances = wavefront(costmap.data, costs, np.array([[*cells[1], 0.0]]))
    terrain = Terrain(
        costmap.data,
        distances / np.float32(NEUTRAL),
        footprint.points / frame.resolution,
        footprint.circular,
        costmap.safe_cost(footprint.circumscribed_radius),
        True,
    )
    rules = _rules(drive, frame.resolution)
    if drive.radius > 0.0:
        factors = drive.back, drive.bend, 0.0
        moves = arcs(first[2], drive.headings, rules.radius, True, factors, False)
    else:
        moves = _moves(first[2], drive, frame.resolution)
    nodes, row, curve, _ = search(first, last[None], terrain, rules, moves)
    if row < 0:
        return np.empty((0, 3))
    poses: Floats = driven(nodes, row, curve, terrain, rules, moves)[0]
    poses[:, :2] = frame.origin.apply(poses[:, :2] * frame.resolution)
    poses[:, 2] += frame.origin.theta
    found = np.vstack((lead[:-1], poses))
    if drive.radius > 0.0:  # a step that leads nowhere would be a turn on the spot
        found = found[np.append(True, np.hypot(*np.diff(found[:, :2], axis=0).T) > 1e-5)]
    return found


def _rules(drive: Drive, resolution: float) -> Rules:
    """Return the rules of a search whose lengths are in cells."""
    steered = drive.radius > 0.0
    return Rules(
        radius=max(drive.radius / resolution, 1.0),
        reverse=True,
        cost_penalty=(INSCRIBED - 1) * COST_FACTOR / NEUTRAL,
        straight=1.0,
        bends=drive.bend,
        direct_ratio=drive.direct / resolution,
        direct_length=drive.direct / resolution,
        direct_cost=float(INSCRIBED - 1),
        limit=drive.limit,
        heuristic_weight=1.0,
        spins=not steered,
        turn=drive.turn / resolution,
        back=drive.back,
        shortcuts=steered,
    )


def _moves(first: float, drive: Drive, resolution: float) -> Moves:
    """Return the motions from each heading, the first heading as given [rad], lengths in cells."""
    one = 2.0 * math.pi / drive.headings
    kinds = ((1, 0), (1, 1), (1, -1), (-1, 0), (0, 1), (0, -1))  # direction, and turn in headings
    steps = math.ceil(drive.stride / STEP)
    ahead = np.arange(1, steps + 1)[:, None] / steps
    angles = np.asarray(first + one * np.arange(drive.headings), np.float64)
    costs = [_price(*kind, drive, one, resolution) for kind in kinds]
    poses, ends = [], []
    for heading, angle in enumerate(angles):
        for direction, turn in kinds:
            middle, turned = angle + 0.5 * one * turn * ahead, one * turn * ahead
            length = direction * drive.stride * ahead
            poses.append(np.hstack((length * np.cos(middle), length * np.sin(middle), turned)))
            ends.append((heading + turn) % drive.headings)
    count = len(ends)
    return Moves(
        angles,
        0,
        np.arange(drive.headings + 1) * len(kinds),
        np.array(ends),
        np.tile([direction for direction, _ in kinds], drive.headings),
        np.tile(costs, drive.headings),
        np.full(count, drive.reversal / resolution),
        steps * np.arange(count + 1),
        np.vstack(poses),
    )


def _price(direction: int, turn: int, drive: Drive, angle: float, resolution: float) -> float:
    """Return the cost of a motion [cells]."""
    if direction == 0:
        return drive.turn * angle / resolution
    return drive.stride * (drive.back if direction < 0 else drive.bend if turn else 1.0)


def path_cost(path: Floats, drive: Drive) -> float:
    """Return the cost [m] of the poses of a path `(N, 3)` in free space."""
    steps, middle = np.diff(path[:, :2], axis=0), 0.5 * (path[1:, 2] + path[:-1, 2])
    ahead = steps[:, 0] * np.cos(middle) + steps[:, 1] * np.sin(middle)
    turns = np.abs(np.diff(path[:, 2]))[np.abs(ahead) < 1e-6].sum()
    stops = np.count_nonzero(np.diff(np.sign(np.round(ahead, 6))))
    driven_ahead = np.where(ahead < 0.0, -drive.back * ahead, ahead).sum()
    return float(driven_ahead + drive.turn * turns + drive.reversal * stops)


def first_blocked(
    path: Floats, costmap: Costmap, footprint: Footprint, chord: float = 0.3
) -> Floats | None:
    """Return the first pose of a path at which the outline, looking along it, meets an obstacle.

    Args:
        path: `(N, 3)`.
        chord: Over which the path's direction is taken; so far from its start it may turn [m].
    """
    index = _first_hit(
        _in_cells(path, costmap),
        chord / costmap.frame.resolution,
        costmap.data,
        footprint.points / costmap.frame.resolution,
        costmap.safe_cost(footprint.circumscribed_radius),
    )
    return path[index] if index < len(path) else None


def _in_cells(poses: Floats, costmap: Costmap) -> Floats:
    """Return poses of the costmap's frame in its grid [cells, rad]."""
    T_grid = costmap.frame.origin.inverse()
    points = T_grid.apply(poses[:, :2]) / costmap.frame.resolution
    return np.column_stack((points, poses[:, 2] + T_grid.theta))


@njit(cache=True)
def _first_hit(poses: Floats, chord: float, data: Bytes, points: Floats, safe_cost: int) -> int:
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
