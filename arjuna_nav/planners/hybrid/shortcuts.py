"""The path of a search over poses, and shortcuts between its poses."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from arjuna_core.arrays import Floats, Ints
from arjuna_nav.costmap.costmap import INSCRIBED
from arjuna_nav.planners.hybrid.curves import along, shortest
from arjuna_nav.planners.hybrid.moves import STEP, Moves
from arjuna_nav.planners.hybrid.search import Rules, Terrain, cost_at
from arjuna_nav.planners.pose_table import PoseTable, rows_to


@njit(cache=True, nogil=True)
def driven(
    nodes: PoseTable, row: int, direct: Floats, terrain: Terrain, rules: Rules, moves: Moves
) -> tuple[Floats, float]:
    """Return the poses from the start to the goal, `(N, 3)`, and what they cost.

    Pieces bend by fixed angles, so that a path between their directions is a zigzag. With
    `rules.shortcuts` Dubins' curves replace pieces where they are free and cost less.

    Args:
        row: Of the last one.
        direct: Poses of the curve from there to the goal.

    Source: dynamic programming over the path's own poses; Dolgov et al., IJRR 2010, section 4.
    """
    rows = rows_to(nodes, row)
    last = len(rows)
    poses, values = np.vstack((nodes.poses[rows], direct[-1:])), np.zeros(last + 1)
    before, bends = np.arange(-1, last), np.zeros(last + 1, np.int64)
    spans = (6, 16, 48)  # pieces that a curve replaces; long ones are tried an eighth of it apart
    for k in range(1, last + 1):
        if k < last:
            values[k] = values[k - 1] + nodes.values[rows[k]] - nodes.values[rows[k - 1]]
            bends[k] = bends[k - 1] + abs(moves.sides[nodes.kinds[rows[k]]])
        else:
            cost = _cost_along(direct, STEP * len(direct), terrain, rules, np.inf)
            values[k] = values[k - 1] + cost
            bends[k] = bends[k - 1] + 1
        for span in spans if rules.shortcuts else (0, 0, 0):
            i, due = k - span, k == last or k % max(span // 8, 1) == 0
            if i < 0 or not due or bends[k] == bends[i]:
                continue
            most = values[k] - values[i]
            cost = _cost_of(poses[i], _dubins(poses[i], poses[k], rules), terrain, rules, most)
            if cost < most:
                values[k], before[k] = values[i] + cost, i
    return _joined(nodes, rows, poses, before, direct, rules, moves), values[-1]


@njit(cache=True)
def _dubins(pose: Floats, end: Floats, rules: Rules) -> Floats:
    """Return Dubins' curve between two poses, of `shortest`."""
    dx, dy = (end[0] - pose[0]) / rules.radius, (end[1] - pose[1]) / rules.radius
    c, s = math.cos(pose[2]), math.sin(pose[2])
    return shortest(c * dx + s * dy, c * dy - s * dx, end[2] - pose[2], False)


@njit(cache=True)
def _cost_of(pose: Floats, curve: Floats, terrain: Terrain, rules: Rules, most: float) -> float:
    """Return what a curve costs, as the search's pieces do; inf if `most` or more, or not free."""
    length = 0.0
    for k in range(curve.shape[1]):
        length += curve[1, k] * rules.radius * (1.0 if curve[0, k] == 0.0 else rules.bends)
    if length * rules.straight >= most:
        return np.inf
    return _cost_along(along(pose, curve, rules.radius, STEP), length, terrain, rules, most)


@njit(cache=True)
def _cost_along(poses: Floats, length: float, terrain: Terrain, rules: Rules, most: float) -> float:
    """Return what a length along poses costs; inf if `most` or more, or not free."""
    cost = length * rules.straight
    weight = rules.cost_penalty * length / max(len(poses), 1) / (INSCRIBED - 1)
    for pose in poses:
        cost += weight * cost_at(pose[0], pose[1], pose[2], terrain)
        if not cost < most:
            return np.inf
    return cost


@njit(cache=True)
def _joined(
    nodes: PoseTable,
    rows: Ints,
    poses: Floats,
    before: Ints,
    direct: Floats,
    rules: Rules,
    moves: Moves,
) -> Floats:
    """Return the poses of pieces and curves from the first node to the last, `(N, 3)`."""
    k, pieces, total = len(rows), [poses[:1]], 1
    while k > 0:
        i = before[k]
        if i < k - 1:
            curve = _dubins(poses[i], poses[k], rules)
            pieces.append(along(poses[i], curve, rules.radius, STEP))
        elif k == len(rows):
            pieces.append(direct)
        else:
            move = nodes.kinds[rows[k]]
            pieces.append(moves.poses[moves.begins[move] : moves.begins[move + 1]] + poses[i])
        total += len(pieces[-1])
        k = i
    result, at = np.empty((total, 3)), 1
    result[0] = poses[0]
    for piece in pieces[:0:-1]:
        result[at : at + len(piece)] = piece
        at += len(piece)
    return result
