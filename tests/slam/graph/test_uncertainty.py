from __future__ import annotations

import math

import numpy as np
import pytest

from arjuna_core.arrays import Floats
from arjuna_core.se2 import SE2
from arjuna_slam.graph.pose_graph import Edge, EdgeKind, PoseGraph
from arjuna_slam.graph.uncertainty import chained, plausible, relative_covariances, spread

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
def test_a_correction_is_plausible_up_to_four_deviations(
    along: tuple[float, float, float], theta: float
) -> None:
    """Of what the graph does not know, and of 0.1 m and 0.02 rad more."""
    known = np.array([[0.5, 0.1, 0.02], [0.1, 0.3, -0.01], [0.02, -0.01, 0.04]])
    information = np.linalg.inv(known + np.diag([0.1**2, 0.1**2, 0.02**2]))
    reach = 4.0 / math.sqrt(np.array(along) @ information @ np.array(along))
    expected = SE2(1.0, 2.0, theta)
    for by, is_plausible in ((0.999, True), (1.001, False)):
        found = expected.array() + by * reach * np.array(along)
        found[2] = math.remainder(found[2], 2.0 * math.pi)
        assert plausible(expected, SE2.from_array(found), known) is is_plausible
