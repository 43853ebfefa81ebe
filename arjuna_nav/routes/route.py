"""The cheapest route on a graph, and the path along it."""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from arjuna_core.arrays import Floats
from arjuna_core.errors import ArjunaError
from arjuna_nav.routes.graph import Edge, Graph, Node, Point


@dataclass(frozen=True)
class Route:
    """A sequence of edges from a node on; without any it ends there."""

    start: Node
    edges: tuple[Edge, ...] = ()
    costs: tuple[float, ...] = ()

    @property
    def nodes(self) -> tuple[Node, ...]:
        """The nodes, at least one."""
        return self.start, *(edge.end for edge in self.edges)

    @property
    def cost(self) -> float:
        """The cost of all edges."""
        return sum(self.costs, 0.0)

    def without_first(self) -> Route:
        """Return the rest of the route behind its first edge."""
        return Route(self.edges[0].end, self.edges[1:], self.costs[1:])


class RouteSearchError(ArjunaError):
    """A search for a route was given up."""


def find_route(
    graph: Graph,
    start: int,
    goal: int,
    cost: Callable[[Edge], float | None],
    limit: float = math.inf,
) -> Route | None:
    """Return the cheapest route between two nodes, None where there is none.

    Args:
        start: Number of the first node.
        goal: Number of the last.
        cost: Returns what an edge costs, at least 0; None where it is closed.
        limit: Greatest number of nodes that are looked at.

    Raises:
        RouteSearchError: So many nodes were looked at.

    Source: Dijkstra, A note on two problems in connexion with graphs, 1959.
    """
    leaving: dict[int, list[Edge]] = {}
    for edge in graph.edges.values():
        leaving.setdefault(edge.start.id, []).append(edge)
    before: dict[int, tuple[Edge, float]] = {}
    best, queue, done, looked = {start: 0.0}, [(0.0, start)], set[int](), 0
    while queue:
        looked += 1
        if looked > limit:
            raise RouteSearchError(f"no route in max_iterations = {limit}")
        so_far, node = heapq.heappop(queue)
        if node == goal:
            return _back(before, graph.nodes[start], graph.nodes[goal])
        if node in done:
            continue
        done.add(node)
        for edge in leaving.get(node, ()):
            own = None if edge.end.id in done else cost(edge)
            if own is not None and so_far + own < best.get(edge.end.id, math.inf):
                best[edge.end.id], before[edge.end.id] = so_far + own, (edge, own)
                heapq.heappush(queue, (so_far + own, edge.end.id))
    return None


def _back(before: dict[int, tuple[Edge, float]], start: Node, goal: Node) -> Route:
    steps: list[tuple[Edge, float]] = []
    node = goal
    while node is not start:
        steps.append(before[node.id])
        node = steps[-1][0].start
    steps.reverse()
    return Route(start, tuple(edge for edge, _ in steps), tuple(cost for _, cost in steps))


def pruned(
    route: Route, start: Point | None, goal: Point | None, first: float, last: float, off: float
) -> Route:
    """Return a route without the ends at which it would lead back.

    The first node is left out where the robot already stands along the edge to the second, the last
    where the goal lies along the edge to it.

    Args:
        start: Where the robot stands; None to keep the first node.
        goal: Where it is to come; None to keep the last.
        first: How far along the first edge counts as along it [m].
        last: How far before the last node does [m].
        off: How far from the edge still does [m].

    Source: nav2_route, GoalIntentExtractor::pruneStartandGoal.
    """
    if start is not None and route.edges:
        along, beside = along_edge(route.edges[0], start)
        if along >= first and beside <= off:
            route = route.without_first()
    if goal is not None and route.edges:
        along, beside = along_edge(route.edges[-1], goal)
        if along <= route.edges[-1].length - last and beside <= off:
            route = replace(route, edges=route.edges[:-1], costs=route.costs[:-1])
    return route


def along_edge(edge: Edge, point: Point) -> tuple[float, float]:
    """Return how far along an edge a point lies, and how far beside it [m]."""
    first, last = np.array(edge.start.point), np.array(edge.end.point)
    if edge.length == 0.0:
        return 0.0, math.dist(point, edge.start.point)
    unit = (last - first) / edge.length
    along = float(np.clip((np.array(point) - first) @ unit, 0.0, edge.length))
    return along, float(np.hypot(*(np.array(point) - first - along * unit)))


