"""Graphs on a costmap: edges' scores, obstacles on them, nodes behind walls.

Source: nav2_route, CostmapScorer and CollisionMonitor.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from arjuna_core.arrays import Bytes
from arjuna_core.config import fixed
from arjuna_core.timing import Periodic
from arjuna_nav.costmap import Costmap
from arjuna_nav.costmap.costmap import INSCRIBED, UNKNOWN
from arjuna_nav.planners.waves.potential import traversal_costs, wavefront
from arjuna_nav.routes.graph import Edge, Graph, Point
from arjuna_nav.routes.operations import OperationError, OperationResult, RouteEvent
from arjuna_nav.routes.route import along_edge
from arjuna_nav.routes.scorers import RouteRequest, Scorer, WeightConfig


def costs_on_line(costmap: Costmap, start: Point, end: Point, every: int) -> tuple[Bytes, bool]:
    """Return the costs of every n-th cell between two points, and whether all are on the map.

    Those behind the first that is not are left out.
    """
    first, last = costmap.frame.to_cells(np.array([start, end]))
    steps = int(np.abs(last - first).max())
    cells = np.rint(np.linspace(first, last, steps + 1)).astype(np.int64)[::every]
    inside = costmap.frame.inside(cells)
    known = len(cells) if inside.all() else int(inside.argmin())
    rows, columns = cells[:known].T
    return costmap.data[rows, columns], known == len(cells)


def nearest_node(graph: Graph, point: Point, costmap: Costmap | None, count: int) -> int:
    """Return the number of the node nearest to a point.

    Where an obstacle lies between, it is that of `count` nodes to which the drive is shortest.

    Source: nav2_route, GoalIntentExtractor::findStartandGoal.
    """
    near = graph.nearest(*point, count)
    points = [point, *(graph.nodes[one].point for one in near)]
    if costmap is None or len(near) < 2:
        return near[0]
    costs, _ = costs_on_line(costmap, point, points[1], 1)
    inside = costmap.frame.inside(cells := costmap.frame.to_cells(np.array(points)))
    if not inside[0] or not ((costs >= INSCRIBED) & (costs != UNKNOWN)).any():
        return near[0]
    drive = wavefront(costmap.data, traversal_costs(), np.array([[*cells[0], 0.0]]))
    lengths = np.full(len(near), np.inf)
    lengths[inside[1:]] = drive[tuple(cells[1:][inside[1:]].T)]
    return near[int(lengths.argmin())]


@dataclass(frozen=True)
class CostmapScorerConfig(WeightConfig):
    """Parameters of the score by a costmap."""

    costmap_topic: str = fixed("global_costmap/costmap_raw", "Topic of the nav2_msgs/Costmap.")
    use_maximum: bool = fixed(True, "Whether the greatest cost counts, else the mean.")
    invalid_on_collision: bool = fixed(True, "Whether an edge that is blocked is closed.")
    invalid_off_map: bool = fixed(True, "Whether an edge that leaves the costmap is closed.")
    max_cost: float = fixed(253.0, "Cost that blocks an edge.", minimum=1.0, maximum=255.0)
    check_resolution: int = fixed(2, "Every how many cells an edge is looked at.", minimum=1)


class CostmapScorer(Scorer):
    """Scores what a costmap has along the edge, as a share of the cost that blocks it.

    Unknown cells block, unless that cost is theirs.
    """

    Config = CostmapScorerConfig

    def __init__(self, config: Any, name: str, node: Any) -> None:
        self._config = config
        self._read: Callable[[], Costmap | None] = node.costmap(config.costmap_topic)
        self._request: RouteRequest | None = None
        self._costmap: Costmap | None = None

    def score(self, edge: Edge, request: RouteRequest) -> float | None:
        config = self._config
        if request is not self._request:
            self._request, self._costmap = request, self._read()
        if self._costmap is None:
            return None
        ends = edge.start.point, edge.end.point
        costs, whole = costs_on_line(self._costmap, *ends, config.check_resolution)
        if not whole:
            return None if config.invalid_off_map else 0.0
        blocks = config.invalid_on_collision and config.max_cost < UNKNOWN
        if blocks and (costs >= config.max_cost).any():
            return None
        known = costs[costs < UNKNOWN]
        cost = known.max(initial=0) if config.use_maximum else costs.mean()
        return float(config.weight * cost / config.max_cost)


@dataclass(frozen=True)
class CollisionMonitorConfig:
    """Parameters of the watch over the route ahead."""

    costmap_topic: str = fixed("local_costmap/costmap_raw", "Topic of the nav2_msgs/Costmap.")
    rate: float = fixed(1.0, "How often the route is looked at.", unit="Hz", minimum=0.01)
    max_cost: float = fixed(253.0, "Cost that blocks an edge.", minimum=1.0, maximum=255.0)
    max_collision_dist: float = fixed(
        5.0, "How far ahead; 0 or less: to the end.", unit="m", minimum=-1.0
    )
    check_resolution: int = fixed(1, "Every how many cells an edge is looked at.", minimum=1)
    reroute_on_collision: bool = fixed(True, "Whether it asks for another route, else it fails.")


class CollisionMonitor:
    """Asks for another route where a costmap shows an obstacle ahead; unknown cells are none."""

    Config: ClassVar[type[Any]] = CollisionMonitorConfig

    def __init__(self, config: Any, name: str, node: Any) -> None:
        self._config = config
        self._read: Callable[[], Costmap | None] = node.costmap(config.costmap_topic)
        self._due = Periodic(1.0 / config.rate)

    def perform(self, event: RouteEvent) -> OperationResult | None:
        if event.edge is None or not self._due.due(event.now):
            return None
        costmap, config = self._read(), self._config
        if costmap is None:
            raise OperationError(f"no costmap to see the route by on {config.costmap_topic}")
        blocked = self._blocked(costmap, event)
        if blocked is None:
            return None
        if not config.reroute_on_collision:
            raise OperationError(f"edge {blocked} is blocked, and reroute_on_collision is false")
        return OperationResult(reroute=True, blocked=frozenset({blocked}))

    def _blocked(self, costmap: Costmap, event: RouteEvent) -> int | None:
        """Return the number of the first edge with an obstacle; None where there is none."""
        config = self._config
        remaining = config.max_collision_dist if config.max_collision_dist > 0.0 else math.inf
        for edge in (event.edge, *event.ahead):
            if edge is None or remaining <= 0.0:
                break
            here = event.pose.x, event.pose.y
            along = along_edge(edge, here)[0] if edge is event.edge else 0.0
            until = min(edge.length, along + remaining)
            ends = _point_on(edge, along), _point_on(edge, until)
            costs, _ = costs_on_line(costmap, *ends, config.check_resolution)
            if ((costs >= config.max_cost) & (costs != UNKNOWN)).any():
                return edge.id
            remaining -= until - along
        return None


def _point_on(edge: Edge, along: float) -> Point:
    ratio = along / max(edge.length, 1e-9)
    start, end = edge.start, edge.end
    return start.x + ratio * (end.x - start.x), start.y + ratio * (end.y - start.y)
