"""Pose-graph optimisation of a g2o or TORO file, beside SciPy's splu, and GTSAM if installed."""

from __future__ import annotations

import argparse
import importlib
import importlib.util
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.linalg import splu

from arjuna_core.se2 import SE2
from arjuna_slam.graph.optimizer import assemble, damp
from arjuna_slam.graph.pose_graph import EdgeTable
from arjuna_slam.graph.sparse_cholesky import Pattern, factorize, pattern, solve
from tests.helpers.posegraph import cost, optimize_globally, read_graph

_REPEATS = 5

Poses = NDArray[np.float64]
T = TypeVar("T")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add this benchmark's options."""
    parser.add_argument("--g2o", type=Path, required=True, help="pose graph, g2o or TORO")


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    """Optimise from the file's own guess with no robust kernel, the best time of five.

    Returns:
        `chi2` and `time_s`, and GTSAM's batch Levenberg-Marquardt as `gtsam_chi2` and
        `gtsam_time_s` (None without it). Both times are from poses and edges in memory to poses.
        Of one step's linear equations: `pattern_s`, once a graph, and `cholesky_s` of our block
        Cholesky; `splu_s` of SciPy's; `splu_difference`, the greatest of the solutions.
    """
    start, edges = read_graph(arguments.g2o)
    optimize_globally(start, edges, iterations=1)
    seconds, poses = _best(lambda: optimize_globally(start, edges).poses)
    result: dict[str, Any] = {
        "nodes": len(start),
        "edges": len(edges),
        "start_chi2": cost(start, edges),
        "chi2": cost(poses, edges),
        "time_s": seconds,
        **_linear(start, edges),
        "gtsam_chi2": None,
        "gtsam_time_s": None,
    }
    if importlib.util.find_spec("gtsam") is None:
        print("gtsam is not installed: nothing to compare with")
    else:
        seconds, poses = _gtsam(start, edges)
        result |= {"gtsam_chi2": cost(poses, edges), "gtsam_time_s": seconds}
    print(f"{len(start)} nodes, {len(edges)} edges, chi2 {result['start_chi2']:.1f} at the start")
    for name, prefix in (("arjuna", ""), ("gtsam", "gtsam_")):
        if result[f"{prefix}chi2"] is not None:
            chi2, seconds = result[f"{prefix}chi2"], result[f"{prefix}time_s"]
            print(f"{name:8}  chi2 {chi2:12.4f}  {1e3 * seconds:8.1f} ms")
    ours, other = 1e3 * result["cholesky_s"], 1e3 * result["splu_s"]
    print(f"a step's equations: block Cholesky {ours:.2f} ms, splu {other:.2f} ms")
    return result


def _best(once: Callable[[], T]) -> tuple[float, T]:
    """Return the least time and a result."""
    seconds, result = np.inf, once()
    for _ in range(_REPEATS):
        start = time.perf_counter()
        result = once()
        seconds = min(seconds, time.perf_counter() - start)
    return seconds, result


def _gtsam(start: Poses, edges: EdgeTable) -> tuple[float, Poses]:
    gtsam = importlib.import_module("gtsam")
    graph, guess = gtsam.NonlinearFactorGraph(), gtsam.Values()
    for node, pose in enumerate(start.tolist()):
        guess.insert(node, gtsam.Pose2(*pose))
    held = gtsam.noiseModel.Isotropic.Sigma(3, 1e-6)
    graph.add(gtsam.PriorFactorPose2(0, gtsam.Pose2(*start[0]), held))
    rows = zip(
        edges.i.tolist(), edges.j.tolist(), edges.measured.tolist(), edges.information, strict=True
    )
    for i, j, measured, information in rows:
        turn = SE2(0.0, 0.0, measured[2]).matrix()  # GTSAM's is in the axes of the second node
        noise = gtsam.noiseModel.Gaussian.Information(turn.T @ information @ turn)
        graph.add(gtsam.BetweenFactorPose2(i, j, gtsam.Pose2(*measured), noise))

    seconds, found = np.inf, guess
    for _ in range(_REPEATS):
        begin = time.perf_counter()
        found = gtsam.LevenbergMarquardtOptimizer(graph, guess).optimize()
        seconds = min(seconds, time.perf_counter() - begin)
    poses = [found.atPose2(node) for node in range(len(start))]
    return seconds, np.array([(pose.x(), pose.y(), pose.theta()) for pose in poses])


def _linear(start: Poses, edges: EdgeTable) -> dict[str, float]:
    """Solve the equations of the first step with block Cholesky and with SciPy's splu."""
    i, j, count = np.ascontiguousarray(edges.i), np.ascontiguousarray(edges.j), len(start)
    pattern_s, layout = _best(lambda: pattern(count, i, j))
    blocks = np.empty((len(layout.rows), 3, 3))
    corner = np.empty((3 * layout.corner, 3 * layout.corner))
    g = np.empty((count, 3))
    assemble(
        start, i, j, edges.measured, edges.information, np.ones(len(i)),
        layout.perm, layout.starts, layout.slots, blocks, corner, g,
    )  # fmt: skip
    damp(layout.starts, blocks, corner, 1e-8)

    def ours() -> Poses:
        x: Poses = g.copy()
        factor, tail = blocks.copy(), corner.copy()
        factorize(layout.starts, layout.rows, factor, tail)
        solve(layout.starts, layout.rows, factor, tail, x)
        return x

    matrix, symmetric = _scalar(layout, blocks, corner), {"SymmetricMode": True}

    def theirs() -> Poses:
        factor = splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=symmetric)
        found: Poses = factor.solve(g.ravel())
        return found

    splu_s, y = _best(theirs)
    cholesky_s, x = _best(ours)
    difference = float(np.abs(y - x.ravel()).max())
    return {
        "pattern_s": pattern_s, "cholesky_s": cholesky_s, "splu_s": splu_s,
        "splu_difference": difference,
    }  # fmt: skip


def _scalar(layout: Pattern, blocks: NDArray[np.float64], corner: NDArray[np.float64]) -> Any:
    """Return the matrix whose lower triangle the blocks and the corner are, without its zeros."""
    columns = np.repeat(np.arange(len(layout.starts) - 1), np.diff(layout.starts))
    at = np.arange(3)
    row = (3 * layout.rows[:, None, None] + at[:, None] + 0 * at).ravel()
    column = (3 * columns[:, None, None] + 0 * at[:, None] + at).ravel()
    first = 3 * (len(layout.starts) - 1)
    tail_row, tail_column = np.nonzero(corner)
    row = np.concatenate((row, tail_row + first))
    column = np.concatenate((column, tail_column + first))
    values = np.concatenate((blocks.ravel(), corner[tail_row, tail_column]))
    lower = (row >= column) & (values != 0.0)
    row, column, values = row[lower], column[lower], values[lower]
    across = row != column
    pairs = np.concatenate((row, column[across])), np.concatenate((column, row[across]))
    size = 3 * len(layout.perm)
    both = np.concatenate((values, values[across]))
    return coo_matrix((both, pairs), shape=(size, size)).tocsc()
