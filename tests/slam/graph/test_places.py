"""Which submaps are compared, in which window and when again, and what is made of a place found."""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import pytest

from arjuna_core.arrays import Floats
from arjuna_core.scan import Scan
from arjuna_core.se2 import IDENTITY, SE2
from arjuna_slam.graph import wide_loops
from arjuna_slam.graph.hypotheses import Closure
from arjuna_slam.graph.loops import LoopConfig, Submap
from arjuna_slam.graph.pose_graph import Edge, EdgeKind, PoseGraph
from arjuna_slam.graph.submap_match import Search, SubmapMatch
from arjuna_slam.graph.uncertainty import relative_covariances, spread
from arjuna_slam.graph.wide_loops import WideLoops
from arjuna_slam.mapping.submap import Submap as Run
from arjuna_slam.matching.field import Field
from arjuna_slam.matching.scan_matcher import MatcherConfig, ScanMatcher

CONFIG = LoopConfig()
NOWHERE = np.zeros(2)
GOOD = np.diag([0.02**2, 0.03**2, 0.004**2])

Answer = Callable[[int, int, Search], SubmapMatch | None]


@dataclass
class Told:
    """A matcher of places that notes what it is asked, by anchors, and answers what it is told."""

    answer: Answer = lambda *_: None
    asked: list[tuple[int, int, Search]] = field(default_factory=list)

    def find(
        self, query: Submap, past: Submap, window: Search, scans: Sequence[Scan]
    ) -> Generator[None, None, SubmapMatch | None]:
        assert scans == []
        self.asked.append((query.anchor, past.anchor, window))
        yield
        return self.answer(query.anchor, past.anchor, window)

    def pairs(self) -> list[tuple[int, int]]:
        return [entry[:2] for entry in self.asked]


@dataclass
class Noted:
    """Hypotheses that believe nothing."""

    added: list[Closure] = field(default_factory=list)

    def add(self, _graph: PoseGraph, closure: Closure) -> list[Closure]:
        self.added.append(closure)
        return []


def work(patch: pytest.MonkeyPatch, told: Told, config: LoopConfig = CONFIG) -> WideLoops:
    patch.setattr(wide_loops, "SubmapMatcher", lambda *_: told)
    return WideLoops(config, ScanMatcher(MatcherConfig()), 20.0)


def ended(work: WideLoops, graph: PoseGraph, submaps: list[Run]) -> list[Closure]:
    """Return what is believed until there is nothing to do."""
    believed: list[Closure] = []
    while (found := work.step(graph, submaps, [])) is not None:
        believed += found
    return believed


def mapped(way: Sequence[SE2], size: int, deviation: float) -> tuple[PoseGraph, list[Run]]:
    """Return the graph of a way, and a submap of each few keyframes."""
    graph, submaps = PoseGraph(), []
    information = np.diag([deviation**-2, deviation**-2, 1e8])
    for k, pose in enumerate(way):
        graph.add_node(pose)
        if k:
            step = way[k - 1].inverse() @ pose
            graph.add_edge(Edge(k - 1, k, step, information, EdgeKind.MATCH))
    for first in range(0, len(way) - size + 1, size):
        submap = Run(Field(0.05, 0.05))
        submap.nodes.extend(range(first, first + size))
        submap.poses.extend(way[first].inverse() @ way[k] for k in submap.nodes)
        steps = zip(submap.poses, submap.poses[1:], strict=False)
        submap.path_length = sum(a.distance(b) for a, b in steps)
        submaps.append(submap)
    return graph, submaps


def rounds(seed: int, count: int) -> list[SE2]:
    """Return a way of half metres round and round a hall of 12 by 7 m, never quite the same."""
    rng, way = np.random.default_rng(seed), []
    for k in range(count):
        at = (0.5 * k) % 38.0
        x = min(at, 12.0) - min(max(at - 19.0, 0.0), 12.0)
        y = min(max(at - 12.0, 0.0), 7.0) - max(at - 31.0, 0.0)
        off = rng.uniform(-0.4, 0.4, 3).tolist()
        way.append(SE2(x + off[0], y + off[1], off[2]))
    return way


