"""The graph as columns, and what may be added to it."""

from __future__ import annotations

import math

import numpy as np
import pytest

from arjuna_core.arrays import Floats
from arjuna_core.se2 import SE2
from arjuna_slam.graph.pose_graph import Edge, EdgeKind, PoseGraph


def random_graph(seed: int, count: int = 12, loops: int = 6) -> PoseGraph:
    """Return a wandering chain with noisy measurements and loops, some of them wrong."""
    rng = np.random.default_rng(seed)
    graph, true = PoseGraph(), [SE2()]
    for k in range(count):
        if k:
            true.append(true[-1] @ SE2(*rng.normal((1.0, 0.0, 0.3), (0.2, 0.2, 0.5)).tolist()))
        graph.add_node(true[-1] @ SE2(*(rng.normal(0.0, 0.1, 3) * (k > 0)).tolist()))
    chain = [(k, k + 1) for k in range(count - 1)]
    closed = [tuple(sorted(rng.choice(count, 2, replace=False).tolist())) for _ in range(loops)]
    for n, (i, j) in enumerate([*chain, *closed]):
        root = rng.normal(0.0, 3.0, (3, 3))
        noise = rng.normal(0.0, 0.05 if n % 4 else 0.4, 3)
        T = true[i].inverse() @ true[j] @ SE2(*noise.tolist())
        kind = EdgeKind.LOOP if n >= count - 1 else EdgeKind.MATCH
        information = np.asarray(root @ root.T + 4.0 * np.eye(3), np.float64)
        graph.add_edge(Edge(i, j, T, information, kind))
    return graph


def error(poses: Floats, edge: Edge) -> Floats:
    """Return how far a measurement is off, by matrices."""
    i, j = (SE2.from_array(poses[k]).matrix() for k in (edge.i, edge.j))
    T = np.linalg.inv(i) @ j
    turn = math.remainder(math.atan2(T[1, 0], T[0, 0]) - edge.T_i_j.theta, 2.0 * math.pi)
    return np.array([T[0, 2] - edge.T_i_j.x, T[1, 2] - edge.T_i_j.y, turn])


def test_columns_hold_every_edge_as_they_grow_and_when_some_go() -> None:
    graph = random_graph(2, count=150, loops=80)
    assert len(graph) == 150
    gone = np.arange(len(graph.edges)) % 3 == 1
    kept = [edge for edge, out in zip(graph.edges, gone.tolist(), strict=True) if not out]
    prior = np.diag([3.0, 2.0, 1.0])
    for expected in (list(graph.edges), kept):
        table = graph.table
        assert graph.edges == expected
        assert len(table) == len(table.i) == len(expected)
        assert table.i.tolist() == [edge.i for edge in expected]
        assert table.j.tolist() == [edge.j for edge in expected]
        assert table.loop.tolist() == [edge.kind is EdgeKind.LOOP for edge in expected]
        np.testing.assert_array_equal(table.measured, [edge.T_i_j.array() for edge in expected])
        np.testing.assert_array_equal(table.information, [edge.information for edge in expected])
        known = [np.linalg.inv(edge.information) for edge in expected]
        np.testing.assert_allclose(table.covariance, known, rtol=1e-4, atol=1e-8)
        if len(expected) == len(gone):
            graph.remove_edges(gone)
    graph.add_edge(Edge(0, 1, SE2(), 0.0 * prior, EdgeKind.MATCH, prior))
    np.testing.assert_allclose(graph.table.covariance[-1], np.linalg.inv(prior))


@pytest.mark.parametrize("seed", range(4))
def test_the_residual_is_what_the_poses_say_less_the_measurement(seed: int) -> None:
    graph = random_graph(seed, loops=12)
    for edge in graph.edges:
        assert graph.residual(edge) == pytest.approx(error(graph.poses, edge), abs=1e-12)


@pytest.mark.parametrize(("i", "j"), [(-1, 2), (2, -1), (3, 0), (0, 3), (1, 1)])
def test_an_edge_joins_two_nodes_that_there_are(i: int, j: int) -> None:
    graph = random_graph(0, count=3, loops=0)
    with pytest.raises(ValueError, match=rf"edge {i} -> {j}: two different nodes of 0\.\.2"):
        graph.add_edge(Edge(i, j, SE2(), np.eye(3), EdgeKind.LOOP))
    graph.add_edge(Edge(2, 0, SE2(), np.eye(3), EdgeKind.LOOP))
    assert len(graph.table) == len(graph.edges) == 3
