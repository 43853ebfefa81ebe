"""Claims: a closure is not surer than what tells it from its neighbours; the nearest are tried."""

from __future__ import annotations

import math

import numpy as np
import pytest

from arjuna_core.se2 import SE2
from arjuna_slam.graph.loops import LoopCloser, LoopConfig, doubted
from arjuna_slam.matching.scan_matcher import Match
from tests.slam.graph.test_loop_closer import LAST, NOTHING, Told, closer, driven


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
