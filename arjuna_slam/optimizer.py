"""Pose-graph optimisation: Levenberg-Marquardt with sparse normal equations, robust where asked.

Residual of an edge: `[R_i^T (t_j - t_i) - t_ij, theta_j - theta_i - theta_ij]`, weighted by its
information. The first node is held. Sources: Grisetti et al., A tutorial on graph-based SLAM, 2010;
Madsen et al., Methods for non-linear least squares problems, 2004, section 3.2 (damping).
"""

from __future__ import annotations

import enum
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix, csc_matrix, diags
from scipy.sparse.linalg import splu

from arjuna_core.se2 import wrap
from arjuna_slam.pose_graph import Edge, EdgeKind


class OptimizerStatus(enum.Enum):
    """How an optimisation ended."""

    CONVERGED = "converged"
    MAX_ITERATIONS = "iterations used up"
    NO_DESCENT = "no step descends"


@dataclass(frozen=True)
class OptimizerResult:
    """The optimised poses.

    Attributes:
        status: How it ended.
        poses: `(N, 3) float64` of x, y, theta [m, m, rad].
        trace: Cost before the first and after each accepted step: the edges' robust chi2.
    """

    status: OptimizerStatus
    poses: NDArray[np.float64]
    trace: tuple[float, ...]


@dataclass(frozen=True)
class _Problem:
    i: NDArray[np.int64]
    j: NDArray[np.int64]
    measured: NDArray[np.float64]
    information: NDArray[np.float64]
    scale: NDArray[np.float64]  # Cauchy's, in chi; inf for least squares


def optimize(
    poses: NDArray[np.float64],
    edges: list[Edge],
    *,
    robust_scale: float | None = None,
    iterations: int = 30,
    tolerance: float = 1e-6,
) -> OptimizerResult:
    """Return the poses of least cost, the first held.

    Args:
        poses: Start, `(N, 3) float64` of x, y, theta [m, m, rad].
        edges: The measurements; they must connect all nodes.
        robust_scale: Scale of the Cauchy kernel on loop edges, in deviations; None for none.
        iterations: Most accepted or refused steps.
        tolerance: Relative decrease of the cost below which it has converged.
    """
    poses = poses.copy()
    if not edges or len(poses) < 2:
        return OptimizerResult(OptimizerStatus.CONVERGED, poses, (0.0,))
    problem = _assemble(edges, robust_scale)
    cost, weight, error = _evaluate(problem, poses)
    trace, damping, status = [cost], 1e-8, OptimizerStatus.MAX_ITERATIONS
    h, g = _normal_equations(problem, poses, error, weight)
    for _ in range(iterations):
        trial = _step(poses, h, g, damping)
        trial_cost, trial_weight, trial_error = _evaluate(problem, trial)
        if not trial_cost <= cost:
            damping = max(damping * 100.0, 1e-6)
            if damping > 1e8:
                status = OptimizerStatus.NO_DESCENT
                break
            continue
        done = cost - trial_cost <= tolerance * (cost + 1e-9)
        poses, cost, weight, error = trial, trial_cost, trial_weight, trial_error
        trace.append(cost)
        damping = max(damping * 0.1, 1e-10)
        if done:
            status = OptimizerStatus.CONVERGED
            break
        h, g = _normal_equations(problem, poses, error, weight)
    return OptimizerResult(status, poses, tuple(trace))


def _assemble(edges: list[Edge], robust_scale: float | None) -> _Problem:
    loop = np.array([edge.kind is EdgeKind.LOOP for edge in edges])
    scale = np.where(loop & (robust_scale is not None), robust_scale or np.inf, np.inf)
    return _Problem(
        np.array([edge.i for edge in edges]),
        np.array([edge.j for edge in edges]),
        np.array([(e.T_i_j.x, e.T_i_j.y, e.T_i_j.theta) for e in edges]),
        np.array([edge.information for edge in edges]),
        scale.astype(np.float64),
    )


