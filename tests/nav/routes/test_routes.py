"""Routes: read from a file, the cheapest found, ends pruned, progress tracked."""

from __future__ import annotations

import itertools
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from arjuna_core.errors import InputFileError
from arjuna_core.se2 import SE2
from arjuna_nav.routes.graph import Edge, Graph, Node, read_graph
from arjuna_nav.routes.route import (
    Route,
    RouteSearchError,
    Tracker,
    find_route,
    path_along,
    pruned,
)
from tests.helpers.nav.routes import SQUARE, square, written


def numbers(route: Route | None) -> tuple[int, ...]:
    assert route is not None
    return tuple(node.id for node in route.nodes)


def route_round(graph: Graph) -> Route:
    """Return the route 0, 1, 2 of the square; 0, 3, 2 is closed."""
    route = find_route(graph, 0, 2, lambda edge: None if edge.id == 3 else 4.0 + edge.id)
    assert route is not None
    return route


def test_a_file_is_read(tmp_path: Path) -> None:
    content = square()
    stop = {"type": "Stop", "trigger": "NODE", "metadata": {"wait_for": 5.0}}
    content["features"][0]["properties"] |= {
        "operations": {"stop": stop},
        "metadata": {"class": "hall"},
    }
    content["features"][4]["properties"]["operations"] = [{"type": "Door", "trigger": "ON_ENTER"}]
    graph = read_graph(written(tmp_path, content), "map")
    assert {k: node.point for k, node in graph.nodes.items()} == SQUARE
    first, second = graph.edges[0], graph.edges[1]
    assert (first.start.id, first.end.id, first.length, first.heading) == (0, 1, 4.0, 0.0)
    assert (first.cost, first.overridable) == (None, True)
    assert first.metadata == {"speed_limit": 0.5, "penalty": 1.0}
    assert [(one.type, one.trigger) for one in first.operations] == [("Door", "ON_ENTER")]
    assert (second.cost, second.overridable, second.heading) == (0.25, False, math.pi / 2.0)
    (asked,) = graph.nodes[0].operations
    assert (asked.type, asked.trigger, asked.metadata) == ("Stop", "NODE", {"wait_for": 5.0})
    assert graph.nodes[0].metadata == {"class": "hall"}
    assert graph.nearest(3.1, 0.4) == [1]
    assert graph.nearest(3.1, 0.4, 3) == [1, 0, 2]


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"id": None}, "no route graph"),
        ({"startid": 9}, "edge 0 joins node 9, which does not exist"),
        ({"cost": -1.0}, "edge 0 has cost -1; valid: at least 0"),
        ({"id": 70000}, "edge 70000 is out of range; valid: 0 to 65535"),
        (
            {"operations": {"a": {"type": "Door", "trigger": "NEVER"}}},
            "edge 0 has operation 'Door' with trigger 'NEVER'; valid: NODE, ON_ENTER, ON_EXIT",
        ),
        ({"operations": {"a": {"type": "Door"}}}, "'trigger' is missing"),
    ],
)
def test_says_what_is_wrong_with_a_file(tmp_path: Path, change: dict[str, Any], text: str) -> None:
    content = square()
    content["features"][4]["properties"].update(change)
    with pytest.raises(InputFileError, match=text):
        read_graph(written(tmp_path, content), "map")


def test_nodes_of_another_frame_are_placed_in_the_graph_s(tmp_path: Path) -> None:
    content = square()
    content["features"][0]["properties"]["frame"] = "site"
    asked = []

    def transform(target: str, source: str) -> SE2:
        asked.append((target, source))
        return SE2(10.0, 0.0, math.pi / 2)

    there = read_graph(written(tmp_path, content), "map", transform).nodes[0]
    x, y = read_graph(written(tmp_path), "map").nodes[0].point
    assert there.point == pytest.approx((10.0 - y, x))
    assert asked == [("map", "site")]


