"""Claims: a closure is not surer than what tells it from its neighbours; the nearest are tried."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pytest

from arjuna_core.arrays import Floats
from arjuna_core.se2 import IDENTITY, SE2
from arjuna_slam.graph.loops import LoopCloser, LoopConfig, doubted
from arjuna_slam.graph.pose_graph import Edge, EdgeKind, PoseGraph
from arjuna_slam.mapping.submap import Submap
from arjuna_slam.matching.correlative import Window
from arjuna_slam.matching.field import Field
from arjuna_slam.matching.scan_matcher import Match, MatchStatus, ScanMatcher
from arjuna_slam.matching.surface import Surface

NOTHING = Surface(np.zeros((0, 2)), np.zeros((0, 2)), np.zeros(0, np.bool_))
GOOD = np.diag([0.01**2, 0.01**2, 0.005**2])
SIDE = 20  # keyframes of a side of the square that is driven, a metre apart


@dataclass
class Told(ScanMatcher):
    """A matcher that finds something off where it is looked for, and keeps where that was."""

    off: SE2 = IDENTITY
    response: float = 0.9
    status: MatchStatus = MatchStatus.MATCHED
    known: Floats = field(default_factory=GOOD.copy)
    asked: list[tuple[Field, SE2, Window, float]] = field(default_factory=list)

    def match(
        self,
        field: Field,
        surface: Surface,
        prior: SE2,
        window: Window,
        least: float,
        information: Floats = GOOD,
    ) -> Match:
        self.asked.append((field, prior, window, least))
        return Match(self.status, prior @ self.off, self.known, self.response)


def driven(deviation: float = 0.02) -> tuple[PoseGraph, list[Submap]]:
    """Return a graph of a square that ends beside its start, and submaps of five keyframes."""
    graph = PoseGraph()
    pose, step = SE2(), np.diag([deviation**-2, deviation**-2, 1e6])
    for k in range(4 * SIDE):
        graph.add_node(pose)
        turn = math.pi / 2 if k % SIDE == SIDE - 1 else 0.0
        moved = SE2(1.0, 0.0, turn)
        if k:
            last = graph.pose(k - 1).inverse() @ graph.pose(k)
            graph.add_edge(Edge(k - 1, k, last, step, EdgeKind.MATCH))
        pose = pose @ moved
    submaps = []
    for first in range(0, 4 * SIDE - 5, 5):
        submap = Submap(Field(0.05, 0.05))
        submap.nodes.extend(range(first, first + 5))
        submap.poses.extend(graph.pose(first).inverse() @ graph.pose(n) for n in submap.nodes)
        submaps.append(submap)
    return graph, submaps


def closer(matcher: Told, count: int = 4 * SIDE - 1, **told: Any) -> LoopCloser:
    """Return a closer that knows how far the keyframes before the last are along the way."""
    result = LoopCloser(replace(LoopConfig(), **told), matcher)
    result.resume(np.arange(count, dtype=np.float64))
    return result


LAST = 4 * SIDE - 1


def closed(matcher: Told, deviation: float = 0.02, **told: Any) -> list[Edge]:
    graph, submaps = driven(deviation)
    found = closer(matcher, **told).close(graph, LAST, float(LAST), NOTHING, submaps)
    assert LAST not in {node for submap in submaps for node in submap.nodes}
    return found


def test_the_last_keyframe_is_matched_with_the_submap_of_the_first() -> None:
    graph, submaps = driven()
    matcher = Told()
    (edge,) = closer(matcher).close(graph, LAST, float(LAST), NOTHING, submaps)
    ((reference, prior, window, least),) = matcher.asked
    assert reference is submaps[0].field
    assert prior.array() == pytest.approx((graph.pose(0).inverse() @ graph.pose(LAST)).array())
    assert least == LoopConfig().loop_match_minimum_response_coarse
    assert (edge.i, edge.j, edge.kind) == (0, LAST, EdgeKind.LOOP)
    assert graph.residual(edge) == pytest.approx((0.0, 0.0, 0.0), abs=1e-9)
    # Half a window: 0.3 m and three deviations of 79 steps of 0.02 m, and the turns' over the way.
    assert 0.3 + 3.0 * 0.02 * math.sqrt(79) < window.xy < 0.3 + 1.0
    assert 0.1 + 3.0 * 1e-3 * math.sqrt(79) < window.theta < 0.15
    assert window.depth == 4
    assert matcher.asked[0][2].distance_penalty == math.inf


@pytest.mark.parametrize(
    "told",
    [
        {"do_loop_closing": False},
        {"loop_search_maximum_distance": 0.0, "loop_scan_window": 0.6},  # a metre off
        {"loop_scan_window": 0.1},  # less than what the graph does not know
    ],
)
def test_where_it_cannot_be_it_is_not_matched(told: dict[str, Any]) -> None:
    matcher = Told()
    assert closed(matcher, **told) == []
    assert matcher.asked == []


def test_a_narrow_window_is_searched_in_fewer_levels() -> None:
    matcher = Told()
    closed(matcher, loop_search_space_dimension=0.98, loop_search_angle=0.05)
    window = matcher.asked[0][2]
    assert (window.xy, window.theta, window.depth) == (0.49, 0.05, 2)
    matcher = Told()
    closed(matcher, loop_search_space_dimension=1.0)
    assert (matcher.asked[0][2].xy, matcher.asked[0][2].depth) == (0.5, 4)


@pytest.mark.parametrize(
    ("matcher", "is_believed"),
    [
        (Told(), True),
        (Told(response=0.45), True),
        (Told(response=0.449), False),
        (Told(status=MatchStatus.LOW_RESPONSE), False),
        (Told(SE2(0.149, 0.0, 0.0)), True),
        (Told(SE2(0.151, 0.0, 0.0)), False),
        (Told(SE2(0.0, 0.0, 0.049)), True),
        (Told(SE2(0.0, 0.0, -0.051)), False),
    ],
)
def test_a_small_correction_is_believed_of_one_good_match(matcher: Told, is_believed: bool) -> None:
    assert len(closed(matcher)) == is_believed
    assert len(matcher.asked) == 1


def again(
    first: SE2, second: SE2, apart: float = 1.0, **told: Any
) -> tuple[list[Edge], list[Edge]]:
    """Return what is believed of two keyframes in a row that are found off where they should be."""
    graph, submaps = driven(0.04)
    matcher = Told(first)
    with_config = closer(matcher, LAST - 1, loop_scan_window=2.0, **told)
    before = with_config.close(graph, LAST - 1, LAST - 1.0, NOTHING, submaps)
    matcher.off = second
    return before, with_config.close(graph, LAST, LAST - 1.0 + apart, NOTHING, submaps)


OFF = SE2(0.3, 0.0, 0.0)


@pytest.mark.parametrize(
    ("second", "apart", "is_believed"),
    [
        (OFF, 1.0, True),
        (OFF, 1.99, True),
        (OFF, 2.0, False),  # too long ago
        (SE2(0.39, 0.0, 0.0), 1.0, True),
        (SE2(0.41, 0.0, 0.0), 1.0, False),
        (SE2(0.3, 0.0, 0.002), 1.0, True),
    ],
)
def test_a_great_correction_needs_another_that_agrees(
    second: SE2, apart: float, is_believed: bool
) -> None:
    before, after = again(OFF, second, apart)
    assert before == []
    assert [edge.j for edge in after] == ([LAST - 1, LAST] if is_believed else [])


def test_a_failed_match_is_tried_again_only_further_on() -> None:
    graph, submaps = driven()
    matcher = Told(response=0.1)
    work = closer(matcher)
    for travel, asked in ((79.0, 1), (79.4, 1), (79.5, 2), (79.9, 2)):
        work.close(graph, LAST, travel, NOTHING, submaps)
        assert len(matcher.asked) == asked
    assert work.travel[-4:] == (79.0, 79.4, 79.5, 79.9)
    index = np.arange(4 * SIDE + 4)
    work.resume(np.arange(float(LAST)), index)  # the same keyframes: it remembers
    work.close(graph, LAST, 80.0, NOTHING, submaps)
    assert len(matcher.asked) == 3
    work.resume(np.arange(float(LAST)), index)
    work.close(graph, LAST, 80.1, NOTHING, submaps)
    assert len(matcher.asked) == 3
    work.resume(np.arange(float(LAST)))  # others: it does not
    work.close(graph, LAST, 80.2, NOTHING, submaps)
    assert len(matcher.asked) == 4


def test_a_keyframe_put_by_hand_is_matched_with_each_submap_near() -> None:
    graph, submaps = driven()
    matcher = Told(SE2(0.1, 0.0, 0.0))
    put = SE2(9.5, 2.9, 0.0)  # beside the first side
    edge = closer(matcher).close_by_hand(graph, LAST, put, NOTHING, submaps)
    assert edge is not None
    assert (edge.j, edge.kind) == (LAST, EdgeKind.LOOP)
    assert [each[0] for each in matcher.asked] == [submaps[1].field, submaps[2].field]
    assert all(each[2] == Window(0.75, 0.35, 3) for each in matcher.asked)
    assert closer(matcher).close_by_hand(graph, 12, put, NOTHING, submaps[2:3]) is None  # its own
    assert closer(matcher).close_by_hand(graph, LAST, SE2(10, 3.01, 0), NOTHING, submaps) is None
    lost = Told(status=MatchStatus.LOW_RESPONSE)
    assert closer(lost).close_by_hand(graph, LAST, put, NOTHING, submaps) is None


@pytest.mark.parametrize("angle", [0.0, 0.7, -1.2])
@pytest.mark.parametrize(("along", "claimed"), [(0.02, 0.02), (0.04, 0.1), (0.1, 1.5625)])
def test_what_is_hardly_seen_is_doubted_along_its_direction_alone(
    angle: float, along: float, claimed: float
) -> None:
    """Below a tenth of the information across, by as much again: 0.1 wide^1.5 / narrow."""
    turn = SE2(0.0, 0.0, angle).matrix()
    covariance = turn @ np.diag([along**2, 0.008**2, 0.004**2]) @ turn.T
    result = turn.T @ doubted(covariance) @ turn
    assert math.sqrt(result[0, 0]) == pytest.approx(claimed)
    np.testing.assert_allclose(result[1:, 1:], np.diag([0.008**2, 0.004**2]), atol=1e-12)


def test_the_two_nearest_submaps_are_tried_the_nearest_first() -> None:
    graph, submaps = driven()
    matcher = Told()
    work = closer(matcher, loop_search_maximum_distance=12.0)
    edges = work.close(graph, LAST, float(LAST), NOTHING, submaps[::-1])
    assert [each[0] for each in matcher.asked] == [submaps[0].field, submaps[1].field]
    assert [edge.i for edge in edges] == [0, 5]
    assert work.close(graph, LAST, LAST + 1.0, NOTHING, []) == []


@pytest.mark.parametrize(("step", "is_tried"), [(0.79, False), (0.85, True)])
def test_what_was_left_less_than_eight_metres_ago_is_not_tried(step: float, is_tried: bool) -> None:
    """The nearest keyframe of the submap is ten steps back."""
    graph, submaps = driven()
    matcher = Told()
    work = LoopCloser(LoopConfig(loop_search_maximum_distance=12.0), matcher)
    work.resume(np.arange(LAST, dtype=np.float64) * step)
    work.close(graph, LAST, step * LAST, NOTHING, submaps[13:14])
    assert bool(matcher.asked) is is_tried


@pytest.mark.parametrize("frame", [SE2(30.0, -20.0, 0.7), SE2(-5.0, 60.0, -2.0)])
def test_where_the_map_s_frame_lies_changes_nothing(frame: SE2) -> None:
    graph, submaps = driven()
    here, there = Told(), Told()
    (edge,) = closer(here).close(graph, LAST, float(LAST), NOTHING, submaps)
    graph.poses = np.array([(frame @ graph.pose(k)).array() for k in range(len(graph))])
    (moved,) = closer(there).close(graph, LAST, float(LAST), NOTHING, submaps)
    assert (moved.i, moved.j) == (edge.i, edge.j)
    assert moved.T_i_j.array() == pytest.approx(edge.T_i_j.array())
    assert there.asked[0][2].xy == pytest.approx(here.asked[0][2].xy)


@pytest.mark.parametrize(("responses", "best"), [((0.5, 0.9), 2), ((0.9, 0.5), 1), ((0.7, 0.7), 1)])
def test_of_submaps_near_a_keyframe_put_by_hand_the_best_is_taken(
    responses: tuple[float, float], best: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    graph, submaps = driven()
    matcher, left, told = Told(SE2(0.1)), list(responses), Told.match

    def match(*how: object) -> Match:
        matcher.response = left.pop(0)
        return told(matcher, *how)  # type: ignore[arg-type]

    monkeypatch.setattr(matcher, "match", match)
    put = SE2(9.5, 2.9, 0.0)
    edge = closer(matcher).close_by_hand(graph, LAST, put, NOTHING, submaps)
    assert edge is not None
    assert left == []
    assert edge.i in submaps[best].nodes
