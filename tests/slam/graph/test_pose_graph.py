"""The pose graph, its files and rival closures."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from arjuna_core.arrays import Floats
from arjuna_core.errors import InputFileError
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_slam.graph.optimizer import optimize
from arjuna_slam.graph.pose_graph import Edge, EdgeKind, PoseGraph
from arjuna_slam.graph.rivals import SeenField
from arjuna_slam.matching.contradiction import gone_through
from arjuna_slam.matching.field import Field
from tests.helpers.posegraph import read_graph


def random_graph(seed: int, count: int = 12, loops: int = 6) -> PoseGraph:
    """Return a wandering chain with noisy measurements and loops, some of them wrong."""
    rng = np.random.default_rng(seed)
    graph, true = PoseGraph(), [SE2()]
    for k in range(count):
        if k:
            true.append(true[-1] @ SE2(*rng.normal((1.0, 0.0, 0.3), (0.2, 0.2, 0.5)).tolist()))
        graph.add_node(true[-1] @ SE2(*(rng.normal(0.0, 0.1, 3) * (k > 0)).tolist()))
    chain = [(k, k + 1) for k in range(count - 1)]
    closed = [tuple(sorted(rng.choice(count, 2, replace=False).tolist())) for _ in range(loops)]
    for n, (i, j) in enumerate([*chain, *closed]):
        root = rng.normal(0.0, 3.0, (3, 3))
        noise = rng.normal(0.0, 0.05 if n % 4 else 0.4, 3)
        T = true[i].inverse() @ true[j] @ SE2(*noise.tolist())
        kind = EdgeKind.LOOP if n >= count - 1 else EdgeKind.MATCH
        information = np.asarray(root @ root.T + 4.0 * np.eye(3), np.float64)
        graph.add_edge(Edge(i, j, T, information, kind))
    return graph


def error(poses: Floats, edge: Edge) -> Floats:
    """Return how far a measurement is off, by matrices."""
    i, j = (SE2.from_array(poses[k]).matrix() for k in (edge.i, edge.j))
    T = np.linalg.inv(i) @ j
    turn = math.remainder(math.atan2(T[1, 0], T[0, 0]) - edge.T_i_j.theta, 2.0 * math.pi)
    return np.array([T[0, 2] - edge.T_i_j.x, T[1, 2] - edge.T_i_j.y, turn])


def test_columns_hold_every_edge_as_they_grow_and_when_some_go() -> None:
    graph = random_graph(2, count=150, loops=80)
    assert len(graph) == 150
    gone = np.arange(len(graph.edges)) % 3 == 1
    kept = [edge for edge, out in zip(graph.edges, gone.tolist(), strict=True) if not out]
    prior = np.diag([3.0, 2.0, 1.0])
    for expected in (list(graph.edges), kept):
        table = graph.table
        assert graph.edges == expected
        assert len(table) == len(table.i) == len(expected)
        assert table.i.tolist() == [edge.i for edge in expected]
        assert table.j.tolist() == [edge.j for edge in expected]
        assert table.loop.tolist() == [edge.kind is EdgeKind.LOOP for edge in expected]
        np.testing.assert_array_equal(table.measured, [edge.T_i_j.array() for edge in expected])
        np.testing.assert_array_equal(table.information, [edge.information for edge in expected])
        known = [np.linalg.inv(edge.information) for edge in expected]
        np.testing.assert_allclose(table.covariance, known, rtol=1e-4, atol=1e-8)
        if len(expected) == len(gone):
            graph.remove_edges(gone)
    graph.add_edge(Edge(0, 1, SE2(), 0.0 * prior, EdgeKind.MATCH, prior))
    np.testing.assert_allclose(graph.table.covariance[-1], np.linalg.inv(prior))


@pytest.mark.parametrize("seed", range(4))
def test_the_residual_is_what_the_poses_say_less_the_measurement(seed: int) -> None:
    graph = random_graph(seed, loops=12)
    for edge in graph.edges:
        assert graph.residual(edge) == pytest.approx(error(graph.poses, edge), abs=1e-12)


@pytest.mark.parametrize(("i", "j"), [(-1, 2), (2, -1), (3, 0), (0, 3), (1, 1)])
def test_an_edge_joins_two_nodes_that_there_are(i: int, j: int) -> None:
    graph = random_graph(0, count=3, loops=0)
    with pytest.raises(ValueError, match=rf"edge {i} -> {j}: two different nodes of 0\.\.2"):
        graph.add_edge(Edge(i, j, SE2(), np.eye(3), EdgeKind.LOOP))
    graph.add_edge(Edge(2, 0, SE2(), np.eye(3), EdgeKind.LOOP))
    assert len(graph.table) == len(graph.edges) == 3


G2O = """\
# a comment
VERTEX_SE2 7 1 0 1.5707963267948966
VERTEX_SE2 3 0 0 0
EDGE_SE2 3 7 1 0 1.5707963267948966 4 1 0 9 0 25
"""
TORO = """\
VERTEX2 3 0 0 0
VERTEX2 7 1 0 1.5707963267948966
EDGE2 3 7 1 0 1.5707963267948966 4 1 9 25 0 0
"""


def written(folder: Path, text: str) -> Path:
    path = folder / "graph"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize("text", [G2O, TORO])
def test_both_formats_give_the_same_graph(tmp_path: Path, text: str) -> None:
    poses, edges = read_graph(written(tmp_path, text))
    assert poses[:, 0].tolist() == [0.0, 1.0]
    assert (edges.i.tolist(), edges.j.tolist()) == ([0], [1])
    assert edges.measured[0] == pytest.approx([1.0, 0.0, math.pi / 2])


def test_information_is_in_the_axes_of_the_second_node(tmp_path: Path) -> None:
    """The files measure the error in the frame that the measurement turns to."""
    _, edges = read_graph(written(tmp_path, G2O))
    expected = np.array([(9.0, -1.0, 0.0), (-1.0, 4.0, 0.0), (0.0, 0.0, 25.0)])
    assert edges.information[0] == pytest.approx(expected)
    moved = np.array([(0.0, 0.0, 0.0), (1.0, 0.5, math.pi / 2)])
    assert optimize(moved, edges).trace[0] == pytest.approx(4.0 * 0.5**2)


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("VERTEX_SE2 0 0 0\n", "line 1: 3 finite numbers are valid"),
        ("VERTEX_SE2 0 0 0 nan\n", "line 1: 3 finite numbers are valid"),
        ("VERTEX_SE2 0 0 0 0\n", "has no edges"),
        ("VERTEX_SE2 0 0 0 0\nEDGE_SE2 0 9 1 0 0 1 0 0 1 0 1\n", r"nodes \[9\] have no vertex"),
    ],
)
def test_a_broken_file_is_refused_with_its_line(tmp_path: Path, text: str, problem: str) -> None:
    with pytest.raises(InputFileError, match=problem):
        read_graph(written(tmp_path, text))


def seen_field() -> SeenField:
    """Return a field of a wall along y = 0 from x = 0 to 2 m; its left half has been seen."""
    field = Field(0.1, 0.1)
    points = np.column_stack((np.linspace(0.0, 2.0, 41), np.zeros(41)))
    field.add(points, np.tile((0.0, 1.0), (41, 1)))
    seen = np.zeros(field.score.shape, np.bool_)
    seen[:, : seen.shape[1] // 2] = True
    return SeenField(field, seen)


def test_points_lie_on_seen_ground_where_its_cells_are() -> None:
    ground = seen_field()
    x, y = ground.field.origin
    width = 0.1 * ground.seen.shape[1]
    points = np.array([(x + 0.05, y + 0.05), (x + width - 0.05, y + 0.05), (x - 0.05, y + 0.05)])
    assert ground.field.at(points, ground.seen).tolist() == [True, False, False]
    assert not ground.field.at(
        np.array([(x + 0.05, y - 0.05), (x + 0.05, y + 50.0)]), ground.seen
    ).any()


@pytest.mark.parametrize("sees", [False, True])
def test_ground_is_seen_about_walls_and_where_beams_pass(sees: bool) -> None:
    surface, ends = Field(0.05, 0.1), np.array([[0.0, 0.0], [5.0, 0.0], [5.0, 3.0]])
    surface.add(ends, np.tile((0.0, 1.0), (3, 1)))
    coarse = surface.halved()
    views = [(Scan(np.full(63, 9.0), 0.0, 0.05, 0.1, 10.0), SE2(1.0, 1.0))] if sees else []
    found = SeenField.of(surface, coarse, views, 10.0)
    assert found.field is coarse
    for row, column in np.ndindex(coarse.score.shape):
        r, c = row // 4, column // 4  # blocks of four cells are seen together
        walls = surface.index[max(8 * r - 8, 0) : 8 * r + 16, max(8 * c - 8, 0) : 8 * c + 16]
        middle = coarse.origin + 0.4 * np.array([[c + 0.5, r + 0.5]])
        seen = walls.any() or coarse.score[row, column] > 0
        assert found.seen[row, column] == (seen or gone_through(middle, views, 10.0)[0])
    assert 0.1 < found.seen.mean() < 0.9


@pytest.mark.parametrize("reach", [0.0, 0.25, 1.0])
def test_ground_that_was_not_seen_has_one_likelihood(reach: float) -> None:
    ground = seen_field()
    field = ground.neutral(0.5, reach)
    border = int(np.ceil(reach / 0.1))
    rows, columns = ground.seen.shape
    assert field.score.shape == (rows + 2 * border, columns + 2 * border)
    np.testing.assert_allclose(field.origin, ground.field.origin - 0.1 * border)
    inner = field.score[border : border + rows, border : border + columns]
    np.testing.assert_array_equal(inner[ground.seen], ground.field.score[ground.seen])
    assert set(inner[~ground.seen].tolist()) == {127}
    outside = np.ones(field.score.shape, np.bool_)
    outside[border : border + rows, border : border + columns] = False
    assert (field.score[outside] == 127).all()
