"""Pose-graph optimisation of a g2o or TORO file, beside GTSAM where it is installed."""

from __future__ import annotations

import argparse
import importlib
import importlib.util
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arjuna_core.se2 import SE2
from arjuna_slam.graph.files import read_graph
from arjuna_slam.graph.initialization import cost, optimize_globally
from arjuna_slam.graph.pose_graph import EdgeTable

_REPEATS = 5

Poses = NDArray[np.float64]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add this benchmark's options."""
    parser.add_argument("--g2o", type=Path, required=True, help="pose graph, g2o or TORO")


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    """Optimise from the file's own guess with no robust kernel, the best time of five.

    Returns:
        `chi2` and `time_s`, and GTSAM's batch Levenberg-Marquardt as `gtsam_chi2` and
        `gtsam_time_s` (None without it). Both times are from poses and edges in memory to poses.
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
    return result


def _best(once: Callable[[], Poses]) -> tuple[float, Poses]:
    """Return the least time and the last result."""
    seconds, poses = np.inf, np.empty((0, 3))
    for _ in range(_REPEATS):
        start = time.perf_counter()
        poses = once()
        seconds = min(seconds, time.perf_counter() - start)
    return seconds, poses


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
