"""A graph of nodes and directed edges, as a GeoJSON file holds it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from arjuna_core.errors import InputFileError
from arjuna_core.files.input_file import read_json

Point = tuple[float, float]
_IDS = 65536  # as many as nav2_msgs can number
_SHAPES = {"Point", "LineString", "MultiLineString"}


@dataclass(frozen=True)
class Edge:
    """A directed edge from a node to another.

    Attributes:
        id: Its number.
        start: Number of the node it leaves.
        end: Number of the node it comes to.
        cost: As given, None where it follows from its length.
        length: [m]
        speed_limit: The share of its speed at which the robot drives here.
        penalty: Added to that.
    """

    id: int
    start: int
    end: int
    cost: float | None
    length: float
    speed_limit: float = 1.0
    penalty: float = 0.0

    @property
    def total_cost(self) -> float:
        """The given cost, or the length by the speed's share, and the penalty.

        Source: nav2_route's DistanceScorer and PenaltyScorer.
        """
        if self.cost is not None:
            return self.cost
        return self.length / self.speed_limit + self.penalty


@dataclass(frozen=True)
class Graph:
    """Nodes by number `(x, y)` [m], and edges by number."""

    nodes: dict[int, Point]
    edges: dict[int, Edge]

    def nearest(self, x: float, y: float) -> int:
        """Return the number of the node nearest to a point."""
        return min(self.nodes, key=lambda k: (math.dist(self.nodes[k], (x, y)), k))


def read_graph(path: Path, frame: str) -> Graph:
    """Return the graph of a GeoJSON file as nav2_route reads it.

    Raises:
        InputFileError: It cannot be read, or holds no such graph.
    """
    try:
        features = read_json(path)["features"]
        shapes = [(one["geometry"]["type"], one["properties"], one) for one in features]
        nodes = dict(_node(about, one, frame) for kind, about, one in shapes if kind == "Point")
        lines = [about for kind, about, _ in shapes if kind in _SHAPES - {"Point"}]
        edges = {edge.id: edge for edge in (_edge(about, nodes) for about in lines)}
    except (ValueError, OverflowError, KeyError, TypeError, AttributeError) as error:
        raise InputFileError(path, f"is no route graph: {_reason(error)}") from error
    if not nodes:
        raise InputFileError(path, "is no route graph: it has no node, a Point with an 'id'")
    return Graph(nodes, edges)


def _reason(error: Exception) -> str:
    return f"{error} is missing" if isinstance(error, KeyError) else str(error)


def _node(about: dict[str, Any], one: dict[str, Any], frame: str) -> tuple[int, Point]:
    number = _number(about["id"], "node")
    if about.get("frame", frame) != frame:
        raise ValueError(f"node {number} lies in '{about['frame']}'; valid: '{frame}'")
    x, y = (float(value) for value in one["geometry"]["coordinates"][:2])
    if not (math.isfinite(x) and math.isfinite(y)):
        raise ValueError(f"node {number} lies at ({x}, {y})")
    return number, (x, y)


def _edge(about: dict[str, Any], nodes: dict[int, Point]) -> Edge:
    number = _number(about["id"], "edge")
    ends = int(about["startid"]), int(about["endid"])
    for end in ends:
        if end not in nodes:
            raise ValueError(f"edge {number} joins node {end}, which does not exist")
    fixed = about.get("cost") if not about.get("overridable", True) else None
    more = about.get("metadata", {})
    limit, penalty = float(more.get("speed_limit", 1.0)), float(more.get("penalty", 0.0))
    cost = None if fixed is None else float(fixed)
    if not 0.0 < limit <= 1.0 or not penalty >= 0.0 or (cost is not None and not cost >= 0.0):
        problem = f"speed_limit {limit:g}, penalty {penalty:g}, cost {cost}"
        raise ValueError(f"edge {number} has {problem}; valid: 0 < speed_limit <= 1, others >= 0")
    return Edge(number, *ends, cost, math.dist(nodes[ends[0]], nodes[ends[1]]), limit, penalty)


def _number(value: Any, what: str) -> int:
    number = int(value)
    if not 0 <= number < _IDS:
        raise ValueError(f"{what} {number} is out of range; valid: 0 to {_IDS - 1}")
    return number
