from __future__ import annotations

import math

import numpy as np
import pytest

from arjuna_core.arrays import Floats
from arjuna_core.se2 import SE2
from arjuna_slam.graph.linearization import fill_jacobians, residual
from arjuna_slam.graph.optimizer import OptimizerStatus, optimize
from arjuna_slam.graph.pose_graph import Edge, EdgeKind, EdgeTable, PoseGraph
from tests.helpers.posegraph import initialize, optimize_globally

INFORMATION = np.diag([100.0, 100.0, 400.0])


def ring(count: int, drift: float) -> tuple[Floats, Floats, list[Edge]]:
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


def test_exact_edges_alone_give_the_exact_poses() -> None:
    truth, _, edges = ring(12, 0.0)
    edges.append(Edge(0, 11, SE2.from_array(truth[11]), INFORMATION, EdgeKind.LOOP))
    start = np.vstack((truth[:1], np.zeros((11, 3))))
    found = initialize(start, EdgeTable.of(edges))
    assert found[:, :2] == pytest.approx(truth[:, :2], abs=1e-6)
    assert np.cos(found[:, 2] - truth[:, 2]) == pytest.approx(1.0)


def test_a_start_far_off_ends_in_no_local_minimum() -> None:
    """Noise of 0.2 rad in each turn: from dead reckoning the plain optimiser gets stuck."""
    rng = np.random.default_rng(4)
    truth, _, _ = ring(60, 0.0)
    laps = np.concatenate([truth] * 4)
    poses = [SE2.from_array(pose) for pose in laps]
    pairs = [(k, k + 1) for k in range(239)] + [(k, k + 60) for k in range(180)]
    edges = []
    for i, j in pairs:
        noise = SE2(*rng.normal(0.0, (0.02, 0.02, 0.2)))
        edges.append(Edge(i, j, poses[i].inverse() @ poses[j] @ noise, INFORMATION, EdgeKind.LOOP))
    bent = [poses[0]]
    for edge in edges[:239]:
        bent.append(bent[-1] @ edge.T_i_j)
    start, table = np.array([pose.array() for pose in bent]), EdgeTable.of(edges)
    plain, result = optimize(start, table, iterations=100), optimize_globally(start, table)
    assert plain.trace[-1] > 2.0 * result.trace[-1]
    assert np.hypot(*(result.poses - laps)[:, :2].T).mean() < 1.0


@pytest.mark.parametrize("off", [0.02, 0.3, 2.0])
def test_a_loops_weight_is_the_slope_of_its_cost(off: float) -> None:
    poses = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])

    def told(error: float) -> tuple[float, float, float]:
        """Return the squared error, the cost and the weight of the loop alone."""
        edges = [
            Edge(0, 1, SE2(1.0), INFORMATION, EdgeKind.ODOMETRY),
            Edge(0, 1, SE2(1.0 + error), INFORMATION, EdgeKind.LOOP),
        ]
        result = optimize(poses, EdgeTable.of(edges), robust_scale=1.5, iterations=0)
        assert result.weights[0] == 1.0  # odometry is believed
        return 100.0 * error**2, result.trace[0], float(result.weights[1])

    (low, cost, _), (_, _, weight), (high, dearer, _) = (told(off * k) for k in (0.999, 1.0, 1.001))
    assert weight == pytest.approx((dearer - cost) / (high - low), rel=1e-3)
