"""Every value of a session comes back from its file, each its own."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from arjuna_core.arrays import Floats
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_slam.graph.pose_graph import Edge, EdgeKind
from arjuna_slam.mapping.session import Session, SessionFileError, load_session, save_session

BEAMS = (5, 0, 3, 1)


def made_up(seed: int) -> Session:
    """Return a session of which no two values are the same."""
    rng = np.random.default_rng(seed)

    def pose() -> SE2:
        return SE2(*rng.normal(size=3).tolist())

    def scan(beams: int) -> Scan:
        ranges = rng.uniform(0.5, 9.0, beams).astype(np.float32).astype(np.float64)
        numbers = rng.uniform(0.1, 9.0, 6).tolist()
        return replace(Scan(ranges, *numbers), T_base_sensor=pose(), motion=pose())

    def information() -> Floats:
        root = rng.normal(size=(3, 3))
        return np.asarray(root @ root.T + np.eye(3), np.float64)

    kinds = (EdgeKind.LOOP, EdgeKind.ODOMETRY, EdgeKind.MATCH)
    edges = tuple(
        Edge(i, j, pose(), information(), kind)
        for (i, j), kind in zip(((3, 0), (0, 1), (2, 1)), kinds, strict=True)
    )
    scans = tuple(scan(count) for count in BEAMS)
    return Session(scans, rng.normal(size=(4, 3)), rng.random(4), edges, ((0, 2), (1,), (3, 0, 1)))


@pytest.mark.parametrize("odometry", [None, SE2(1.5, -2.0, 0.25)])
def test_every_value_comes_back(odometry: SE2 | None, tmp_path: Path) -> None:
    saved = replace(made_up(1), T_odom_base=odometry)
    save_session(tmp_path / "a.posegraph", saved)
    read = load_session(tmp_path / "a.posegraph")
    np.testing.assert_array_equal(read.poses, saved.poses)
    np.testing.assert_array_equal(read.travel, saved.travel)
    assert (read.submaps, read.T_odom_base) == (saved.submaps, saved.T_odom_base)
    for scan, known in zip(read.scans, saved.scans, strict=True):
        np.testing.assert_array_equal(scan.ranges, known.ranges)
        bare = np.zeros(0)
        assert repr(replace(scan, ranges=bare)) == repr(replace(known, ranges=bare))
    for edge, told in zip(read.edges, saved.edges, strict=True):
        assert (edge.i, edge.j, edge.T_i_j, edge.kind) == (told.i, told.j, told.T_i_j, told.kind)
        np.testing.assert_array_equal(edge.information, edge.information.T)
        np.testing.assert_allclose(edge.information, told.information, rtol=1e-12)


def with_edge(session: Session, edge: Edge) -> Session:
    return replace(session, edges=(*session.edges, edge))


EDGE = Edge(0, 3, SE2(), np.eye(3), EdgeKind.LOOP)
FAR = replace(made_up(1).scans[0], range_max=float("nan"))


@pytest.mark.parametrize(
    ("wrong", "problem"),
    [
        (with_edge(made_up(1), replace(EDGE, j=4)), r"edge_nodes.*a node is none of 0\.\.3"),
        (with_edge(made_up(1), replace(EDGE, i=3)), "an edge joins a node to itself"),
        (replace(made_up(1), submaps=((0, 4),)), r"submap_nodes.*a node is none of 0\.\.3"),
        (replace(made_up(1), submaps=((),)), "submap_sizes.*not as many as nodes"),
        (replace(made_up(1), travel=np.zeros(3)), "travel.*3 rows for 4 keyframes"),
        (replace(made_up(1), poses=np.full((4, 3), np.inf)), "poses.*a value is not finite"),
        (replace(made_up(1), scans=(FAR, *made_up(1).scans[1:])), "sweeps.*is not finite"),
        (Session((), np.zeros((0, 3)), np.zeros(0), (), ()), "poses.*no keyframe"),
    ],
)
def test_what_contradicts_itself_is_neither_written_nor_read(
    wrong: Session, problem: str, tmp_path: Path
) -> None:
    path = tmp_path / "a.posegraph"
    save_session(path, made_up(2))
    before = path.read_bytes()
    with pytest.raises(SessionFileError, match=problem):
        save_session(path, wrong)
    assert path.read_bytes() == before
    silent = replace(made_up(1).scans[0], ranges=np.array([np.inf, np.nan, 1.0, 2.0, 3.0]))
    save_session(path, replace(made_up(1), scans=(silent, *made_up(1).scans[1:])))
    np.testing.assert_array_equal(load_session(path).scans[0].ranges, silent.ranges)