def test_says_that_there_is_no_file_or_frame(tmp_path: Path) -> None:
    with pytest.raises(InputFileError, match="cannot be read"):
        read_graph(tmp_path / "none.geojson", "map")
    with pytest.raises(InputFileError, match="a node lies in 'map'; valid: 'odom'"):
        read_graph(written(tmp_path), "odom")
    (tmp_path / "text").write_text("{}")
    with pytest.raises(InputFileError, match="'features' is missing"):
        read_graph(tmp_path / "text", "map")
    with pytest.raises(InputFileError, match="it has no node"):
        read_graph(written(tmp_path, {"features": []}), "map")


@pytest.mark.parametrize("seed", range(4))
def test_the_route_is_the_cheapest(seed: int) -> None:
    rng = np.random.default_rng(seed)
    points = rng.uniform(0.0, 10.0, (7, 2))
    nodes = {k: Node(k, float(x), float(y)) for k, (x, y) in enumerate(points)}
    pairs = [pair for pair in itertools.permutations(nodes, 2) if rng.random() < 0.35]
    edges = {k: Edge(k, nodes[a], nodes[b]) for k, (a, b) in enumerate(pairs)}
    costs = {k: float(rng.uniform(0.0, 15.0)) for k in edges}
    least = np.full((7, 7), np.inf)
    for k, edge in edges.items():
        least[edge.start.id, edge.end.id] = costs[k]
    for k in range(7):  # Floyd and Warshall
        least = np.minimum(least, least[:, k : k + 1] + least[k : k + 1])
    route = find_route(Graph(nodes, edges), 0, 6, lambda edge: costs[edge.id])
    assert (route.cost if route else math.inf) == pytest.approx(least[0, 6])
    if route is not None:
        assert [edge.start for edge in route.edges] == list(route.nodes[:-1])
        assert route.costs == tuple(costs[edge.id] for edge in route.edges)


def test_a_closed_edge_is_not_taken_and_a_costlier_one_only_where_it_pays(tmp_path: Path) -> None:
    graph = read_graph(written(tmp_path), "map")
    costs: dict[int, float | None] = {0: 9.0, 1: 0.25, 2: 4.0, 3: 4.0, 4: 4.0}
    for change, nodes in (({}, (0, 3, 2)), ({3: 50.0}, (0, 1, 2)), ({4: None}, (0, 1, 2))):
        changed = {**costs, **change}
        assert numbers(find_route(graph, 0, 2, lambda edge: changed[edge.id])) == nodes  # noqa: B023
    assert find_route(graph, 0, 2, lambda edge: None) is None
    assert numbers(find_route(graph, 1, 1, lambda edge: None)) == (1,)


def test_a_search_is_given_up_after_so_many_nodes(tmp_path: Path) -> None:
    graph = read_graph(written(tmp_path, square()), "map")
    assert numbers(find_route(graph, 0, 1, lambda edge: edge.length, 2)) == (0, 1)
    with pytest.raises(RouteSearchError, match="max_iterations = 1"):
        find_route(graph, 0, 1, lambda edge: edge.length, 1)


def test_ends_at_which_the_robot_would_turn_back_are_left_out(tmp_path: Path) -> None:
    route = route_round(read_graph(written(tmp_path), "map"))
    short = pruned(route, (1.0, 0.3), (4.0, 2.0), 0.1, 0.1, 1.0)
    assert (numbers(short), short.cost) == ((1,), 0.0)
    half = pruned(route, (1.0, 0.3), None, 0.1, 0.1, 1.0)
    assert (numbers(half), half.cost) == ((1, 2), 5.0)
    assert numbers(pruned(route, (-1.0, 0.0), (4.0, 5.0), 0.1, 0.1, 1.0)) == (0, 1, 2)
    assert numbers(pruned(route, (1.0, 3.0), (1.0, 2.0), 0.1, 0.1, 1.0)) == (0, 1, 2), "too far"
    assert pruned(route, None, None, 0.1, 0.1, 1.0) == route
    for last, nodes in (
        (0.4, (0, 1)),
        (0.6, (0, 1, 2)),
    ):  # the goal is half a metre before its node
        assert numbers(pruned(route, None, (4.0, 3.5), 0.1, last, 1.0)) == nodes


