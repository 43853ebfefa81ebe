"""Scans are traced again where poses have moved by what would mark other cells."""

from __future__ import annotations

import math

import numpy as np
import pytest

from arjuna_core.arrays import Bools, Floats
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_slam.graph.pose_graph import Edge, EdgeKind
from arjuna_slam.mapping.keyframes import (
    Keyframes,
    LifelongConfig,
    forget_submap,
    is_redundant,
    prune,
)
from arjuna_slam.mapping.session import Session

CELL = 0.05


def mapped(count: int = 1) -> tuple[Keyframes, Floats]:
    """Return keyframes of a round room that are in the map, and a view of their poses."""
    drawn = Keyframes(CELL, 10.0)
    for k in range(count):
        ranges = np.full(90, 2.0)
        drawn.add(Scan(ranges, -math.pi, math.radians(4.0), 0.1, 10.0, float(k)), SE2())
    drawn.map()
    return drawn, drawn.graph.poses


@pytest.mark.parametrize(
    ("moved", "is_traced"),
    [
        ((0.4 * CELL, 0.0, 0.0), False),
        ((0.0, -0.6 * CELL, 0.0), True),
        ((0.4 * CELL, 0.4 * CELL, 0.0), True),
        ((0.0, 0.0, 0.004), False),
        ((0.0, 0.0, -0.006), True),
        ((0.0, 0.0, math.tau - 0.004), False),
    ],
)
def test_moved_poses_are_traced_again(moved: tuple[float, float, float], is_traced: bool) -> None:
    drawn, poses = mapped()
    assert not drawn.map_behind
    poses += np.array(moved)
    assert drawn.map_behind is is_traced


def test_what_moved_farthest_is_traced_first() -> None:
    drawn, poses = mapped(3)
    poses[:, 0] = (0.2, 0.5, 0.3)
    for first in (1, 2, 0):
        drawn.map(most_moved=1)
        poses[first, 0] = 0.0  # put back, it is behind again: it was drawn where it had moved
        assert drawn.map_behind
        poses[first, 0] = (0.2, 0.5, 0.3)[first]
    assert not drawn.map_behind
    fresh = Keyframes(CELL, 10.0)
    for scan, pose in zip(drawn.scans, poses, strict=True):
        fresh.add(scan, SE2.from_array(pose))
    again, anew = drawn.map(), fresh.map()
    assert again is not None
    assert anew is not None
    cells = np.argwhere(anew.data >= 0)
    where = [again.frame.to_cell(*anew.frame.to_point(*cell)) for cell in cells.tolist()]
    assert [again.data[cell] for cell in where] == anew.data[anew.data >= 0].tolist()
    assert (again.data >= 0).sum() == len(cells), "nothing is left where they were"


def test_a_new_scan_is_behind() -> None:
    drawn, _ = mapped()
    drawn.add(drawn.scans[0], SE2())
    assert drawn.map_behind
    assert Keyframes(CELL, 10.0).map() is None


@pytest.mark.parametrize(("clear", "known_beyond"), [(True, True), (False, False)])
def test_beams_without_a_return_may_clear_cells(clear: bool, known_beyond: bool) -> None:
    """A half circle of walls at 2 m, nothing behind; 4 m is read, but beyond the longest range."""
    ranges = np.where(np.arange(90) < 45, 2.0, np.inf)
    ranges[60] = 4.0
    drawn = Keyframes(CELL, 3.0, clear_without_return=clear)
    for _ in range(3):
        drawn.add(Scan(ranges, -math.pi, math.radians(4.0), 0.1, 10.0), SE2())
    grid = drawn.map()
    assert grid is not None

    def value(beam: int, distance: float) -> int:
        angle = -math.pi + math.radians(4.0) * beam
        cell = grid.frame.to_cell(distance * math.cos(angle), distance * math.sin(angle))
        return int(grid.data[cell]) if grid.frame.contains(*cell) else -1

    assert value(20, 1.5) == value(60, 2.5) == 0
    assert (value(75, 2.5) == 0) is known_beyond
    assert value(75, 2.5) in (0, -1)


ODOMETRY, MATCH, LOOP = EdgeKind.ODOMETRY, EdgeKind.MATCH, EdgeKind.LOOP


def session(
    count: int,
    loops: tuple[tuple[int, int], ...] = (),
    submaps: tuple[tuple[int, ...], ...] = ((0,),),
) -> Session:
    """Return a session whose measurements are what the poses say, each of its own information."""
    rng = np.random.default_rng(count)
    poses = np.column_stack((rng.normal(size=(count, 2)), rng.uniform(-3.0, 3.0, count)))
    scans = tuple(Scan(np.ones(3), 0.0, 0.1, 0.1, 9.0, float(k)) for k in range(count))
    pairs = [(k, k + 1, MATCH if k % 2 else ODOMETRY) for k in range(count - 1)]
    edges = tuple(
        Edge(i, j, between(poses, i, j), (1.0 + n) * np.eye(3), kind)
        for n, (i, j, kind) in enumerate([*pairs, *((i, j, LOOP) for i, j in loops)])
    )
    travel: Floats = 0.5 * np.arange(float(count))
    return Session(scans, poses, travel, edges, submaps)


def between(poses: Floats, i: int, j: int) -> SE2:
    return SE2.from_array(poses[i]).inverse() @ SE2.from_array(poses[j])


def kept(count: int, *gone: int) -> Bools:
    return ~np.isin(np.arange(count), gone)


def ends(edges: tuple[Edge, ...]) -> list[tuple[int, int, EdgeKind, float]]:
    return [(e.i, e.j, e.kind, float(e.information[0, 0])) for e in edges]


