"""The optimizer and the uncertainty of corrections."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import least_squares

from arjuna_core.arrays import Floats
from arjuna_core.se2 import SE2
from arjuna_slam.graph.optimizer import OptimizerStatus, fill_jacobians, optimize, residual
from arjuna_slam.graph.pose_graph import Edge, EdgeKind, EdgeTable, PoseGraph
from arjuna_slam.graph.uncertainty import chained, plausible, relative_covariances, spread
from tests.helpers.posegraph import optimize_globally
from tests.slam.graph.test_pose_graph import error, random_graph

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
    assert plain.status is not OptimizerStatus.NO_DESCENT  # though steps were refused
    assert plain.trace[-1] > 2.0 * result.trace[-1]
    assert np.hypot(*(result.poses - laps)[:, :2].T).mean() < 1.0


def cost(poses: Floats, edges: list[Edge], scale: float) -> float:
    """Return the sum of squared deviations, that of loops as Cauchy's kernel has it."""
    total = 0.0
    for edge in edges:
        off = error(poses, edge)
        square = float(off @ edge.information @ off)
        is_loop = edge.kind is EdgeKind.LOOP and math.isfinite(scale)
        total += scale**2 * math.log1p(square / scale**2) if is_loop else square
    return total


@pytest.mark.parametrize("seed", range(3))
def test_the_optimum_is_that_of_least_squares(seed: int) -> None:
    graph = random_graph(seed)

    def deviations(free: Floats) -> Floats:
        poses = np.concatenate((graph.poses[:1], free.reshape(-1, 3)))
        roots = [np.linalg.cholesky(edge.information).T for edge in graph.edges]
        pairs = zip(roots, graph.edges, strict=True)
        return np.concatenate([root @ error(poses, edge) for root, edge in pairs])

    result = optimize(graph.poses, graph.table, tolerance=1e-12, iterations=100)
    expected = least_squares(deviations, graph.poses[1:].ravel(), xtol=1e-12, ftol=1e-12).x
    off = result.poses[1:] - expected.reshape(-1, 3)
    off[:, 2] = np.remainder(off[:, 2] + math.pi, 2.0 * math.pi) - math.pi
    np.testing.assert_allclose(off, 0.0, atol=1e-4)
    assert result.status is OptimizerStatus.CONVERGED
    assert result.trace[0] == pytest.approx(cost(graph.poses, graph.edges, math.inf))
    assert result.trace[-1] == pytest.approx(cost(result.poses, graph.edges, math.inf))
    assert (np.abs(result.poses[:, 2]) <= math.pi).all()
    np.testing.assert_array_equal(result.weights, 1.0)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("scale", [0.5, 3.0])
def test_at_the_end_the_robust_cost_rises_in_every_direction(seed: int, scale: float) -> None:
    graph = random_graph(seed)
    before = graph.poses.copy()
    result = optimize(graph.poses, graph.table, robust_scale=scale, tolerance=1e-12, iterations=300)
    np.testing.assert_array_equal(graph.poses, before)  # its caller's
    least = cost(result.poses, graph.edges, scale)
    assert result.trace[-1] == pytest.approx(least)
    assert list(result.trace) == sorted(result.trace, reverse=True)
    for k in range(1, len(graph)):
        for step in (*(1e-3 * np.eye(3)), *(-1e-3 * np.eye(3))):
            moved = result.poses.copy()
            moved[k] += step
            assert cost(moved, graph.edges, scale) > least
    weights = [1.0] * len(graph.edges)
    for n, edge in enumerate(graph.edges):
        if edge.kind is EdgeKind.LOOP:
            off = error(result.poses, edge)
            weights[n] = 1.0 / (1.0 + float(off @ edge.information @ off) / scale**2)
    np.testing.assert_allclose(result.weights, weights, rtol=1e-9)


def test_how_an_optimisation_ends() -> None:
    graph = random_graph(1)
    one = optimize(graph.poses, graph.table, iterations=1)
    assert one.status is OptimizerStatus.MAX_ITERATIONS
    assert len(one.trace) <= 2
    loose = optimize(graph.poses, graph.table, tolerance=0.999)
    assert (loose.status, len(loose.trace)) == (OptimizerStatus.CONVERGED, 2)
    for poses, edges in ((graph.poses, EdgeTable.of([])), (graph.poses[:1], EdgeTable.of([]))):
        none = optimize(poses, edges)
        assert (none.status, none.trace, len(none.weights)) == (
            OptimizerStatus.CONVERGED,
            (0.0,),
            0,
        )
        np.testing.assert_array_equal(none.poses, poses)


STEP = np.diag([1e4, 1e4, 1e6])  # 1 cm and 1 mrad


def straight(count: int, information: Floats = STEP, heading: float = 0.7) -> PoseGraph:
    """A node each metre."""
    graph = PoseGraph()
    for k in range(count):
        graph.add_node(SE2(k * math.cos(heading), k * math.sin(heading), heading))
    for k in range(count - 1):
        graph.add_edge(Edge(k, k + 1, SE2(1.0), information, EdgeKind.ODOMETRY))
    return graph