def path_along(route: Route, spacing: float, radius: float = 0.0) -> Floats:
    """Return poses `(N, 3)` [m, m, rad] along a route, at most a spacing apart [m].

    Args:
        radius: Of the arc that rounds a corner [m], where its edges are long enough; 0 for none.

    Source: nav2_route, PathConverter and CornerArc.
    """
    corners = np.array([node.point for node in route.nodes])
    pieces = [corners[:1]]
    for corner, after in zip(corners[1:], [*corners[2:], None], strict=False):
        start = pieces[-1][-1]
        arc = _arc(start, corner, after, radius, spacing) if radius and after is not None else None
        end = corner if arc is None else arc[0]
        count = max(math.ceil(float(np.hypot(*(end - start))) / spacing - 1e-9), 1)
        pieces.append(start + (end - start) * np.arange(1, count + 1)[:, None] / count)
        pieces += [] if arc is None else [arc[1:]]
    points = np.vstack(pieces)
    steps = np.diff(points, axis=0)
    yaw = np.arctan2(steps[:, 1], steps[:, 0])
    return np.column_stack((points, np.append(yaw, yaw[-1:] if len(yaw) else 0.0)))


def _arc(
    start: Floats, corner: Floats, after: Floats, radius: float, spacing: float
) -> Floats | None:
    """Return the points of an arc that touches both edges of a corner, None if there is no room."""
    ahead, behind = corner - start, after - corner
    lengths = np.hypot(*ahead), np.hypot(*behind)
    turn = math.atan2(ahead[0] * behind[1] - ahead[1] * behind[0], float(ahead @ behind))
    cut = radius * math.tan(0.5 * abs(turn))
    if not 1e-3 < abs(turn) < math.pi - 1e-3 or not cut < min(lengths):
        return None
    along = ahead / lengths[0]
    to_middle = math.copysign(radius, turn) * np.array((-along[1], along[0]))
    count = math.ceil(radius * abs(turn) / spacing)
    angles = np.linspace(0.0, turn, count + 1)
    cos, sin = np.cos(angles)[:, None], np.sin(angles)[:, None]
    across = np.array((-to_middle[1], to_middle[0]))
    points: Floats = corner - cut * along + to_middle - cos * to_middle - sin * across
    return points


class Tracker:
    """Tracks which nodes of a route are behind the robot.

    Args:
        radius: How near to a node the robot passes it [m].
        end_radius: How near to the last node it has come there [m].
        edge: The edge to the route's first node where the robot is on it already.

    Source: nav2_route, RouteTracker: a node is passed within the radius where the line across the
        route, midway between the edges that meet there, is.
    """

    def __init__(
        self, route: Route, radius: float, end_radius: float, edge: Edge | None = None
    ) -> None:
        self._nodes = route.nodes
        self._edges = (edge, *route.edges, None)  # before each node, and behind the last
        self._radius, self._end_radius = radius, end_radius
        self._passed = 0

    @property
    def last_node(self) -> Node | None:
        """The node that was passed last, None before the first."""
        edge = self._edges[0]
        before = edge.start if edge is not None else None
        return self._nodes[self._passed - 1] if self._passed else before

    @property
    def next_node(self) -> Node | None:
        """The node to come to next, None at the end."""
        return None if self.done else self._nodes[self._passed]

    @property
    def edge(self) -> Edge | None:
        """The edge that is driven, None before the first node and at the end."""
        return self._edges[self._passed]

    @property
    def edge_before(self) -> Edge | None:
        """The edge that led to the last node, if any."""
        return self._edges[self._passed - 1] if self._passed else None

    @property
    def ahead(self) -> tuple[Edge, ...]:
        """The edges from the next node on."""
        return tuple(edge for edge in self._edges[self._passed + 1 :] if edge is not None)

    @property
    def done(self) -> bool:
        """True once the last node was reached."""
        return self._passed == len(self._nodes)

    def update(self, x: float, y: float) -> bool:
        """Take note of where the robot is; return whether it has passed the next node."""
        passed = not self.done and self._is_passed(x, y)
        self._passed += passed
        return passed

    def _is_passed(self, x: float, y: float) -> bool:
        k, nodes = self._passed, self._nodes
        here = np.array(nodes[k].point)
        off = np.array([x, y]) - here
        if k == len(nodes) - 1:
            return math.hypot(*off) <= self._end_radius
        steps = [np.array(nodes[k + 1].point) - here]
        edge = self.edge
        if edge is not None:
            steps.append(here - np.array(edge.start.point))
        across = sum(step / max(math.hypot(*step), 1e-9) for step in steps)
        return math.hypot(*off) <= self._radius and float(off @ across) >= 0.0