def test_keyframes_that_stay_are_numbered_again_and_keep_what_is_theirs() -> None:
    whole = session(6, submaps=((0, 1, 2), (2, 3, 4), (4, 5)))
    pruned, index = prune(whole, kept(6, 1, 2))
    assert index.tolist() == [0, -1, -1, 1, 2, 3]
    assert [scan.stamp for scan in pruned.scans] == [0.0, 3.0, 4.0, 5.0]
    np.testing.assert_array_equal(pruned.poses, whole.poses[[0, 3, 4, 5]])
    np.testing.assert_array_equal(pruned.travel, [0.0, 1.5, 2.0, 2.5])
    assert pruned.submaps == ((0,), (2, 3))  # that of an anchor that goes, goes
    assert pruned.T_odom_base is None


def test_a_gap_is_bridged_as_the_graph_has_it_and_nothing_else_is() -> None:
    pruned, _ = prune(session(6), kept(6, 1, 2))
    bridge = 1.0 / 0.02**2
    assert ends(pruned.edges) == [
        *((1, 2, MATCH, 4.0), (2, 3, ODOMETRY, 5.0), (0, 1, MATCH, pytest.approx(bridge)))
    ]
    assert np.diag(pruned.edges[-1].information) == pytest.approx([bridge, bridge, 1e4])
    whole, index = prune(session(4), kept(4))
    assert ends(whole.edges) == ends(session(4).edges)
    assert index.tolist() == [0, 1, 2, 3]


@pytest.mark.parametrize(
    ("loop", "gone", "expected"),
    [
        ((0, 5), (1,), (0, 4, 4.0 + 2.0)),  # both ends stay
        ((1, 5), (1,), (0, 4, 0.5 * 6.0)),  # of two as near in time the older
        ((2, 5), (1, 2), (1, 3, 0.5 * 6.0)),
        ((0, 4), (4,), (0, 3, 0.5 * 6.0)),
        ((3, 4), (3, 4), (2, 3, 0.5 * 6.0)),
        ((1, 2), (1, 2, 3), None),  # both would end at the same
    ],
)
def test_a_loop_moves_to_the_keyframes_beside_it_with_half_its_information(
    loop: tuple[int, int], gone: tuple[int, ...], expected: tuple[int, int, float] | None
) -> None:
    pruned, _ = prune(session(6, (loop,)), kept(6, *gone))
    found = [(i, j, information) for i, j, kind, information in ends(pruned.edges) if kind is LOOP]
    assert found == ([] if expected is None or expected[0] == expected[1] else [expected])


@pytest.mark.parametrize("seed", range(4))
def test_all_that_is_measured_still_agrees_with_the_poses(seed: int) -> None:
    rng = np.random.default_rng(seed)
    loops = tuple((int(i), int(i) + int(n)) for i, n in rng.integers(2, 8, (6, 2)))
    keep = rng.random(16) > 0.4
    keep[0] = True
    pruned, index = prune(session(16, loops), keep)
    assert len(pruned.poses) == keep.sum() == index.max() + 1
    chained = {(e.i, e.j) for e in pruned.edges if e.j == e.i + 1 and e.kind is not LOOP}
    assert chained == {(k, k + 1) for k in range(len(pruned.poses) - 1)}
    for edge in pruned.edges:
        off = edge.T_i_j.inverse() @ between(pruned.poses, edge.i, edge.j)
        assert off.array() == pytest.approx((0.0, 0.0, 0.0), abs=1e-9)


ROW = np.array([(x, 0.0, 0.0) for x in (0.0, 1.0, 2.0, 3.0, 0.2, 1.2, 2.2)])


@pytest.mark.parametrize(
    ("distance", "share", "nodes", "is_covered"),
    [
        (0.3, 1.0, (0, 1, 2), True),
        (0.3, 1.0, (0, 1, 2, 3), False),  # one of four is 0.8 m from the next
        (0.3, 0.75, (3, 2, 1, 0), True),  # as many as there must be, in any order
        (0.3, 0.76, (0, 1, 2, 3), False),
        (0.1, 0.5, (0, 1, 2), False),
        (0.81, 1.0, (0, 1, 2, 3), True),
        (9.0, 0.0, (5, 6), False),  # nothing is newer
        (1.1, 1.0, (4, 5), False),  # what is newer counts alone
    ],
)
def test_newer_keyframes_cover_what_they_are_near_to(
    distance: float, share: float, nodes: tuple[int, ...], is_covered: bool
) -> None:
    config = LifelongConfig(lifelong_cover_distance=distance, lifelong_cover_share=share)
    assert is_redundant(config, ROW, nodes) is is_covered


def test_covered_means_nearer_than_the_distance() -> None:
    poses = np.array([[0.0, 0.0, 0.0], [0.0, 0.5, math.pi]])
    just, more = (LifelongConfig(lifelong_cover_distance=d) for d in (0.5, 0.5001))
    assert not is_redundant(just, poses, (0,))
    assert is_redundant(more, poses, (0,))


def test_a_covered_submap_goes_with_the_keyframes_that_only_it_has() -> None:
    whole = session(7, submaps=((0, 1, 2), (2, 3), (4, 5, 6)))
    whole = Session(whole.scans, ROW, whole.travel, whole.edges, whole.submaps)
    config = LifelongConfig(lifelong_cover_distance=0.3)
    found = forget_submap(config, whole, 0)
    assert found is not None
    pruned, index = found
    assert index.tolist() == [-1, -1, 0, 1, 2, 3, 4]
    assert pruned.submaps == ((0, 1), (2, 3, 4))
    assert forget_submap(config, whole, 1) is None  # 0.8 m from what is newer
    assert forget_submap(config, whole, 2) is None