def test_a_path_goes_over_the_nodes(tmp_path: Path) -> None:
    graph = read_graph(written(tmp_path), "map")
    path = path_along(route_round(graph), 0.3)
    assert np.hypot(*np.diff(path[:, :2], axis=0).T).max() <= 0.3 + 1e-9
    np.testing.assert_allclose(path[[0, -1]], [[0.0, 0.0, 0.0], [4.0, 4.0, math.pi / 2]])
    assert (np.abs(path[:, :2] - (4.0, 0.0)).sum(axis=1) < 1e-9).any()
    np.testing.assert_allclose(path_along(Route(graph.nodes[1]), 0.3), [[4.0, 0.0, 0.0]])
    assert isinstance(Route(graph.nodes[1]).cost, float)  # what a message takes


@pytest.mark.parametrize(("radius", "rounded"), [(1.0, True), (3.9, True), (4.1, False)])
def test_an_arc_rounds_a_corner_that_has_room(tmp_path: Path, radius: float, rounded: bool) -> None:
    graph = read_graph(written(tmp_path), "map")
    path = path_along(route_round(graph), 0.1, radius)
    steps = np.diff(path[:, :2], axis=0)
    assert np.hypot(*steps.T).max() <= 0.1 + 1e-9
    np.testing.assert_allclose(path[[0, -1], :2], [[0.0, 0.0], [4.0, 4.0]], atol=1e-12)
    on_arc = np.hypot(*(path[:, :2] - (4.0 - radius, radius)).T) < radius + 1e-9
    assert (np.abs(path[:, :2] - (4.0, 0.0)).sum(axis=1) < 1e-9).any() != rounded
    if rounded:
        assert on_arc.sum() > 10
        assert np.abs(np.diff(path[:, 2])).max() < 0.11 / radius


def test_a_node_is_passed_where_the_route_bends_there(tmp_path: Path) -> None:
    graph = read_graph(written(tmp_path), "map")
    route = route_round(graph)
    zero, one, two = route.nodes
    tracker = Tracker(route, 1.0, 0.5)
    assert (tracker.last_node, tracker.next_node, tracker.edge) == (None, zero, None)
    assert not tracker.update(-0.5, 0.0), "not yet at the first"
    assert tracker.update(0.1, 0.0)
    assert (tracker.last_node, tracker.next_node) == (zero, one)
    assert (tracker.edge, tracker.edge_before) == (route.edges[0], None)
    assert tracker.ahead == route.edges[1:]
    assert not tracker.update(3.5, 0.0), "near, but not past it"
    assert tracker.update(3.9, 0.3)
    assert (tracker.edge, tracker.edge_before, tracker.ahead) == (*route.edges[::-1], ())
    assert not tracker.update(4.0, 3.4)
    assert tracker.update(4.0, 3.6)
    assert tracker.done
    assert (tracker.last_node, tracker.next_node, tracker.edge) == (two, None, None)
    assert tracker.edge_before is route.edges[1]
    assert not tracker.update(4.0, 3.6)


def test_a_route_from_the_edge_that_is_driven_passes_its_end_where_it_bends(tmp_path: Path) -> None:
    route = route_round(read_graph(written(tmp_path), "map"))
    tracker = Tracker(route.without_first(), 1.0, 0.5, route.edges[0])
    assert (tracker.edge, tracker.last_node) == (route.edges[0], route.start)
    assert not tracker.update(3.5, 0.3), "a route that began here would be behind its node"
    assert tracker.update(3.9, 0.3)
    assert tracker.edge_before is route.edges[0]
