"""How far along a route the robot has come."""

from __future__ import annotations

import math

import numpy as np

from arjuna_nav.routes.graph import Edge, Graph
from arjuna_nav.routes.route import Route


class Tracker:
    """Tells which nodes of a route are behind the robot.

    Args:
        route: The route.
        graph: Of the route.
        radius: How near to a node the robot passes it [m].
        end_radius: How near to the last node it has come there [m].

    Source: nav2_route, RouteTracker: a node is passed within the radius where the line across the
        way, midway between the edges that meet there, is.
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
        """Whether the last node was reached."""
        return self._passed == len(self._route.nodes)

    def update(self, x: float, y: float) -> bool:
        """Take note of where the robot is; tell whether it has passed a node."""
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
        ways = [np.array(self._graph.nodes[nodes[k + 1]]) - here]
        if k > 0:
            ways.append(here - np.array(self._graph.nodes[nodes[k - 1]]))
        across = sum(way / max(math.hypot(*way), 1e-9) for way in ways)
        return math.hypot(*off) <= self._radius and float(off @ across) >= 0.0
