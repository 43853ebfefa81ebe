"""Edges on a costmap: what they cost, which are blocked."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from arjuna_core.config import load
from arjuna_core.grid import GridFrame
from arjuna_core.se2 import SE2
from arjuna_nav.costmap import Costmap
from arjuna_nav.routes.graph import Edge, Graph, Node
from arjuna_nav.routes.obstacles import CollisionMonitor, CostmapScorer, nearest_node
from arjuna_nav.routes.operations import OperationError, OperationResult, RouteEvent
from arjuna_nav.routes.scorers import RouteRequest

NODES = [Node(k, 4.0 * k, 0.0) for k in range(4)]
EDGES = [Edge(10 + k, NODES[k], NODES[k + 1]) for k in range(3)]


def made(cls: Any, values: dict[str, Any], costmap: Callable[[], Costmap | None]) -> Any:
    node = SimpleNamespace(costmap=lambda topic: costmap)
    return cls(load(cls.Config, values), "own", node)


def costs_of(*values: int) -> Callable[[], Costmap]:
    """Return a costmap of 1 m cells in a row, from the origin on, with the values."""
    frame = GridFrame(1.0, len(values), 1, SE2(0.0, -0.5))
    return lambda: Costmap(frame, np.array([values], np.uint8))


EVERY = {"check_resolution": 1}
MEAN = {"use_maximum": False, **EVERY}


@pytest.mark.parametrize(
    ("values", "costs", "x", "cost"),
    [
        (EVERY, (0, 0, 0, 0, 0), 4.5, 0.0),
        (EVERY, (0, 101, 202, 0, 0), 4.5, 202.0 / 253.0),
        ({}, (0, 101, 202, 0, 0), 4.5, 202.0 / 253.0),
        ({}, (0, 202, 0, 202, 0), 4.5, 0.0),
        ({**EVERY, "weight": 3.0, "max_cost": 150.0}, (0, 50, 0), 2.5, 1.0),
        (MEAN, (0, 253, 0, 0, 0), 4.5, None),
        ({**MEAN, "invalid_on_collision": False}, (0, 253, 0, 0), 3.5, 0.25),
        (EVERY, (0, 255, 0, 0, 0), 4.5, None),
        ({**EVERY, "max_cost": 255.0}, (0, 255, 51, 0, 0), 4.5, 0.2),
        (EVERY, (0, 100, 0), 4.5, None),
        ({**EVERY, "invalid_off_map": False}, (0, 100, 0), 4.5, 0.0),
    ],
)
def test_an_edge_costs_by_a_costmap(
    values: dict[str, Any], costs: tuple[int, ...], x: float, cost: float | None
) -> None:
    scorer = made(CostmapScorer, values, costs_of(*costs))
    edge = Edge(0, Node(0, 0.5, 0.0), Node(1, x, 0.0))
    assert scorer.score(edge, RouteRequest(0, 1)) == pytest.approx(cost)


def test_a_costmap_is_read_once_a_search_and_without_one_all_is_closed() -> None:
    costmaps = [None, costs_of(0, 0, 0, 0, 0)(), costs_of(0, 253, 0, 0, 0)()]
    scorer = made(CostmapScorer, EVERY, lambda: costmaps.pop(0))
    requests = [RouteRequest(0, 1) for _ in range(3)]
    scores = [scorer.score(EDGES[0], request) for request in requests for _ in range(2)]
    assert scores == [None, None, 0.0, 0.0, None, None]


def on_route(x: float = 0.0, **more: Any) -> RouteEvent:
    """Return a look at the robot on the first of three edges."""
    about = {"began": 0.0, "pose": SE2(x), "edge": EDGES[0], "ahead": tuple(EDGES[1:]), **more}
    return RouteEvent(**about)


def row(obstacle: float, cost: int = 254, width: int = 26) -> Costmap:
    """Return a costmap of half-metre cells along the edges with a cost at a distance [m]."""
    frame = GridFrame(0.5, width, 2, SE2(-0.5, -0.5))
    costmap = Costmap(frame, np.zeros(frame.shape, np.uint8))
    costmap.data[:, int((obstacle + 0.5) / 0.5)] = cost
    return costmap


@pytest.mark.parametrize(
    ("values", "costmap", "x", "blocked"),
    [
        ({}, row(3.0), 1.0, 10),
        ({}, row(3.0), 3.7, None),
        ({}, row(5.0), 1.0, 11),
        ({}, row(7.0), 1.0, None),
        ({"max_collision_dist": 7.0}, row(7.0), 1.0, 11),
        ({"max_collision_dist": 1.0}, row(8.0), 1.0, None),
        ({"max_collision_dist": 0.0}, row(11.0), 1.0, 12),
        ({}, row(3.0, 252), 1.0, None),
        ({"max_cost": 200.0}, row(3.0, 252), 1.0, 10),
        ({"max_cost": 200.0}, row(3.0, 255), 1.0, None),
        ({"check_resolution": 2}, row(2.5), 1.0, None),
        ({"check_resolution": 2}, row(3.0), 1.0, 10),
        ({"max_collision_dist": 0.0}, row(2.0, 0, width=8), 1.0, None),
    ],
)
def test_an_obstacle_ahead_blocks_its_edge(
    values: dict[str, Any], costmap: Costmap, x: float, blocked: int | None
) -> None:
    result = made(CollisionMonitor, values, lambda: costmap).perform(on_route(x, now=1.0))
    expected = OperationResult(reroute=True, blocked=frozenset({blocked}))  # type: ignore[arg-type]
    assert result == (None if blocked is None else expected)


def test_the_route_is_looked_at_as_often_as_the_rate_says_and_on_it_only() -> None:
    monitor = made(CollisionMonitor, {"rate": 0.5}, lambda: row(3.0))
    times = (1.0, 1.5, 2.5, 3.9, 4.1)
    seen = [now for now in times if monitor.perform(on_route(now=now)) is not None]
    assert seen == [1.0, 2.5, 4.1]
    assert monitor.perform(on_route(now=9.0, edge=None)) is None


@pytest.mark.parametrize(
    ("values", "costmap", "text"),
    [
        ({"costmap_topic": "c"}, None, "no costmap to see the route by on c"),
        ({"reroute_on_collision": False}, row(3.0), "edge 10 is blocked, and reroute_on_coll"),
    ],
)
def test_says_why_the_route_cannot_be_driven(
    values: dict[str, Any], costmap: Costmap | None, text: str
) -> None:
    with pytest.raises(OperationError, match=text):
        made(CollisionMonitor, values, lambda: costmap).perform(on_route(now=1.0))


WALL = np.zeros((9, 9), np.uint8)
WALL[2:, 4] = 254  # between x = 4 and 5, from y = 2 on


@pytest.mark.parametrize(
    ("costs", "at", "count", "node"),
    [
        (np.zeros_like(WALL), (3.5, 6.5), 5, 1),
        (WALL, (3.5, 6.5), 5, 0),  # node 1 is nearer, behind the wall
        (WALL, (3.5, 6.5), 1, 1),
        (np.where(WALL, 255, 0), (3.5, 6.5), 5, 1),  # what is unknown is no obstacle
        (WALL, (5.5, 5.5), 5, 1),
        (WALL, (3.5, 9.5), 5, 1),  # off the costmap
        (np.where(np.arange(9) == 4, 254, 0) + 0 * WALL, (2.5, 8.5), 5, 0),
    ],
)
def test_the_nearest_node_is_not_one_behind_a_wall(
    costs: Any, at: tuple[float, float], count: int, node: int
) -> None:
    graph = Graph({0: Node(0, 1.5, 3.5), 1: Node(1, 5.5, 6.5)}, {})
    frame = GridFrame(1.0, 9, 9, SE2())
    costmap = Costmap(frame, costs.astype(np.uint8))
    assert nearest_node(graph, at, costmap, count) == node
    assert nearest_node(graph, at, None, count) == graph.nearest(*at)[0]
