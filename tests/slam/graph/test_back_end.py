"""When the back end optimises, how loosely and how far at a time, and what it takes back."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
import pytest

from arjuna_core.arrays import Floats
from arjuna_core.se2 import SE2
from arjuna_slam.graph import back_end
from arjuna_slam.graph.back_end import BackEnd, BackEndConfig
from arjuna_slam.graph.optimizer import OptimizerResult, OptimizerStatus
from arjuna_slam.graph.pose_graph import Edge, EdgeKind, EdgeTable, PoseGraph

NODES = 60
MOVED = (0.0, 1.0, 0.1)
DONE, UNFINISHED = OptimizerStatus.CONVERGED, OptimizerStatus.MAX_ITERATIONS


@dataclass
class Scripted:
    """An optimiser that moves all but the first node, and ends as scripted, then well."""

    by: tuple[float, float, float] = MOVED
    ends: list[OptimizerStatus] = field(default_factory=list)
    weights: dict[int, float] = field(default_factory=dict)
    starts: list[Floats] = field(default_factory=list)
    hows: list[tuple[int, float]] = field(default_factory=list)
    scales: list[float] = field(default_factory=list)

    def __call__(
        self,
        poses: Floats,
        edges: EdgeTable,
        *,
        robust_scale: float,
        iterations: int,
        tolerance: float,
        damping: float,
    ) -> OptimizerResult:
        self.starts.append(poses.copy())
        self.hows.append((iterations, tolerance))
        self.scales.append(robust_scale)
        weights = np.ones(len(edges))
        for first, weight in self.weights.items():
            weights[edges.i == first] = weight
        moved = poses + np.array(self.by)
        moved[0] = poses[0]
        return OptimizerResult(self.ends.pop(0) if self.ends else DONE, moved, (0.0,), weights)


@pytest.fixture(name="scripted")
def _scripted(monkeypatch: pytest.MonkeyPatch) -> Scripted:
    scripted = Scripted()
    monkeypatch.setattr(back_end, "optimize", scripted)
    return scripted


def straight(count: int = NODES) -> PoseGraph:
    graph = PoseGraph()
    for k in range(count):
        graph.add_node(SE2(float(k), 0.0, 0.0))
        if k:
            graph.add_edge(Edge(k - 1, k, SE2(1.0), np.eye(3), EdgeKind.ODOMETRY))
    return graph


def loop(off: SE2, i: int = 3, j: int = 50, information: float = 1.0) -> Edge:
    """Return a loop edge that the graph meets but for an error."""
    return Edge(
        i, j, SE2(j - i - off.x, -off.y, -off.theta), information * np.eye(3), EdgeKind.LOOP
    )


@pytest.mark.parametrize(
    ("off", "urgent"),
    [
        (SE2(0.099, 0.0, 0.0), False),
        (SE2(0.08, 0.08, 0.0), True),
        (SE2(-0.101, 0.0, 0.0), True),
        (SE2(0.0, 0.0, 0.029), False),
        (SE2(0.0, 0.0, 0.031), True),
        (SE2(0.0, 0.0, -0.031), True),
        (SE2(0.0, 0.0, 2.0 * math.pi), False),
    ],
)
def test_a_closure_that_is_far_off_is_not_kept_waiting(off: SE2, urgent: bool) -> None:
    graph = straight()
    work = BackEnd(BackEndConfig(), graph)
    edges = [loop(off), loop(SE2())]
    work.add(edges)
    assert bool(work.running) is urgent
    assert graph.edges[-2:] == edges


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_a_graph_bent_out_of_shape_comes_to_rest(seed: int) -> None:
    """No first step of it descends: the damping grows from one call to the next."""
    rng, count = np.random.default_rng(seed), 12
    graph, step = PoseGraph(), SE2(1.0, 0.0, 2.0 * math.pi / count)
    for k in range(count):
        graph.add_node(SE2.from_array(rng.uniform((-5.0, -5.0, -3.0), (5.0, 5.0, 3.0))))
        if k:
            graph.add_edge(Edge(k - 1, k, step, 100.0 * np.eye(3), EdgeKind.ODOMETRY))
    work = BackEnd(BackEndConfig(), graph)
    work.add([Edge(count - 1, 0, step, 100.0 * np.eye(3), EdgeKind.LOOP)])
    for _ in range(60):
        work.advance()
    assert not work.running


@pytest.mark.parametrize(("count", "waits"), [(60, 23), (100, 24), (101, 25)])
def test_agreeing_closures_wait_for_others(scripted: Scripted, count: int, waits: int) -> None:
    """20 keyframes, and 4 % of all; with no closure, for ever."""
    scripted.by = (0.0, 0.0, 0.0)
    work = BackEnd(BackEndConfig(), straight(count))
    for _ in range(30):
        work.add([])
        work.advance()
    assert not scripted.starts
    work = BackEnd(BackEndConfig(), straight(count))
    for _ in range(2):  # the second time as the first
        for k in range(waits):
            assert not work.running
            work.add([loop(SE2())] if k == 1 else [])
        assert work.running
        work.advance()
        assert not work.running
    for _ in range(waits):
        work.add([])
    assert not work.running  # what was optimised is not fresh any more
    work.add([loop(SE2())])
    assert work.running
    work.finish()
    for _ in range(2 * waits):
        assert not work.running
        work.add([])
    work.add([loop(SE2())])
    assert work.running
    work.finish()
    for k in range(waits):
        assert not work.running
        work.add([loop(SE2())] if k == 0 else [])
    assert work.running
    assert scripted.hows == [(2, 1e-3), (2, 1e-3), (30, 1e-6), (30, 1e-6)]
    assert work.undone == 0


@pytest.mark.parametrize(
    ("edges", "looseness"),
    [
        ([loop(SE2(0.2), information=1e4)], 20.0 / 3.0),
        ([loop(SE2(0.3, -0.4), information=1e4), loop(SE2(0.2), information=1e4)], 50.0 / 3.0),
        ([loop(SE2(0.2), information=1e4), loop(SE2(0.3, 0.4), information=1e4)], 50.0 / 3.0),
        ([loop(SE2(0.0, 0.0, 0.3), information=1e4)], 10.0),
        ([loop(SE2(0.2), information=100.0)], 1.0),  # two deviations are no doubt
        ([loop(SE2(0.05), information=1e6)], 1.0),  # near the optimum it is convex
        ([loop(SE2(40.0), information=1e4)], 1000.0),
    ],
)
def test_the_kernel_is_as_wide_as_what_it_must_believe_and_tightens(
    scripted: Scripted, edges: list[Edge], looseness: float
) -> None:
    graph = straight()
    work = BackEnd(BackEndConfig(), graph)
    work.add(edges)
    if not work.running:
        work.finish()
    while work.running:
        work.advance()
    expected = [3.0 * looseness]
    while expected[-1] > 3.0:
        expected.append(max(expected[-1] / 4.0, 3.0))
    assert scripted.scales == pytest.approx(expected)
    work.finish()
    assert scripted.scales[-1] == 3.0


def test_the_graph_moves_once_with_newer_nodes_beside_the_last(scripted: Scripted) -> None:
    scripted.ends = [UNFINISHED, UNFINISHED]
    graph = straight()
    work = BackEnd(BackEndConfig(), graph)
    work.add([loop(SE2(0.2))])  # far, and by no more deviations than the kernel's
    before = graph.poses.copy()
    work.advance()
    assert work.running
    np.testing.assert_array_equal(graph.poses, before)
    newer = [SE2(60.5, 0.3, 0.2), SE2(61.0, 0.7, 0.4)]
    for pose in newer:
        graph.add_node(pose)
    work.advance()
    start = scripted.starts[1]
    assert start.shape == (NODES + 2, 3)
    last = before[-1] + MOVED
    np.testing.assert_allclose(start[NODES - 1], last)
    for k, pose in enumerate(newer):
        beside = np.linalg.inv(SE2.from_array(before[-1]).matrix()) @ pose.matrix()
        expected = SE2.from_array(last).matrix() @ beside
        np.testing.assert_allclose(SE2.from_array(start[NODES + k]).matrix(), expected, atol=1e-12)
    np.testing.assert_array_equal(graph.poses[:NODES], before)
    work.advance()
    assert not work.running
    np.testing.assert_allclose(graph.poses[1:], scripted.starts[2][1:] + MOVED)
    work.advance()
    assert len(scripted.starts) == 3  # nothing runs
    kept = graph.poses.copy()
    work.finish()
    np.testing.assert_array_equal(scripted.starts[3], kept)  # from where the graph lies


def test_at_the_end_steps_used_up_are_enough(scripted: Scripted) -> None:
    scripted.ends = [UNFINISHED]
    graph = straight()
    BackEnd(BackEndConfig(), graph).finish()
    assert len(scripted.starts) == 1
    assert graph.poses[5].tolist() == pytest.approx([5.0, 1.0, 0.1])


@pytest.mark.parametrize(
    ("weight", "node", "taken"),
    [(0.0099, 19, True), (0.01, 19, False), (0.0, 20, False), (1.0, 19, False)],
)
def test_a_closure_that_others_contradict_is_taken_back(
    scripted: Scripted, weight: float, node: int, taken: bool
) -> None:
    """Of the last 40 of 60 keyframes none has been on trial long enough."""
    graph = straight()
    doubted, good = loop(SE2(), 3, node), loop(SE2(), 5, 15)
    work = BackEnd(BackEndConfig(), graph, undone=2)
    work.add([doubted, good])
    scripted.weights = {3: weight, 10: 0.0}  # odometry is not taken back whatever it weighs
    work.finish()
    assert work.undone == 2 + taken
    assert (doubted in graph.edges) is not taken
    assert good in graph.edges
    assert len(graph.edges) == len(graph.table) == NODES + 1 - taken
    assert len(scripted.starts) == 1 + taken  # without it all may lie elsewhere
