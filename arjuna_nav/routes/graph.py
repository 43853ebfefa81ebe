"""A graph of nodes and directed edges, as a GeoJSON file holds it."""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from arjuna_core.errors import InputFileError
from arjuna_core.files.input_file import read_json
from arjuna_core.se2 import IDENTITY, SE2

Point = tuple[float, float]
_IDS = 65536  # as many as nav2_msgs can number
_SHAPES = {"Point", "LineString", "MultiLineString"}
_TRIGGERS = ("NODE", "ON_ENTER", "ON_EXIT")


@dataclass(frozen=True)
class GraphOperation:
    """An operation that a node or an edge asks for.

    Attributes:
        type: Name of the plug-in that performs it.
        trigger: `NODE` where a node is passed, `ON_ENTER` and `ON_EXIT` of an edge.
    """

    type: str
    trigger: str
    metadata: Mapping[str, Any]


@dataclass(frozen=True, eq=False)
class Node:
    """A node at a point [m]; plug-ins read its metadata and may write there."""

    id: int
    x: float
    y: float
    metadata: dict[str, Any] = field(default_factory=dict)
    operations: tuple[GraphOperation, ...] = ()

    @property
    def point(self) -> Point:
        """Its position [m]."""
        return self.x, self.y


@dataclass(frozen=True, eq=False)
class Edge:
    """A directed edge from a node to another; plug-ins read its metadata and may write there.

    Attributes:
        cost: As given in the file, None where it is not.
        overridable: Whether scorers set the cost in place of the given one.
    """

    id: int
    start: Node
    end: Node
    cost: float | None = None
    overridable: bool = True
    metadata: dict[str, Any] = field(default_factory=dict)
    operations: tuple[GraphOperation, ...] = ()

    @cached_property
    def length(self) -> float:
        """Its length [m]."""
        return math.dist(self.start.point, self.end.point)

    @property
    def heading(self) -> float:
        """Its direction [rad]."""
        return math.atan2(self.end.y - self.start.y, self.end.x - self.start.x)


@dataclass(frozen=True)
class Graph:
    """Nodes and edges by number."""

    nodes: dict[int, Node]
    edges: dict[int, Edge]

    def nearest(self, x: float, y: float, count: int = 1) -> list[int]:
        """Return the numbers of so many nodes nearest to a point, the nearest first."""
        gap = {k: math.dist(node.point, (x, y)) for k, node in self.nodes.items()}
        return heapq.nsmallest(count, gap, key=lambda k: (gap[k], k))


def _of_one_frame(target: str, source: str) -> SE2:
    raise ValueError(f"a node lies in '{source}'; valid: '{target}'")


def read_graph(
    path: Path, frame: str, transform: Callable[[str, str], SE2] = _of_one_frame
) -> Graph:
    """Return the graph of a GeoJSON file as nav2_route reads it.

    Args:
        frame: The graph's; nodes of other frames are placed in it.
        transform: Returns the latest `T_target_source` of two frames; by default there is
            one frame. A TransformError of it is passed on.

    Raises:
        InputFileError: It cannot be read, or holds no such graph.
    """
    frames = {frame: IDENTITY}

    def placed(name: str) -> SE2:
        if name not in frames:
            frames[name] = transform(frame, name)
        return frames[name]

    try:
        features = read_json(path)["features"]
        shapes = [(one["geometry"]["type"], one["properties"], one) for one in features]
        nodes = dict(
            _node(about, one, placed(about.get("frame", frame)))
            for kind, about, one in shapes
            if kind == "Point"
        )
        lines = [about for kind, about, _ in shapes if kind in _SHAPES - {"Point"}]
        edges = {edge.id: edge for edge in (_edge(about, nodes) for about in lines)}
    except (ValueError, OverflowError, KeyError, TypeError, AttributeError) as error:
        reason = f"{error} is missing" if isinstance(error, KeyError) else error
        raise InputFileError(path, f"is no route graph: {reason}") from error
    if not nodes:
        raise InputFileError(path, "is no route graph: it has no node, a Point with an 'id'")
    return Graph(nodes, edges)


def _node(about: dict[str, Any], one: dict[str, Any], T_graph_node: SE2) -> tuple[int, Node]:
    number = _number(about["id"], "node")
    x, y = (float(value) for value in one["geometry"]["coordinates"][:2])
    if not (math.isfinite(x) and math.isfinite(y)):
        raise ValueError(f"node {number} lies at ({x}, {y})")
    x, y = T_graph_node.apply(np.array([[x, y]]))[0].tolist()
    return number, Node(number, x, y, *_about(about, f"node {number}"))


def _edge(about: dict[str, Any], nodes: dict[int, Node]) -> Edge:
    number = _number(about["id"], "edge")
    ends = int(about["startid"]), int(about["endid"])
    for end in ends:
        if end not in nodes:
            raise ValueError(f"edge {number} joins node {end}, which does not exist")
    cost = None if about.get("cost") is None else float(about["cost"])
    if cost is not None and not cost >= 0.0:
        raise ValueError(f"edge {number} has cost {cost:g}; valid: at least 0")
    more = _about(about, f"edge {number}")
    joined = nodes[ends[0]], nodes[ends[1]]
    return Edge(number, *joined, cost, bool(about.get("overridable", True)), *more)


def _about(about: dict[str, Any], what: str) -> tuple[dict[str, Any], tuple[GraphOperation, ...]]:
    given = about.get("operations") or {}
    operations = []
    for one in given.values() if isinstance(given, dict) else given:
        kind, trigger = str(one["type"]), one["trigger"]
        if trigger not in _TRIGGERS:
            text = f"{what} has operation '{kind}' with trigger '{trigger}'"
            raise ValueError(f"{text}; valid: {', '.join(_TRIGGERS)}")
        operations.append(GraphOperation(kind, trigger, dict(one.get("metadata") or {})))
    return dict(about.get("metadata") or {}), tuple(operations)


def _number(value: Any, what: str) -> int:
    number = int(value)
    if not 0 <= number < _IDS:
        raise ValueError(f"{what} {number} is out of range; valid: 0 to {_IDS - 1}")
    return number