def errors(
    poses: NDArray[np.float64],
    i: NDArray[np.int64],
    j: NDArray[np.int64],
    measured: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Return the residuals of edges `i -> j`, `(E, 3) float64` [m, m, rad]."""
    c, s = np.cos(poses[i, 2]), np.sin(poses[i, 2])
    d = poses[j] - poses[i]
    result = np.empty_like(measured)
    result[:, 0] = c * d[:, 0] + s * d[:, 1] - measured[:, 0]
    result[:, 1] = -s * d[:, 0] + c * d[:, 1] - measured[:, 1]
    result[:, 2] = wrap(d[:, 2] - measured[:, 2])
    return result


def jacobians(
    poses: NDArray[np.float64], i: NDArray[np.int64], j: NDArray[np.int64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the residuals' derivatives by the poses of i and of j, `(E, 3, 3) float64` each."""
    c, s = np.cos(poses[i, 2]), np.sin(poses[i, 2])
    d = poses[j] - poses[i]
    by_j = np.zeros((len(i), 3, 3))
    by_j[:, 0, 0], by_j[:, 0, 1] = c, s
    by_j[:, 1, 0], by_j[:, 1, 1] = -s, c
    by_j[:, 2, 2] = 1.0
    by_i = -by_j
    by_i[:, 0, 2] = -s * d[:, 0] + c * d[:, 1]
    by_i[:, 1, 2] = -c * d[:, 0] - s * d[:, 1]
    return by_i, by_j


def _evaluate(
    problem: _Problem, poses: NDArray[np.float64]
) -> tuple[float, NDArray[np.float64], NDArray[np.float64]]:
    """Return the cost, each edge's robust weight and its residual."""
    error = errors(poses, problem.i, problem.j, problem.measured)
    chi2 = np.einsum("ea,eab,eb->e", error, problem.information, error)
    square = problem.scale**2
    robust = np.isfinite(square)
    cost = chi2.copy()
    cost[robust] = square[robust] * np.log1p(chi2[robust] / square[robust])
    return float(cost.sum()), 1.0 / (1.0 + chi2 / square), error


def _normal_equations(
    problem: _Problem,
    poses: NDArray[np.float64],
    error: NDArray[np.float64],
    weight: NDArray[np.float64],
) -> tuple[csc_matrix, NDArray[np.float64]]:
    """Return the Hessian and gradient without the first node."""
    by_i, by_j = jacobians(poses, problem.i, problem.j)
    omega = problem.information * weight[:, None, None]
    n = 3 * len(poses)
    g = np.zeros(n)
    offsets = np.arange(3)
    values, rows, columns = [], [], []
    for first, jac_a in ((problem.i, by_i), (problem.j, by_j)):
        weighted = np.einsum("eba,ebc->eac", jac_a, omega)
        row = 3 * first[:, None] + offsets
        np.add.at(g, row, np.einsum("eac,ec->ea", weighted, error))
        for second, jac_b in ((problem.i, by_i), (problem.j, by_j)):
            column = 3 * second[:, None] + offsets
            values.append((weighted @ jac_b).ravel())
            rows.append(np.broadcast_to(row[:, :, None], (len(row), 3, 3)).ravel())
            columns.append(np.broadcast_to(column[:, None, :], (len(row), 3, 3)).ravel())
    entries = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
    h = coo_matrix(entries, shape=(n, n)).tocsc()
    return h[3:, 3:], g[3:]


def _step(
    poses: NDArray[np.float64], h: csc_matrix, g: NDArray[np.float64], damping: float
) -> NDArray[np.float64]:
    """Return the poses after one damped step."""
    damped = (h + damping * diags(h.diagonal())).tocsc()
    factor = splu(
        damped, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
    )
    trial: NDArray[np.float64] = poses.copy()
    trial[1:] += factor.solve(-g).reshape(-1, 3)
    angles: NDArray[np.float64] = trial[:, 2]
    trial[:, 2] = wrap(angles)
    return trial