def due(
    graph: PoseGraph, submaps: list[Run], config: LoopConfig
) -> list[tuple[int, int, float, float]]:
    """Return which submaps may lie on which, in order, and half the window and angle of each."""
    result = []
    loops = [(edge.i, edge.j) for edge in graph.edges if edge.kind is EdgeKind.LOOP]
    for q, query in enumerate(submaps):
        found = []
        for past in submaps[: max(q - 1, 0)]:
            xy, theta = spread(relative_covariances(graph, query.anchor)[past.anchor])
            gap = min(
                graph.pose(a).distance(graph.pose(b))
                for a in query.nodes[:: max(1, len(query.nodes) // 6)]
                for b in past.nodes
            )
            joined = any(
                (i in query.nodes and j in past.nodes) or (j in query.nodes and i in past.nodes)
                for i, j in loops
            )
            half = min(0.2 + 3.0 * xy, 0.5 * config.loop_search_space_dimension)
            angle = min(0.03 + 3.0 * theta, config.loop_search_angle)
            if gap < 3.0 + half and not (joined and xy < 0.3):
                found.append((gap, past.anchor, half, angle))
        result += [(query.anchor, *entry[1:]) for entry in sorted(found)[:8]]
    return result


@pytest.mark.parametrize(
    ("seed", "size", "deviation", "dimension", "loops", "surely"),
    [
        (0, 8, 0.02, 30.0, (), 0.0),
        (1, 13, 0.1, 30.0, ((0, 80), (70, 145)), 400.0),
        (2, 5, 0.06, 3.0, ((3, 79), (100, 24), (60, 140)), 400.0),
        (3, 20, 0.02, 0.4, ((10, 83),), 400.0),
        (4, 8, 0.03, 0.8, ((45, 120), (160, 10)), 400.0),
        (5, 8, 0.1, 30.0, ((4, 84), (45, 120), (160, 10)), 0.5),  # known no better than by 0.3 m
    ],
)
def test_each_submap_is_compared_with_the_nearest_that_it_may_lie_on(
    seed: int,
    size: int,
    deviation: float,
    dimension: float,
    loops: tuple[tuple[int, int], ...],
    surely: float,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    graph, submaps = mapped(rounds(seed, 170), size, deviation)
    for i, j in loops:
        T = graph.pose(i).inverse() @ graph.pose(j)
        graph.add_edge(Edge(i, j, T, np.diag([surely, surely, 1e5]), EdgeKind.LOOP))
    config = replace(CONFIG, loop_search_space_dimension=dimension, loop_search_angle=0.031)
    told = Told()
    assert ended(work(monkeypatch, told, config), graph, submaps) == []
    expected = due(graph, submaps, config)
    assert told.pairs() == [entry[:2] for entry in expected]
    assert len(expected) > 5
    for (query, past, window), (_, _, half, angle) in zip(told.asked, expected, strict=True):
        assert (window.xy, window.theta) == pytest.approx((half, angle))
        prior = graph.pose(past).inverse() @ graph.pose(query)
        assert window.prior.array() == pytest.approx(prior.array())
        np.testing.assert_allclose(window.covariance, relative_covariances(graph, query)[past])


def out_and_back(deviation: float = 0.05, turns: int = 2) -> tuple[PoseGraph, list[Run]]:
    """Return a way of 3 m there and back, so often, in submaps of four keyframes."""
    one = [SE2(float(x), 0.3, 0.0) for x in range(4)]
    return mapped([*one, *one[::-1]] * turns, 4, deviation)


def test_a_piece_of_work_is_done_at_a_time(monkeypatch: pytest.MonkeyPatch) -> None:
    graph, submaps = out_and_back()
    told = Told()
    places = work(monkeypatch, told)
    assert places.step(graph, [], []) is None
    asked = []
    for _ in range(10):
        assert places.step(graph, submaps, []) == []
        asked.append(len(told.asked))
    # Three submaps are looked around; the third is compared with one in two pieces of work.
    assert asked == [0, 0, 0, 1, 1, 1, 2, 2, 3, 3]
    assert places.step(graph, submaps, []) is None
    assert told.pairs() == [(8, 0), (12, 0), (12, 4)]
    graph.poses[8:, 0] += 2.0
    assert places.step(graph, submaps, []) is None  # all was looked at
    places.restart()
    ended(places, graph, submaps)
    assert len(told.asked) == 6


def found(window: Search, off: float, *, sure: bool = True, area: float = 20.0) -> SubmapMatch:
    """Return a place so far beside where it was looked for [m]."""
    return SubmapMatch(SE2(0.0, off, 0.0) @ window.prior, GOOD, sure, NOWHERE, area)


@pytest.mark.parametrize(
    ("off", "moved", "again"),
    [(0.45, 1.5, False), (0.55, 0.45, False), (0.55, 0.55, True), (0.55, 1.5, True)],
)
def test_a_graph_that_was_bent_is_searched_where_it_was_not(
    off: float, moved: float, again: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Bent by 0.5 m; moved by as much as half of what the window reached."""
    graph, submaps = out_and_back()

    def answer(query: int, past: int, window: Search) -> SubmapMatch | None:
        return found(window, off) if (query, past) == (12, 4) else None

    told = Told(answer)
    places = work(monkeypatch, told)
    believed: list[Closure] = []
    while not believed:
        believed = places.step(graph, submaps, []) or []
    (closure,) = believed
    assert (closure.query, closure.past) == (3, 1)
    assert told.pairs() == [(8, 0), (12, 0), (12, 4)]
    reached = told.asked[1][2].xy
    graph.poses[12:, 1] += moved * reached
    assert ended(places, graph, submaps) == []
    assert told.pairs()[3:] == ([(12, 0)] if again else [])


@pytest.mark.parametrize(
    ("deviation", "off", "sure", "area", "weight", "enough", "wide"),
    [
        (0.02, 0.29, True, 12.0, 1.0, 0.5, True),
        (0.02, 0.31, True, 11.9, 1.0, 2.0, False),
        (0.02, 0.0, False, 20.0, 0.5, 0.5, False),
        (0.05, 0.0, True, 0.5, 1.0, 0.5, False),
        (0.50, 0.0, True, 20.0, 1.0, 2.0, True),  # room for another that looks the same
    ],
)
def test_what_a_place_counts_for(
    deviation: float,
    off: float,
    sure: bool,
    area: float,
    weight: float,
    enough: float,
    wide: bool,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    noted = Noted()
    monkeypatch.setattr(wide_loops, "Hypotheses", lambda: noted)
    graph, submaps = out_and_back(deviation)
    told = Told(lambda _q, _p, window: found(window, off, sure=sure, area=area))
    assert ended(work(monkeypatch, told), graph, submaps[:3]) == []
    ((_, _, window),) = told.asked
    assert (window.xy >= 1.6) is (deviation == 0.5)
    (closure,) = noted.added
    assert (closure.query, closure.past) == (2, 0)
    assert (closure.weight, closure.enough, closure.wide) == (weight, enough, wide)


def jacobian(parts: list[SE2], k: int) -> Floats:
    """Return the derivative of a chain by the values of one of its parts, `(3, 3) float64`."""

    def end(change: Floats) -> Floats:
        result = IDENTITY
        for n, part in enumerate(parts):
            result = result @ (SE2.from_array(part.array() + change) if n == k else part)
        return result.array()

    return np.column_stack([(end(d) - end(-d)) / 2e-6 for d in 1e-6 * np.eye(3)])


@pytest.mark.parametrize(
    ("holds", "i", "j"), [((0.1, 0.2), 0, 2), ((1.5, -0.8), 2, 0), ((1.0, 0.9), 1, 1)]
)
def test_the_edge_joins_the_keyframes_nearest_to_what_holds_the_place(
    holds: tuple[float, float], i: int, j: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    noted = Noted()
    monkeypatch.setattr(wide_loops, "Hypotheses", lambda: noted)
    graph, _ = out_and_back()
    T = SE2(2.1, 0.25, 2.7)  # the newer begins near the other end, facing back
    past, query = (Run(Field(0.05, 0.05)) for _ in range(2))
    past.nodes, query.nodes = [0, 1, 2], [8, 9, 10]
    past.poses = [SE2(), SE2(1.0, 0.8, 0.4), SE2(1.1, -0.9, -0.3)]
    query.poses = [SE2(), SE2(1.0, 0.1, -0.5), SE2(2.0, 0.2, 0.2)]
    past.bend, query.bend = (np.diag([s**2, s**2, t**2]) for s, t in ((0.1, 0.03), (0.07, 0.02)))
    covariance = np.array([[4.0, 1.0, 0.2], [1.0, 2.0, -0.1], [0.2, -0.1, 0.5]]) * 1e-3
    empty = Run(Field(0.05, 0.05), nodes=[4, 5], poses=[SE2(), SE2()])
    told = Told(lambda *_: SubmapMatch(T, covariance, True, np.array(holds), 0.0))
    ended(work(monkeypatch, told), graph, [past, empty, query])
    (edge,) = (closure.edge for closure in noted.added)
    assert (edge.i, edge.j, edge.kind) == (i, 8 + j, EdgeKind.LOOP)
    parts = [past.poses[i].inverse(), T, query.poses[j]]
    assert edge.T_i_j.array() == pytest.approx((parts[0] @ parts[1] @ parts[2]).array())
    knows = (past.bend, covariance, query.bend)
    slopes = [jacobian(parts, k) for k in range(3)]
    expected = sum(j @ c @ j.T for j, c in zip(slopes, knows, strict=True))
    np.testing.assert_allclose(np.linalg.inv(edge.information), expected, rtol=1e-5, atol=1e-9)
