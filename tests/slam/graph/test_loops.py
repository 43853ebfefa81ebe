"""Matches with past submaps: which become edges, at once or once others agree, and how sure."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pytest

from arjuna_core.arrays import Floats
from arjuna_core.se2 import IDENTITY, SE2
from arjuna_slam.config import SlamConfig
from arjuna_slam.graph import loops
from arjuna_slam.graph.candidates import LoopConfig, Search
from arjuna_slam.graph.hypotheses import Closure
from arjuna_slam.graph.loops import LoopCloser, doubted
from arjuna_slam.graph.pose_graph import Edge, EdgeKind, PoseGraph
from arjuna_slam.graph.submap import Submap
from arjuna_slam.graph.submap_match import SubmapMatch
from arjuna_slam.matching.correlative import Window
from arjuna_slam.matching.field import Field
from arjuna_slam.matching.scan_matcher import Match, MatcherConfig, MatchStatus, ScanMatcher
from arjuna_slam.matching.surface import extract
from tests.slam.graph.loop_scenes import (
    LAST,
    NOTHING,
    Scripted,
    ScriptedSubmaps,
    out_and_back,
    square,
    up_to,
)
from tests.slam.slam_room import ROOMS, scan_at

CONFIG = LoopConfig()
NOWHERE = np.zeros(2)
CERTAIN = np.diag([0.02**2, 0.03**2, 0.004**2])


def closer(matcher: Scripted, **values: Any) -> LoopCloser:
    return LoopCloser(replace(CONFIG, **values), matcher, 20.0)


def closed(matcher: Scripted, **values: Any) -> list[Edge]:
    graph, submaps = square()
    return closer(matcher, **values).close(graph, up_to(LAST), NOTHING, submaps)


def test_the_last_keyframe_is_matched_with_the_submap_of_the_first() -> None:
    graph, submaps = square()
    matcher = Scripted()
    (edge,) = closer(matcher).close(graph, up_to(LAST), NOTHING, submaps)
    ((reference, prior, window, least),) = matcher.asked
    assert reference is submaps[0].field
    assert prior.array() == pytest.approx((graph.pose(0).inverse() @ graph.pose(LAST)).array())
    assert least == CONFIG.loop_match_minimum_response_coarse
    assert (window.depth, window.distance_penalty) == (4, math.inf)
    assert (edge.i, edge.j, edge.kind) == (0, LAST, EdgeKind.LOOP)
    assert graph.residual(edge) == pytest.approx((0.0, 0.0, 0.0), abs=1e-9)
    assert closed(matcher, do_loop_closing=False) == []
    for dimension, depth in ((0.98, 2), (1.0, 4)):  # a narrow window has fewer levels
        narrow = Scripted()
        closed(narrow, loop_search_space_dimension=dimension)
        assert (narrow.asked[0][2].xy, narrow.asked[0][2].depth) == (0.5 * dimension, depth)


@pytest.mark.parametrize(
    ("matcher", "is_believed"),
    [
        (Scripted(), True),
        (Scripted(response=0.45), True),
        (Scripted(response=0.449), False),
        (Scripted(status=MatchStatus.LOW_RESPONSE), False),
        (Scripted(SE2(0.149, 0.0, 0.0)), True),
        (Scripted(SE2(0.151, 0.0, 0.0)), False),
        (Scripted(SE2(0.0, 0.0, 0.049)), True),
        (Scripted(SE2(0.0, 0.0, -0.051)), False),
        (Scripted(SE2(-2.0, 0.0, 0.0)), False),  # where the graph does not leave it open
    ],
)
def test_a_small_correction_needs_one_good_match(matcher: Scripted, is_believed: bool) -> None:
    assert len(closed(matcher)) == is_believed
    assert len(matcher.asked) == 1


OFF = SE2(0.3, 0.0, 0.0)


@pytest.mark.parametrize(
    ("second", "is_believed"),
    [(OFF, True), (SE2(0.33, 0.0, 0.0), True), (SE2(-0.3, 0.0, 0.0), False), (SE2(0.7), False)],
)
def test_a_large_correction_needs_another_keyframe(second: SE2, is_believed: bool) -> None:
    graph, submaps = square(0.04)
    matcher = Scripted(OFF)
    work = closer(matcher, loop_scan_window=2.0)
    assert work.close(graph, up_to(LAST)[:-1], NOTHING, submaps) == []
    matcher.off = second
    after = work.close(graph, up_to(LAST), NOTHING, submaps)
    assert sorted(edge.j for edge in after) == ([LAST - 1, LAST] if is_believed else [])


def test_a_failed_match_is_tried_again_only_further_on() -> None:
    graph, submaps = square()
    matcher = Scripted(response=0.1)
    work = closer(matcher)
    for travel, asked in ((79.0, 1), (79.4, 1), (79.5, 2), (79.9, 2)):
        work.close(graph, up_to(travel), NOTHING, submaps)
        assert len(matcher.asked) == asked
    same, gone = np.arange(LAST + 1), np.full(LAST + 1, -1)
    for travel, index, asked in ((80.0, same, 3), (80.1, same, 3), (80.2, gone, 4)):
        work.renumber(index)  # of the same keyframes it remembers
        work.close(graph, up_to(travel), NOTHING, submaps)
        assert len(matcher.asked) == asked


def test_a_keyframe_put_by_hand_is_matched_with_each_submap_near() -> None:
    graph, submaps = square()
    matcher = Scripted(SE2(0.1, 0.0, 0.0))
    put = SE2(9.5, 2.9, 0.0)  # beside the first side
    edge = closer(matcher).close_by_hand(graph, LAST, put, NOTHING, submaps)
    assert edge is not None
    assert (edge.j, edge.kind) == (LAST, EdgeKind.LOOP)
    assert [each[0] for each in matcher.asked] == [submaps[1].field, submaps[2].field]
    assert all(each[2] == Window(0.75, 0.35, 3) for each in matcher.asked)
    assert closer(matcher).close_by_hand(graph, 12, put, NOTHING, submaps[2:3]) is None  # its own
    assert closer(matcher).close_by_hand(graph, LAST, SE2(10, 3.01, 0), NOTHING, submaps) is None
    lost = Scripted(status=MatchStatus.LOW_RESPONSE)
    assert closer(lost).close_by_hand(graph, LAST, put, NOTHING, submaps) is None


@pytest.mark.parametrize(("responses", "best"), [((0.5, 0.9), 2), ((0.9, 0.5), 1), ((0.7, 0.7), 1)])
def test_of_submaps_near_a_keyframe_put_by_hand_the_best_is_taken(
    responses: tuple[float, float], best: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    graph, submaps = square()
    matcher, rest, scripted = Scripted(SE2(0.1)), list(responses), Scripted.match

    def match(*how: object) -> Match:
        matcher.response = rest.pop(0)
        return scripted(matcher, *how)  # type: ignore[arg-type]

    monkeypatch.setattr(matcher, "match", match)
    put = SE2(9.5, 2.9, 0.0)
    edge = closer(matcher).close_by_hand(graph, LAST, put, NOTHING, submaps)
    assert edge is not None
    assert rest == []
    assert edge.i in submaps[best].nodes


@pytest.mark.parametrize("angle", [0.0, 0.7, -1.2])
@pytest.mark.parametrize(("along", "claimed"), [(0.02, 0.02), (0.04, 0.1), (0.1, 1.5625)])
def test_weak_directions_are_doubted_alone(angle: float, along: float, claimed: float) -> None:
    """Below a tenth of the information across, by as much again: 0.1 wide^1.5 / narrow."""
    turn = SE2(0.0, 0.0, angle).matrix()
    covariance = turn @ np.diag([along**2, 0.008**2, 0.004**2]) @ turn.T
    result = turn.T @ doubted(covariance) @ turn
    assert math.sqrt(result[0, 0]) == pytest.approx(claimed)
    np.testing.assert_allclose(result[1:, 1:], np.diag([0.008**2, 0.004**2]), atol=1e-12)


@pytest.mark.parametrize(("heading", "known"), [(0.0, True), (0.1, False)])
def test_a_closure_with_a_torn_submap_is_as_uncertain(heading: float, known: bool) -> None:
    """Two keyframes 2 m apart in a corner, and a gap before the second."""
    submap, gap = Submap(SlamConfig().field()), np.diag([0.2**2, 0.2**2, heading**2])
    for node, x in enumerate((2.0, 4.0)):
        seen = extract(scan_at(ROOMS, SE2(x, 2.0, 0.0), beams=180), 20.0)
        submap.insert(node, seen, SE2(x - 2.0, 0.0, 0.0), gap if node else np.zeros((3, 3)))
    graph = PoseGraph()
    for x in (0.0, 2.0, 0.5):
        graph.add_node(SE2(x, 0.0, 0.0))
    surface = extract(scan_at(ROOMS, SE2(2.5, 2.0, 0.0)), 20.0)
    work = LoopCloser(SlamConfig(), ScanMatcher(SlamConfig()), 20.0)
    edge = work.close_by_hand(graph, 2, SE2(0.6, 0.1, 0.0), surface, [submap])
    assert edge is not None
    deviation = np.sqrt(np.linalg.inv(edge.information).diagonal())
    assert (deviation[2] < 0.01) == (deviation[0] < 0.05) == known


@dataclass
class Noted:
    """Hypotheses that believe nothing."""

    added: list[Closure] = field(default_factory=list)

    def add(self, _graph: PoseGraph, closure: Closure) -> list[Closure]:
        self.added.append(closure)
        return []


Work = Callable[[ScriptedSubmaps], LoopCloser]


@pytest.fixture
def noted(monkeypatch: pytest.MonkeyPatch) -> Noted:
    found = Noted()
    monkeypatch.setattr(loops, "Hypotheses", lambda **_: found)
    return found


@pytest.fixture
def work(monkeypatch: pytest.MonkeyPatch) -> Work:
    def made(scripted: ScriptedSubmaps) -> LoopCloser:
        monkeypatch.setattr(loops, "SubmapMatcher", lambda *_: scripted)
        return LoopCloser(CONFIG, ScanMatcher(MatcherConfig()), 20.0)

    return made


def ended(work: LoopCloser, graph: PoseGraph, submaps: list[Submap]) -> list[Closure]:
    """Return what is believed until there is nothing to do."""
    believed: list[Closure] = []
    while (found := work.step(graph, submaps, [])) is not None:
        believed += found
    return believed


def test_a_piece_of_work_is_done_at_a_time(work: Work) -> None:
    graph, submaps = out_and_back()
    scripted = ScriptedSubmaps()
    compared = work(scripted)
    assert compared.step(graph, [], []) is None
    asked = []
    for _ in range(10):
        assert compared.step(graph, submaps, []) == []
        asked.append(len(scripted.asked))
    # Three submaps are looked around; the third is compared with one in two pieces of work.
    assert asked == [0, 0, 0, 1, 1, 1, 2, 2, 3, 3]
    assert compared.step(graph, submaps, []) is None
    assert scripted.pairs() == [(8, 0), (12, 0), (12, 4)]
    graph.poses[8:, 0] += 2.0
    assert compared.step(graph, submaps, []) is None  # all was looked at
    compared.renumber(np.arange(len(graph)))
    ended(compared, graph, submaps)
    assert len(scripted.asked) == 6


def test_eight_submaps_are_compared_with_one_at_a_time(work: Work) -> None:
    scripted = ScriptedSubmaps()
    ended(work(scripted), *out_and_back(turns=6))
    queries = [query for query, _ in scripted.pairs()]
    assert max(queries.count(query) for query in queries) == 8


def found(window: Search, off: float, *, sure: bool = True, area: float = 20.0) -> SubmapMatch:
    """Return a match so far beside the prior [m]."""
    return SubmapMatch(SE2(0.0, off, 0.0) @ window.prior, CERTAIN, sure, NOWHERE, area)


@pytest.mark.parametrize(
    ("off", "moved", "again"),
    [(0.45, 1.5, False), (0.55, 0.45, False), (0.55, 0.55, True), (0.55, 1.5, True)],
)
def test_bent_graphs_are_searched_widely(off: float, moved: float, again: bool, work: Work) -> None:
    """Bent by 0.5 m; moved by as much as half of what the window reached."""
    graph, submaps = out_and_back()

    def answer(query: int, past: int, window: Search) -> SubmapMatch | None:
        return found(window, off) if (query, past) == (12, 4) else None

    scripted = ScriptedSubmaps(answer)
    compared = work(scripted)
    believed: list[Closure] = []
    while not believed:
        believed = compared.step(graph, submaps, []) or []
    (closure,) = believed
    assert (closure.query, closure.past) == (3, 1)
    assert scripted.pairs() == [(8, 0), (12, 0), (12, 4)]
    reached = scripted.asked[1][2].xy
    graph.poses[12:, 1] += moved * reached
    assert ended(compared, graph, submaps) == []
    assert scripted.pairs()[3:] == ([(12, 0)] if again else [])


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
def test_the_weight_of_a_match_of_submaps(
    deviation: float,
    off: float,
    sure: bool,
    area: float,
    weight: float,
    enough: float,
    wide: bool,
    noted: Noted,
    work: Work,
) -> None:
    graph, submaps = out_and_back(deviation)
    scripted = ScriptedSubmaps(lambda _q, _p, window: found(window, off, sure=sure, area=area))
    assert ended(work(scripted), graph, submaps[:3]) == []
    ((_, _, window),) = scripted.asked
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
def test_the_edge_joins_the_keyframes_nearest_to_what_holds_the_match(
    holds: tuple[float, float], i: int, j: int, noted: Noted, work: Work
) -> None:
    graph, _ = out_and_back()
    T = SE2(2.1, 0.25, 2.7)  # the newer begins near the other end, facing back
    past, query = (Submap(Field(0.05, 0.05)) for _ in range(2))
    past.nodes, query.nodes = [0, 1, 2], [8, 9, 10]
    past.poses = [SE2(), SE2(1.0, 0.8, 0.4), SE2(1.1, -0.9, -0.3)]
    query.poses = [SE2(), SE2(1.0, 0.1, -0.5), SE2(2.0, 0.2, 0.2)]
    past.bend, query.bend = (np.diag([s**2, s**2, t**2]) for s, t in ((0.1, 0.03), (0.07, 0.02)))
    covariance = np.array([[4.0, 1.0, 0.2], [1.0, 2.0, -0.1], [0.2, -0.1, 0.5]]) * 1e-3
    empty = Submap(Field(0.05, 0.05), nodes=[4, 5], poses=[SE2(), SE2()])
    scripted = ScriptedSubmaps(lambda *_: SubmapMatch(T, covariance, True, np.array(holds), 0.0))
    ended(work(scripted), graph, [past, empty, query])
    (edge,) = (closure.edge for closure in noted.added)
    assert (edge.i, edge.j, edge.kind) == (i, 8 + j, EdgeKind.LOOP)
    parts = [past.poses[i].inverse(), T, query.poses[j]]
    assert edge.T_i_j.array() == pytest.approx((parts[0] @ parts[1] @ parts[2]).array())
    knows = (past.bend, covariance, query.bend)
    slopes = [jacobian(parts, k) for k in range(3)]
    expected = sum(j @ c @ j.T for j, c in zip(slopes, knows, strict=True))
    np.testing.assert_allclose(np.linalg.inv(edge.information), expected, rtol=1e-5, atol=1e-9)
