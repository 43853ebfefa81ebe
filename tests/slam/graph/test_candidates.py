"""Which past submaps a keyframe or a submap is compared with, and in which window."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from arjuna_core.se2 import SE2
from arjuna_slam.graph.candidates import LoopConfig, Search, near_keyframe, near_submap
from arjuna_slam.graph.pose_graph import Edge, EdgeKind, PoseGraph
from arjuna_slam.graph.submap import Submap
from arjuna_slam.graph.uncertainty import relative_covariances, spread
from tests.slam.graph.loop_scenes import LAST, mapped, square

CONFIG = LoopConfig()


def of_last(step: float = 1.0, **values: Any) -> list[tuple[int, Search]]:
    """Return the anchors that the last keyframe of a square is matched with, and each search."""
    graph, submaps = square()
    travel = (step * np.arange(LAST + 1.0)).tolist()
    config = replace(CONFIG, **values)
    found = near_keyframe(config, graph, LAST, travel, submaps)
    assert near_keyframe(config, graph, LAST, travel, []) == []
    return [(submap.anchor, search) for submap, search in found]


def test_a_keyframe_is_searched_as_wide_as_the_graph_leaves_it_open() -> None:
    graph, _ = square()
    ((anchor, search),) = of_last()
    assert anchor == 0
    prior = graph.pose(0).inverse() @ graph.pose(LAST)
    assert search.prior.array() == pytest.approx(prior.array())
    covariance = relative_covariances(graph, LAST)[0]
    np.testing.assert_allclose(search.covariance, covariance)
    xy, theta = spread(covariance)
    assert (search.xy, search.theta) == pytest.approx((0.3 + 3.0 * xy, 0.1 + 3.0 * theta))
    assert search.is_plausible(prior @ SE2(0.3))
    assert not search.is_plausible(prior @ SE2(2.5))
    ((_, narrow),) = of_last(loop_search_space_dimension=0.98, loop_search_angle=0.05)
    assert (narrow.xy, narrow.theta) == (0.49, 0.05)


@pytest.mark.parametrize(
    "values",
    [
        {"loop_search_maximum_distance": 0.0, "loop_scan_window": 0.6},  # a metre off
        {"loop_scan_window": 0.1},  # less than what the graph does not know
    ],
)
def test_a_keyframe_is_not_searched_where_it_cannot_be(values: dict[str, Any]) -> None:
    assert of_last(**values) == []


def test_the_two_nearest_submaps_are_tried_the_nearest_first() -> None:
    assert [anchor for anchor, _ in of_last(loop_search_maximum_distance=12.0)] == [0, 5]


@pytest.mark.parametrize(("step", "is_tried"), [(0.79, False), (0.85, True)])
def test_what_was_left_less_than_eight_metres_ago_is_not_tried(step: float, is_tried: bool) -> None:
    """The nearest keyframe of the submap is ten steps back."""
    graph, submaps = square()
    travel = (step * np.arange(LAST + 1.0)).tolist()
    config = replace(CONFIG, loop_search_maximum_distance=12.0)
    assert bool(near_keyframe(config, graph, LAST, travel, submaps[13:14])) is is_tried


@pytest.mark.parametrize("frame", [SE2(30.0, -20.0, 0.7), SE2(-5.0, 60.0, -2.0)])
def test_the_frame_of_the_map_changes_nothing(frame: SE2) -> None:
    graph, submaps = square()
    graph.poses = np.array([(frame @ graph.pose(k)).array() for k in range(len(graph))])
    ((_, search),) = near_keyframe(CONFIG, graph, LAST, list(range(LAST + 1)), submaps)
    ((_, expected),) = of_last()
    assert search.prior.array() == pytest.approx(expected.prior.array())
    assert search.xy == pytest.approx(expected.xy)


def rounds(seed: int, count: int) -> list[SE2]:
    """Return a path of half metres round and round a hall of 12 by 7 m, never quite the same."""
    rng, path = np.random.default_rng(seed), []
    for k in range(count):
        at = (0.5 * k) % 38.0
        x = min(at, 12.0) - min(max(at - 19.0, 0.0), 12.0)
        y = min(max(at - 12.0, 0.0), 7.0) - max(at - 31.0, 0.0)
        off = rng.uniform(-0.4, 0.4, 3).tolist()
        path.append(SE2(x + off[0], y + off[1], off[2]))
    return path


def expected_of(
    graph: PoseGraph, submaps: list[Submap], q: int, config: LoopConfig
) -> list[tuple[float, int, float, float]]:
    """Return gap, number, half the window and angle of each submap that one may lie on."""
    query, found = submaps[q], []
    loops = [(edge.i, edge.j) for edge in graph.edges if edge.kind is EdgeKind.LOOP]
    for k, past in enumerate(submaps[: max(q - 1, 0)]):
        xy, theta = spread(relative_covariances(graph, query.anchor)[past.anchor])
        gap = min(
            graph.pose(a).distance(graph.pose(b))
            for a in query.nodes[:: max(1, len(query.nodes) // 6)]
            for b in past.nodes
        )
        ends = (set(query.nodes), set(past.nodes))
        joined = any((i in a and j in b) for i, j in loops for a, b in (ends, ends[::-1]))
        half = min(0.2 + 3.0 * xy, 0.5 * config.loop_search_space_dimension)
        angle = min(0.03 + 3.0 * theta, config.loop_search_angle)
        if gap < 3.0 + half and not (joined and xy < 0.3):
            found.append((gap, k, half, angle))
    return sorted(found)


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
def test_a_submap_is_compared_with_those_that_it_may_lie_on_the_nearest_first(
    seed: int,
    size: int,
    deviation: float,
    dimension: float,
    loops: tuple[tuple[int, int], ...],
    surely: float,
) -> None:
    graph, submaps = mapped(rounds(seed, 170), size, deviation)
    for i, j in loops:
        T = graph.pose(i).inverse() @ graph.pose(j)
        graph.add_edge(Edge(i, j, T, np.diag([surely, surely, 1e5]), EdgeKind.LOOP))
    config = replace(CONFIG, loop_search_space_dimension=dimension, loop_search_angle=0.031)
    for q, query in enumerate(submaps):
        found = near_submap(config, graph, q, submaps)
        known = [(gap, past, search.xy, search.theta) for gap, past, search in found]
        expected = expected_of(graph, list(submaps), q, config)
        assert [past for _, past, _, _ in known] == [past for _, past, _, _ in expected]
        np.testing.assert_allclose(known, expected)
        for _, past, search in found:
            anchor = submaps[past].anchor
            prior = graph.pose(anchor).inverse() @ graph.pose(query.anchor)
            assert search.prior.array() == pytest.approx(prior.array())
            known_by = relative_covariances(graph, query.anchor)[anchor]
            np.testing.assert_allclose(search.covariance, known_by)


def test_a_submap_is_not_compared_with_one_that_shares_a_keyframe() -> None:
    graph, submaps = mapped(rounds(0, 170), 8, 0.02)
    last = len(submaps) - 1
    nearest = near_submap(CONFIG, graph, last, submaps)[0][1]
    submaps[nearest].nodes.append(submaps[last].nodes[0])  # as after a leap of the odometry
    assert nearest not in [past for _, past, _ in near_submap(CONFIG, graph, last, submaps)]


PRIOR = SE2(4.0, -3.0, 1.0)


def search(xy: float, theta: float = 0.3) -> Search:
    return Search(PRIOR, np.eye(3), xy, theta)


@pytest.mark.parametrize(("xy", "reaches"), [(0.75, False), (0.85, True)])
@pytest.mark.parametrize("off", [(0.3, 0.0), (-0.3, 0.0), (0.0, 0.3), (0.0, -0.3)])
def test_other_poses_lie_near_the_best(xy: float, reaches: bool, off: tuple[float, float]) -> None:
    assert search(xy).reaches_beside(PRIOR) is reaches
    best = SE2(PRIOR.x + off[0], PRIOR.y + off[1], PRIOR.theta)
    assert search(xy - 0.3).reaches_beside(best) is reaches
    assert search(2.0 * xy).ambiguous is reaches  # room for two that are apart


@pytest.mark.parametrize(
    ("xy", "theta", "count"),
    [(0.2, 0.05, 1), (1.0, 0.3, 1), (2.0, 0.5, 2), (3.0, 0.39, 3), (10.0, 0.295, 10)],
)
def test_pieces_cover_the_window_from_the_middle(xy: float, theta: float, count: int) -> None:
    pieces = search(xy, theta).pieces(0.05)
    assert len(pieces) == count
    assert all((middle.x, middle.y) == (PRIOR.x, PRIOR.y) for middle, _ in pieces)
    assert all(window.xy == xy for _, window in pieces)
    off = [middle.theta - PRIOR.theta for middle, _ in pieces]
    assert np.all(np.diff(np.abs(off)) > -1e-9)
    edges = sorted(
        (turn - window.theta, turn + window.theta)
        for turn, (_, window) in zip(off, pieces, strict=True)
    )
    assert (edges[0][0], edges[-1][1]) == pytest.approx((-theta, theta))
    assert [low for low, _ in edges[1:]] == pytest.approx([high for _, high in edges[:-1]])


@pytest.mark.parametrize(
    ("xy", "resolution", "depth"),
    [
        (0.01, 0.1, 2),
        (0.39, 0.05, 2),
        (0.41, 0.05, 3),
        (1.59, 0.1, 3),
        (1.61, 0.05, 5),
        (9, 0.05, 5),
    ],
)
def test_blocks_of_a_search_fit_the_window(xy: float, resolution: float, depth: int) -> None:
    assert {window.depth for _, window in search(xy).pieces(resolution)} == {depth}