def test_a_loop_is_a_short_cut() -> None:
    graph = straight(101)
    before = spread(relative_covariances(graph, 100)[5])
    graph.add_edge(Edge(3, 98, SE2(95.0), STEP, EdgeKind.LOOP))
    after = spread(relative_covariances(graph, 100)[5])
    assert after[1] == pytest.approx(before[1] * math.sqrt(5 / 95), rel=1e-6)


def test_an_edge_counts_as_much_from_its_other_end() -> None:
    graph = straight(2, np.diag([4.0, 1e4, 1e6]))
    there, back = (relative_covariances(graph, k)[1 - k] for k in (0, 1))
    assert there[0, 0] == pytest.approx(back[0, 0])
    assert there[2, 2] == pytest.approx(back[2, 2])


def test_the_bound_is_that_of_samples() -> None:
    """Chains of steps that err as their edges say spread as far as the bound of 20 m says."""
    rng, ends = np.random.default_rng(0), []
    for _ in range(4000):
        pose = SE2()
        for x, y, theta in rng.normal((1.0, 0.0, 0.0), (0.01, 0.01, 0.001), (20, 3)):
            pose = pose @ SE2(x, y, theta)
        ends.append(pose.array())
    sampled = np.cov(np.array(ends).T)
    bound = relative_covariances(straight(21), 0)[20]
    np.testing.assert_allclose(np.diag(bound) / np.diag(sampled), 0.95, rtol=0.1)


def test_what_is_asked_for_alone_is_as_among_all() -> None:
    graph = straight(101)
    graph.add_edge(Edge(3, 60, SE2(57.0), STEP, EdgeKind.LOOP))
    wanted = np.array([98, 62, 4])
    some, every = (relative_covariances(graph, 100, which) for which in (wanted, None))
    assert np.array_equal(some[wanted], every[wanted])
    assert some[0, 0, 0] > 1e3 > every[0, 0, 0]


def test_covariances_are_chained_as_their_derivatives_say() -> None:
    rng = np.random.default_rng(4)
    first, second = (SE2.from_array(rng.uniform(-2.0, 2.0, 3)) for _ in range(2))
    covariances = [part @ part.T for part in rng.normal(0.0, 0.1, (2, 3, 3))]
    step, expected = 1e-6, np.zeros((3, 3))
    for k, covariance in enumerate(covariances):
        columns = []
        for axis in np.eye(3) * step:
            a, b = (
                SE2.from_array(each.array() + (axis if k == n else 0.0))
                for n, each in enumerate((first, second))
            )
            columns.append(((a @ b).array() - (first @ second).array()) / step)
        jacobian = np.column_stack(columns)
        expected += jacobian @ covariance @ jacobian.T
    assert np.allclose(chained(first, covariances[0], second, covariances[1]), expected, atol=1e-6)


@pytest.mark.parametrize(
    ("along", "share"), [(1, 0.285), (10, 0.6), (25, 1.125), (50, 2.0), (80, 2.0)]
)
def test_steps_add_up_to_a_quarter_at_first_and_to_twice_far_on(along: int, share: float) -> None:
    """From 0.25 at once to 2.0 after 50 m; straight on headings do not matter."""
    covariance = relative_covariances(straight(101), 100)[100 - along]
    assert covariance[0, 0] == pytest.approx(share * along * 1e-4)
    assert covariance[2, 2] == pytest.approx(share * along * 1e-6)
    assert not relative_covariances(straight(101), 100)[100].any()


def test_what_no_chain_reaches_is_not_known() -> None:
    graph = straight(5)
    graph.add_node(SE2(9.0, 9.0, 0.0))
    assert spread(relative_covariances(graph, 0)[5]) == pytest.approx((500.0, 500.0))


@pytest.mark.parametrize("seed", range(3))
def test_the_spread_is_the_greatest_deviation_in_any_direction(seed: int) -> None:
    root = np.random.default_rng(seed).normal(size=(3, 3))
    covariance = root @ root.T
    xy, theta = spread(covariance)
    assert xy == pytest.approx(math.sqrt(np.linalg.eigvalsh(covariance[:2, :2])[1]))
    assert theta == pytest.approx(math.sqrt(covariance[2, 2]))


@pytest.mark.parametrize(
    "along", [(1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, 1.0), (0.3, -0.5, -0.1)]
)
@pytest.mark.parametrize("theta", [0.4, 3.1, -3.1])
def test_plausible_within_four_sigmas(along: tuple[float, float, float], theta: float) -> None:
    """Of what the graph does not know, and of 0.1 m and 0.02 rad more."""
    known = np.array([[0.5, 0.1, 0.02], [0.1, 0.3, -0.01], [0.02, -0.01, 0.04]])
    information = np.linalg.inv(known + np.diag([0.1**2, 0.1**2, 0.02**2]))
    reach = 4.0 / math.sqrt(np.array(along) @ information @ np.array(along))
    expected = SE2(1.0, 2.0, theta)
    for by, is_plausible in ((0.999, True), (1.001, False)):
        found = expected.array() + by * reach * np.array(along)
        found[2] = math.remainder(found[2], 2.0 * math.pi)
        assert plausible(expected, SE2.from_array(found), known) is is_plausible
