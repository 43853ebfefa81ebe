"""Routes: read from a file, the cheapest found, ends pruned, progress tracked."""

from __future__ import annotations

import itertools
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from arjuna_core.errors import InputFileError
from arjuna_nav.routes.graph import Edge, Graph, read_graph
from arjuna_nav.routes.route import CLOSED, Tracker, find_route, path_along, pruned
from tests.helpers.nav.routes import SQUARE, square, written


def test_a_file_is_read(tmp_path: Path) -> None:
    graph = read_graph(written(tmp_path), "map")
    assert graph.nodes == SQUARE
    assert graph.edges[0] == Edge(0, 0, 1, None, 4.0, 0.5, 1.0)
    assert graph.edges[0].total_cost == 9.0
    assert graph.edges[1].total_cost == 0.25, "it is given, and not overridable"
    assert graph.nearest(3.1, 0.4) == 1


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"id": None}, "no route graph"),
        ({"startid": 9}, "edge 0 joins node 9, which does not exist"),
        ({"metadata": {"speed_limit": 0.0}}, "edge 0 has speed_limit 0.*valid: 0 < speed_limit"),
        ({"id": 70000}, "edge 70000 is out of range; valid: 0 to 65535"),
    ],
)
def test_says_what_is_wrong_with_a_file(tmp_path: Path, change: dict[str, Any], text: str) -> None:
    content = square()
    content["features"][4]["properties"].update(change)
    with pytest.raises(InputFileError, match=text):
        read_graph(written(tmp_path, content), "map")


def test_says_that_there_is_no_file_or_frame(tmp_path: Path) -> None:
    with pytest.raises(InputFileError, match="cannot be read"):
        read_graph(tmp_path / "none.geojson", "map")
    with pytest.raises(InputFileError, match="node 0 lies in 'map'; valid: 'odom'"):
        read_graph(written(tmp_path), "odom")
    (tmp_path / "text").write_text("{}")
    with pytest.raises(InputFileError, match="'features' is missing"):
        read_graph(tmp_path / "text", "map")
    with pytest.raises(InputFileError, match="it has no node"):
        read_graph(written(tmp_path, {"features": []}), "map")


@pytest.mark.parametrize("seed", range(8))
def test_the_route_is_the_cheapest(seed: int) -> None:
    rng = np.random.default_rng(seed)
    points = rng.uniform(0.0, 10.0, (7, 2))
    nodes = {k: (float(x), float(y)) for k, (x, y) in enumerate(points)}
    pairs = [pair for pair in itertools.permutations(nodes, 2) if rng.random() < 0.35]
    edges = {
        k: Edge(k, a, b, None, math.dist(nodes[a], nodes[b]), 1.0, float(rng.uniform(0.0, 5.0)))
        for k, (a, b) in enumerate(pairs)
    }
    least = np.full((7, 7), np.inf)
    for edge in edges.values():
        least[edge.start, edge.end] = edge.total_cost
    for k in range(7):  # Floyd and Warshall
        least = np.minimum(least, least[:, k : k + 1] + least[k : k + 1])
    route = find_route(Graph(nodes, edges), 0, 6)
    assert (route.cost if route else math.inf) == pytest.approx(least[0, 6])
    if route is not None:
        assert [edge.end for edge in route.edges] == list(route.nodes[1:])
        assert sum(edge.total_cost for edge in route.edges) == pytest.approx(route.cost)


def test_a_closed_edge_is_not_taken_and_a_costlier_one_only_where_it_pays(tmp_path: Path) -> None:
    graph = read_graph(written(tmp_path), "map")
    route = find_route(graph, 0, 2)
    assert route is not None
    assert route.nodes == (0, 3, 2)
    around = find_route(graph, 0, 2, {3: 50.0})
    assert around is not None
    assert around.nodes == (0, 1, 2)
    assert find_route(graph, 0, 2, {0: CLOSED, 3: CLOSED}) is None
    assert find_route(graph, 1, 1) is not None


def test_ends_at_which_the_robot_would_turn_back_are_left_out(tmp_path: Path) -> None:
    graph = read_graph(written(tmp_path), "map")
    route = find_route(graph, 0, 2, {3: CLOSED})
    assert route is not None
    assert pruned(route, graph, (1.0, 0.3), (4.0, 2.0), 0.1, 1.0).nodes == (1,)
    assert pruned(route, graph, (-1.0, 0.0), (4.0, 5.0), 0.1, 1.0).nodes == (0, 1, 2)
    assert pruned(route, graph, (1.0, 3.0), (1.0, 2.0), 0.1, 1.0).nodes == (0, 1, 2), "too far"
    assert pruned(route, graph, None, None, 0.1, 1.0) == route


def test_a_path_goes_over_the_nodes(tmp_path: Path) -> None:
    graph = read_graph(written(tmp_path), "map")
    route = find_route(graph, 0, 2, {3: CLOSED})
    assert route is not None
    path = path_along(route, graph, 0.3)
    assert np.hypot(*np.diff(path[:, :2], axis=0).T).max() <= 0.3 + 1e-9
    np.testing.assert_allclose(path[[0, -1]], [[0.0, 0.0, 0.0], [4.0, 4.0, math.pi / 2]])
    assert (np.abs(path[:, :2] - (4.0, 0.0)).sum(axis=1) < 1e-9).any()
    alone = find_route(graph, 1, 1)
    assert alone is not None
    np.testing.assert_allclose(path_along(alone, graph, 0.3), [[4.0, 0.0, 0.0]])


def test_a_node_is_passed_where_the_route_bends_there(tmp_path: Path) -> None:
    graph = read_graph(written(tmp_path), "map")
    route = find_route(graph, 0, 2, {3: CLOSED})
    assert route is not None
    tracker = Tracker(route, graph, 1.0, 0.5)
    assert (tracker.last_node, tracker.next_node, tracker.edge) == (None, 0, None)
    assert not tracker.update(-0.5, 0.0), "not yet at the first"
    assert tracker.update(0.1, 0.0)
    assert (tracker.last_node, tracker.next_node) == (0, 1)
    assert tracker.edge == route.edges[0]
    assert not tracker.update(3.5, 0.0), "near, but not past it"
    assert tracker.update(3.9, 0.3)
    assert tracker.ahead == ()
    assert not tracker.update(4.0, 3.4)
    assert tracker.update(4.0, 3.6)
    assert tracker.done
    assert (tracker.last_node, tracker.next_node) == (2, None)
