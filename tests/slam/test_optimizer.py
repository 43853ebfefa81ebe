from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from arjuna_core.se2 import SE2
from arjuna_slam.linearization import fill_jacobians, residual
from arjuna_slam.optimizer import OptimizerStatus, optimize
from arjuna_slam.pose_graph import Edge, EdgeKind, EdgeTable, PoseGraph

INFORMATION = np.diag([100.0, 100.0, 400.0])


def ring(count: int, drift: float) -> tuple[NDArray[np.float64], NDArray[np.float64], list[Edge]]:
    """True poses on a circle, poses dead-reckoned with a drift in heading, and the exact edges."""
    step = SE2(1.0, 0.0, 2.0 * math.pi / count)
    truth, bent = [SE2()], [SE2()]
    for _ in range(count - 1):
        truth.append(truth[-1] @ step)
        bent.append(bent[-1] @ SE2(1.0, 0.0, step.theta + drift))
    edges = [
        Edge(k, k + 1, SE2(1.0, 0.0, step.theta + drift), INFORMATION, EdgeKind.ODOMETRY)
        for k in range(count - 1)
    ]
    return np.array([p.array() for p in truth]), np.array([p.array() for p in bent]), edges


def test_jacobians_are_the_finite_differences() -> None:
    rng = np.random.default_rng(1)
    for _ in range(8):
        pair = rng.normal(0.0, 2.0, (2, 3))
        measured = residual(pair[0], pair[1], np.zeros(3)) + rng.normal(0.0, 0.01, 3)
        analytic = np.zeros((2, 3, 3))
        fill_jacobians(pair[0], pair[1], analytic[0], analytic[1])
        for which in range(2):
            for axis in range(3):
                high, low = pair.copy(), pair.copy()
                high[which, axis] += 1e-6
                low[which, axis] -= 1e-6
                rise = residual(high[0], high[1], measured) - residual(low[0], low[1], measured)
                assert analytic[which, :, axis] == pytest.approx(rise / 2e-6, abs=1e-7)


def test_a_loop_edge_closes_a_bent_ring() -> None:
    truth, bent, edges = ring(40, math.radians(1.0))
    last = SE2.from_array(truth[-1])
    edges.append(Edge(0, 39, last, 1e6 * INFORMATION, EdgeKind.LOOP))
    result = optimize(bent, EdgeTable.of(edges))
    assert result.status is OptimizerStatus.CONVERGED
    assert result.trace[-1] < 1e-3 * result.trace[0]
    assert list(result.trace) == sorted(result.trace, reverse=True)
    assert np.hypot(*(result.poses[39, :2] - truth[39, :2])) < 0.01
    assert (result.poses[0] == bent[0]).all()


def test_consistent_edges_leave_no_error() -> None:
    truth, _, edges = ring(12, 0.0)
    rng = np.random.default_rng(2)
    start = truth + rng.normal(0.0, 0.1, truth.shape)
    start[0] = truth[0]
    result = optimize(start, EdgeTable.of(edges), tolerance=1e-12)
    assert result.poses[:, :2] == pytest.approx(truth[:, :2], abs=1e-6)


def test_the_robust_kernel_ignores_a_false_loop() -> None:
    truth, _, edges = ring(40, 0.0)
    edges.append(Edge(0, 39, SE2.from_array(truth[39]), INFORMATION, EdgeKind.LOOP))
    edges.append(Edge(0, 20, SE2(3.0, -4.0, 1.0), INFORMATION, EdgeKind.LOOP))
    robust = optimize(truth, EdgeTable.of(edges), robust_scale=1.0, iterations=100).poses
    plain = optimize(truth, EdgeTable.of(edges)).poses
    assert np.hypot(*(robust - truth)[:, :2].T).max() < 0.3
    assert np.hypot(*(plain - truth)[:, :2].T).max() > 2.0


def test_an_edge_to_nowhere_is_refused() -> None:
    graph = PoseGraph()
    graph.add_node(SE2())
    with pytest.raises(ValueError, match=r"two different nodes of 0\.\.0"):
        graph.add_edge(Edge(0, 1, SE2(), INFORMATION, EdgeKind.MATCH))


def test_a_graph_keeps_its_poses_as_it_grows() -> None:
    graph = PoseGraph()
    for k in range(200):
        assert graph.add_node(SE2(float(k), 0.0, 0.0)) == k
    assert (graph.poses[:, 0] == np.arange(200)).all()
