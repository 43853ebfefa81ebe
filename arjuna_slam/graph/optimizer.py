"""Pose-graph optimisation: Levenberg-Marquardt on the graph's normal equations, robust where asked.

The first node is held. Source: Madsen et al., Methods for non-linear least squares problems, 2004,
section 3.2 (damping).
"""

from __future__ import annotations

import enum
from dataclasses import dataclass

import numpy as np

from arjuna_core.arrays import Floats
from arjuna_core.se2 import wrap
from arjuna_slam.graph.linearization import assemble, chi2, damp, robust_cost
from arjuna_slam.graph.pose_graph import EdgeTable
from arjuna_slam.graph.sparse_cholesky import factorize, pattern, solve

_DAMPING_MIN, _DAMPING_MAX = 1e-10, 1e8  # no damping, no step: beyond either nothing changes


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
) -> OptimizerResult:
    """Return the poses of least cost, from a start `(N, 3)` [m, m, rad] of which the first is held.

    Args:
        edges: The measurements; they must connect all nodes.
        robust_scale: Scale of the Cauchy kernel on loop edges, in deviations; None for none.
        tolerance: Relative decrease of the cost below which it has converged.
    """
    poses = poses.copy()
    if not len(edges) or len(poses) < 2:
        return OptimizerResult(OptimizerStatus.CONVERGED, poses, (0.0,), np.ones(len(edges)))
    problem = _Problem(len(poses), edges, robust_scale)
    cost, weight = problem.evaluate(poses)
    trace, damping, status = [cost], 1e-8, OptimizerStatus.MAX_ITERATIONS
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
    return OptimizerResult(status, poses, tuple(trace), weight)
