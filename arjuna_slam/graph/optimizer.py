"""Pose-graph optimisation: Levenberg-Marquardt on the graph's normal equations, robust where asked.

The first node is held. Source: Madsen et al., Methods for non-linear least squares problems, 2004,
section 3.2 (damping).
"""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass

import numpy as np
from numba import njit

from arjuna_core.arrays import Floats, Ints
from arjuna_core.se2 import wrap
from arjuna_slam.graph.pose_graph import EdgeTable
from arjuna_slam.graph.sparse_cholesky import factorize, pattern, solve

_DIAGONAL_MIN = 1e-9  # keeps a node that no edge holds from a division by zero


@njit(cache=True)
def residual(a: Floats, b: Floats, measured: Floats) -> Floats:
    """Return the residual of the edge `a -> b`, `(3,) float64` [m, m, rad]."""
    c, s = math.cos(a[2]), math.sin(a[2])
    dx, dy = b[0] - a[0], b[1] - a[1]
    turn = b[2] - a[2] - measured[2]
    result = np.empty(3)
    result[0] = c * dx + s * dy - measured[0]
    result[1] = -s * dx + c * dy - measured[1]
    result[2] = (turn + math.pi) % (2.0 * math.pi) - math.pi
    return result


@njit(cache=True)
def fill_jacobians(a: Floats, b: Floats, by_a: Floats, by_b: Floats) -> None:
    """Set the residual's derivatives by pose a and by pose b, `(3, 3) float64`, zero before."""
    c, s = math.cos(a[2]), math.sin(a[2])
    dx, dy = b[0] - a[0], b[1] - a[1]
    by_b[0, 0], by_b[0, 1] = c, s
    by_b[1, 0], by_b[1, 1] = -s, c
    by_b[2, 2] = 1.0
    by_a[0, 0], by_a[0, 1], by_a[0, 2] = -c, -s, -s * dx + c * dy
    by_a[1, 0], by_a[1, 1], by_a[1, 2] = s, -c, -c * dx - s * dy
    by_a[2, 2] = -1.0


@njit(cache=True)
def chi2(poses: Floats, i: Ints, j: Ints, measured: Floats, information: Floats) -> Floats:
    """Return each edge's squared error in deviations, `(E,) float64`."""
    result = np.zeros(len(i))
    for e in range(len(i)):
        error = residual(poses[i[e]], poses[j[e]], measured[e])
        for r in range(3):
            for c in range(3):
                result[e] += error[r] * information[e, r, c] * error[c]
    return result


@njit(cache=True)
def robust_cost(square: Floats, scale: Floats) -> float:
    """Return the sum of Cauchy's cost, or of the squares where the scale is infinite."""
    total = 0.0
    for e in range(len(square)):
        if np.isfinite(scale[e]):
            total += scale[e] ** 2 * math.log1p(square[e] / scale[e] ** 2)
        else:
            total += square[e]
    return total


@njit(cache=True)
def assemble(
    poses: Floats,
    i: Ints,
    j: Ints,
    measured: Floats,
    information: Floats,
    weight: Floats,
    perm: Ints,
    starts: Ints,
    slots: Ints,
    blocks: Floats,
    corner: Floats,
    g: Floats,
) -> None:
    """Fill the Hessian's lower triangle and the gradient; node 0 is held.

    Edges are the columns of `EdgeTable`, each with a robust weight; `perm`, `starts` and `slots`
    are those of `Pattern`. `blocks`, `corner` and `g`, `(N, 3)` in elimination order, are filled.
    """
    blocks[:] = 0.0
    corner[:] = 0.0
    g[:] = 0.0
    first = len(starts) - 1
    by_i, by_j = np.zeros((3, 3)), np.zeros((3, 3))
    left_i, left_j = np.empty((3, 3)), np.empty((3, 3))
    for e in range(len(i)):
        a, b = perm[i[e]], perm[j[e]]
        error = residual(poses[i[e]], poses[j[e]], measured[e])
        fill_jacobians(poses[i[e]], poses[j[e]], by_i, by_j)
        _weigh(by_i, information[e], weight[e], left_i)
        _weigh(by_j, information[e], weight[e], left_j)
        if i[e] != 0:
            _add_product(_block(a, a, first, starts[min(a, first)], blocks, corner), left_i, by_i)
            _add_gradient(g[a], left_i, error)
        if j[e] != 0:
            _add_product(_block(b, b, first, starts[min(b, first)], blocks, corner), left_j, by_j)
            _add_gradient(g[b], left_j, error)
        if slots[e] != -2 and a > b:
            _add_product(_block(a, b, first, slots[e], blocks, corner), left_i, by_j)
        elif slots[e] != -2:
            _add_product(_block(b, a, first, slots[e], blocks, corner), left_j, by_i)
    held = _block(perm[0], perm[0], first, starts[min(perm[0], first)], blocks, corner)
    for k in range(3):
        held[k, k] = 1.0


@njit(cache=True)
def _block(row: int, column: int, first: int, slot: int, blocks: Floats, corner: Floats) -> Floats:
    if column < first:
        inside: Floats = blocks[slot]
        return inside
    r, c = 3 * (row - first), 3 * (column - first)
    block: Floats = corner[r : r + 3, c : c + 3]
    return block


@njit(cache=True)
def _weigh(jacobian: Floats, information: Floats, weight: float, out: Floats) -> None:
    for r in range(3):
        for c in range(3):
            out[r, c] = weight * (
                jacobian[0, r] * information[0, c]
                + jacobian[1, r] * information[1, c]
                + jacobian[2, r] * information[2, c]
            )


