"""The cheapest route on a graph, and the path along it."""

from __future__ import annotations

import heapq
import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from arjuna_nav.routes.graph import Edge, Graph, Point

CLOSED = math.inf
"""The cost of an edge that is closed."""


@dataclass(frozen=True)
class Route:
    """A sequence of nodes.

    Attributes:
        nodes: Numbers of the nodes, at least one.
        edges: The edges between them.
        cost: What they cost together.
    """

    nodes: tuple[int, ...]
    edges: tuple[Edge, ...]
    cost: float


def find_route(
    graph: Graph, start: int, goal: int, costs: Mapping[int, float] | None = None
) -> Route | None:
    """Return the cheapest route between two nodes, None where there is none.

    Source: Dijkstra, A note on two problems in connexion with graphs, 1959.
    """
    costs = costs or {}
    leaving: dict[int, list[tuple[Edge, float]]] = {}
    for edge in graph.edges.values():
        leaving.setdefault(edge.start, []).append((edge, costs.get(edge.id, edge.total_cost)))
    before: dict[int, Edge] = {}
    best, queue, done = {start: 0.0}, [(0.0, start)], set[int]()
    while queue:
        cost, node = heapq.heappop(queue)
        if node == goal:
            return _back(before, start, goal, cost)
        if node in done:
            continue
        done.add(node)
        for edge, own in leaving.get(node, ()):
            value = cost + own
            if value < best.get(edge.end, math.inf):
                best[edge.end], before[edge.end] = value, edge
                heapq.heappush(queue, (value, edge.end))
    return None


def _back(before: dict[int, Edge], start: int, goal: int, cost: float) -> Route:
    edges: list[Edge] = []
    node = goal
    while node != start:
        edges.append(before[node])
        node = before[node].start
    edges.reverse()
    return Route((start, *(edge.end for edge in edges)), tuple(edges), cost)


def pruned(
    route: Route, graph: Graph, start: Point | None, goal: Point | None, least: float, off: float
) -> Route:
    """Return a route without the ends at which it would lead back.

    The first node is left out where the robot already stands along the edge to the second, the last
    where the goal lies along the edge to it.

    Args:
        route: The route.
        graph: Of the route.
        start: Where the robot stands; None to keep the first node.
        goal: Where it is to come; None to keep the last.
        least: How far along an edge counts as along it [m].
        off: How far from the edge still does [m].

    Source: nav2_route, GoalIntentExtractor::pruneStartandGoal.
    """
    if start is not None and route.edges:
        along, beside = _on(graph, route.edges[0], start)
        if along >= least and beside <= off:
            route = _without(route, 0)
    if goal is not None and route.edges:
        edge = route.edges[-1]
        along, beside = _on(graph, edge, goal)
        if along <= edge.length - least and beside <= off:
            route = _without(route, -1)
    return route


def _without(route: Route, end: int) -> Route:
    kept = slice(1, None) if end == 0 else slice(None, -1)
    cost = route.cost - route.edges[end].total_cost
    return replace(route, nodes=route.nodes[kept], edges=route.edges[kept], cost=max(cost, 0.0))


def _on(graph: Graph, edge: Edge, point: Point) -> tuple[float, float]:
    """Return how far along an edge a point lies, and how far beside it [m]."""
    first, last = np.array(graph.nodes[edge.start]), np.array(graph.nodes[edge.end])
    if edge.length == 0.0:
        return 0.0, math.dist(point, graph.nodes[edge.start])
    unit = (last - first) / edge.length
    along = float(np.clip((np.array(point) - first) @ unit, 0.0, edge.length))
    return along, float(np.hypot(*(np.array(point) - first - along * unit)))


def path_along(route: Route, graph: Graph, spacing: float) -> NDArray[np.float64]:
    """Return poses `(N, 3)` [m, m, rad] along a route, at most a spacing apart [m]."""
    corners = np.array([graph.nodes[node] for node in route.nodes])
    pieces = [corners[:1]]
    for a, b in itertools.pairwise(corners):
        count = max(math.ceil(float(np.hypot(*(b - a))) / spacing - 1e-9), 1)
        pieces.append(a + (b - a) * np.arange(1, count + 1)[:, None] / count)
    points = np.vstack(pieces)
    steps = np.diff(points, axis=0)
    yaw = np.arctan2(steps[:, 1], steps[:, 0])
    return np.column_stack((points, np.append(yaw, yaw[-1:] if len(yaw) else 0.0)))


class Tracker:
    """Tracks which nodes of a route are behind the robot.

    Args:
        route: The route.
        graph: Of the route.
        radius: How near to a node the robot passes it [m].
        end_radius: How near to the last node it has come there [m].

    Source: nav2_route, RouteTracker: a node is passed within the radius where the line across the
        route, midway between the edges that meet there, is.
    """

    def __init__(self, route: Route, graph: Graph, radius: float, end_radius: float) -> None:
        self._route = route
        self._graph = graph
        self._radius, self._end_radius = radius, end_radius
        self._passed = 0

    @property
    def last_node(self) -> int | None:
        """The node that was passed last, None before the first."""
        return self._route.nodes[self._passed - 1] if self._passed else None

    @property
    def next_node(self) -> int | None:
        """The node to come to next, None at the end."""
        return None if self.done else self._route.nodes[self._passed]

    @property
    def edge(self) -> Edge | None:
        """The edge that is driven, None before the first node and at the end."""
        return self._route.edges[self._passed - 1] if self._passed > 0 and not self.done else None

    @property
    def ahead(self) -> tuple[Edge, ...]:
        """The edges from the next node on."""
        return self._route.edges[self._passed :]

    @property
    def done(self) -> bool:
        """True once the last node was reached."""
        return self._passed == len(self._route.nodes)

    def update(self, x: float, y: float) -> bool:
        """Take note of where the robot is; return whether it has passed a node."""
        before = self._passed
        while not self.done and self._is_passed(x, y):
            self._passed += 1
        return self._passed > before

    def _is_passed(self, x: float, y: float) -> bool:
        k, nodes = self._passed, self._route.nodes
        here = np.array(self._graph.nodes[nodes[k]])
        off = np.array([x, y]) - here
        if k == len(nodes) - 1:
            return math.hypot(*off) <= self._end_radius
        steps = [np.array(self._graph.nodes[nodes[k + 1]]) - here]
        if k > 0:
            steps.append(here - np.array(self._graph.nodes[nodes[k - 1]]))
        across = sum(step / max(math.hypot(*step), 1e-9) for step in steps)
        return math.hypot(*off) <= self._radius and float(off @ across) >= 0.0