@njit(cache=True)
def _add_product(target: Floats, left: Floats, right: Floats) -> None:
    for r in range(3):
        for c in range(3):
            target[r, c] += (
                left[r, 0] * right[0, c] + left[r, 1] * right[1, c] + left[r, 2] * right[2, c]
            )


@njit(cache=True)
def _add_gradient(target: Floats, left: Floats, error: Floats) -> None:
    for r in range(3):
        target[r] += left[r, 0] * error[0] + left[r, 1] * error[1] + left[r, 2] * error[2]


@njit(cache=True)
def damp(starts: Ints, blocks: Floats, corner: Floats, damping: float) -> None:
    """Enlarge the diagonal by a share of itself, as Marquardt does."""
    for k in range(len(starts) - 1):
        for r in range(3):
            blocks[starts[k], r, r] += damping * blocks[starts[k], r, r] + _DIAGONAL_MIN
    for r in range(len(corner)):
        corner[r, r] += damping * corner[r, r] + _DIAGONAL_MIN


_DAMPING_MIN, _DAMPING_MAX = 1e-10, 1e8  # no damping, no step: beyond either nothing changes
DAMPING = 1e-8  # with which an optimisation begins: a first step near to Gauss and Newton's


class OptimizerStatus(enum.Enum):
    """Outcome of an optimisation."""

    CONVERGED = "converged"
    MAX_ITERATIONS = "iterations used up"
    NO_DESCENT = "no step descends"


@dataclass(frozen=True)
class OptimizerResult:
    """The optimised poses."""

    status: OptimizerStatus  # how it ended
    poses: Floats  # `(N, 3) float64` of x, y, theta [m, m, rad]
    # cost before the first and after each accepted step: the edges' robust chi2
    trace: tuple[float, ...]
    weights: Floats  # robust weight (0..1) of each edge at the end, `(E,) float64`
    damping: float = DAMPING  # with which the next step would be tried


class _Problem:
    """One graph's costs and steps; what depends on its edges alone is worked out once."""

    def __init__(self, count: int, edges: EdgeTable, robust_scale: float | None) -> None:
        self._edges = edges
        robust = edges.loop & (robust_scale is not None)
        self._scale = np.where(robust, robust_scale or np.inf, np.inf)
        self._pattern = pattern(count, edges.i, edges.j)
        self._blocks = np.empty((len(self._pattern.rows), 3, 3))
        self._corner = np.empty((3 * self._pattern.corner, 3 * self._pattern.corner))
        self._g = np.empty((count, 3))

    def evaluate(self, poses: Floats) -> tuple[float, Floats]:
        """Return the cost and each edge's robust weight."""
        edges = self._edges
        square = chi2(poses, edges.i, edges.j, edges.measured, edges.information)
        return robust_cost(square, self._scale), 1.0 / (1.0 + square / self._scale**2)

    def step(self, poses: Floats, weight: Floats, damping: float) -> Floats:
        """Return the poses after one damped step."""
        layout, edges = self._pattern, self._edges
        blocks, corner, g = self._blocks, self._corner, self._g
        assemble(
            poses, edges.i, edges.j, edges.measured, edges.information, weight,
            layout.perm, layout.starts, np.asarray(layout.slots), blocks, corner, g,
        )  # fmt: skip
        damp(layout.starts, blocks, corner, damping)
        factorize(layout.starts, layout.rows, blocks, corner)
        solve(layout.starts, layout.rows, blocks, corner, g)
        trial: Floats = poses - g[layout.perm]
        trial[0] = poses[0]
        angles: Floats = trial[:, 2]
        trial[:, 2] = wrap(angles)
        return trial


def optimize(
    poses: Floats,
    edges: EdgeTable,
    *,
    robust_scale: float | None = None,
    iterations: int = 30,
    tolerance: float = 1e-6,
    damping: float = DAMPING,
) -> OptimizerResult:
    """Return the poses of least cost, from a start `(N, 3)` [m, m, rad] of which the first is held.

    Args:
        edges: The measurements; they must connect all nodes.
        robust_scale: Scale of the Cauchy kernel on loop edges, in deviations; None for none.
        tolerance: Relative decrease of the cost below which it has converged.
        damping: That of the result to go on from, where its iterations were used up.
    """
    poses = poses.copy()
    if not len(edges) or len(poses) < 2:
        return OptimizerResult(OptimizerStatus.CONVERGED, poses, (0.0,), np.ones(len(edges)))
    problem = _Problem(len(poses), edges, robust_scale)
    cost, weight = problem.evaluate(poses)
    trace, status = [cost], OptimizerStatus.MAX_ITERATIONS
    for _ in range(iterations):
        trial = problem.step(poses, weight, damping)
        trial_cost, trial_weight = problem.evaluate(trial)
        if not trial_cost <= cost:
            if cost - trial_cost > -tolerance * (cost + 1e-9):
                status = OptimizerStatus.CONVERGED
                break
            damping = max(damping * 100.0, 1e-6)
            if damping > _DAMPING_MAX:
                status = OptimizerStatus.NO_DESCENT
                break
            continue
        done = cost - trial_cost <= tolerance * (cost + 1e-9)
        poses, cost, weight = trial, trial_cost, trial_weight
        trace.append(cost)
        damping = max(damping * 0.1, _DAMPING_MIN)
        if done:
            status = OptimizerStatus.CONVERGED
            break
    return OptimizerResult(status, poses, tuple(trace), weight, damping)
