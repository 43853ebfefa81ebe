"""Scorers of edges: each adds to what an edge costs, or closes it."""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray

from arjuna_core.config import param
from arjuna_core.errors import ArjunaError, ConfigError
from arjuna_core.plugins import names_in
from arjuna_core.se2 import SE2, wrap
from arjuna_nav.costmap import Costmap
from arjuna_nav.costmap.costmap import UNKNOWN
from arjuna_nav.routes.graph import Edge, Point

fixed = functools.partial(param, read_only=True)
"""Declares a parameter that is fixed once the node runs, as those of nav2_route's plug-ins are."""


class ScorerError(ArjunaError):
    """A scorer cannot be used for what is asked."""


@dataclass(frozen=True, eq=False)
class RouteRequest:
    """A route that is asked for; one object a search.

    Attributes:
        start_node: Number of the first node.
        goal_node: Number of the last.
        start: Where the robot starts, in the graph's frame; None where nodes are asked for.
        goal: Where it is to come, likewise.
        blocked: Numbers of edges that are closed for this route.
    """

    start_node: int
    goal_node: int
    start: SE2 | None = None
    goal: SE2 | None = None
    blocked: frozenset[int] = frozenset()


class RouteScorer(Protocol):
    """Scores edges; made of `(config, name, node)` in the node's `configure`.

    A class has `Config`, the frozen dataclass of its parameters. The node is the route server: its
    `costmap(topic)` returns what reads a costmap, its `costs_changed()` has a route that is tracked
    checked for edges that have been closed.
    """

    def score(self, edge: Edge, request: RouteRequest) -> float | None:
        """Return what the edge costs by this scorer, None where it is closed.

        Raises:
            ArjunaError: It cannot say so; the goal fails.
        """
        ...


def edge_cost(scorers: Sequence[RouteScorer], edge: Edge, request: RouteRequest) -> float | None:
    """Return what an edge costs: the scorers' sum, or its own cost where that is fixed.

    None where it is closed, by a scorer or for this route.

    Raises:
        ArjunaError: It has no valid cost.
    """
    if edge.id in request.blocked:
        return None
    total = 0.0
    for scorer in scorers:
        own = scorer.score(edge, request)
        if own is None:
            return None
        total += own
    if edge.cost is not None and not (edge.overridable and scorers):
        return edge.cost
    if not scorers:
        raise ScorerError(f"edge {edge.id} has no cost, and no edge_cost_functions are listed")
    if not total >= 0.0:
        raise ScorerError(f"edge {edge.id} costs {total:g} in all; valid: at least 0")
    return total


def number(edge: Edge, tag: str, default: float) -> float:
    """Return a number of an edge's metadata.

    Raises:
        ScorerError: It is none.
    """
    value = edge.metadata.get(tag, default)
    if isinstance(value, bool) or not isinstance(value, (int, float)) or math.isnan(value):
        raise ScorerError(f"edge {edge.id} has {tag} {value!r}; valid: a number")
    return float(value)


def speed_share(edge: Edge, tag: str) -> float:
    """Return the share of its speed at which the robot drives an edge, above 0 to 1.

    Up to 1 the metadata is that share, above it is per cent: nav2_route's graphs have both.

    Raises:
        ScorerError: It is not in these bounds.
    """
    limit = number(edge, tag, 1.0)
    if not 0.0 < limit <= 100.0:
        problem = f"edge {edge.id} has {tag} {limit:g}"
        raise ScorerError(f"{problem}; valid: 0 < {tag} <= 1, or per cent up to 100")
    return limit if limit <= 1.0 else limit / 100.0


def _weight() -> Any:
    return fixed(1.0, "Weight of this scorer's costs.", minimum=0.0)


@dataclass(frozen=True)
class DistanceConfig:
    """Parameters of the score by length."""

    weight: float = _weight()
    speed_tag: str = fixed("speed_limit", "Metadata of edges: share of the speed, or per cent.")


class DistanceScorer:
    """Scores the length, by the share of the speed at which the edge is driven.

    Source: nav2_route, DistanceScorer.
    """

    Config: ClassVar[type[Any]] = DistanceConfig

    def __init__(self, config: Any, name: str, node: Any) -> None:
        self._config = config

    def score(self, edge: Edge, request: RouteRequest) -> float:
        """Return the length by the share of the speed [m]."""
        return float(self._config.weight * edge.length / speed_share(edge, self._config.speed_tag))


@dataclass(frozen=True)
class TimeConfig:
    """Parameters of the score by time."""

    weight: float = _weight()
    speed_tag: str = fixed("abs_speed_limit", "Metadata of edges: the speed there [m/s].")
    time_tag: str = fixed("abs_time_taken", "Metadata of edges: the time it took [s].")
    max_vel: float = fixed(0.5, "Speed where no other is given.", unit="m/s", minimum=0.01)


class TimeScorer:
    """Scores the time: what it took the last time, else the length by the speed.

    Source: nav2_route, TimeScorer.
    """

    Config: ClassVar[type[Any]] = TimeConfig

    def __init__(self, config: Any, name: str, node: Any) -> None:
        self._config = config

    def score(self, edge: Edge, request: RouteRequest) -> float:
        """Return the time [s]."""
        config = self._config
        taken, speed = number(edge, config.time_tag, 0.0), number(edge, config.speed_tag, 0.0)
        if taken <= 0.0:
            taken = edge.length / (speed if speed > 0.0 else config.max_vel)
        return float(config.weight * taken)


@dataclass(frozen=True)
class PenaltyConfig:
    """Parameters of the score by penalty."""

    weight: float = _weight()
    penalty_tag: str = fixed("penalty", "Metadata of edges: the penalty.")


class PenaltyScorer:
    """Scores the penalty in the metadata.

    Source: nav2_route, PenaltyScorer.
    """

    Config: ClassVar[type[Any]] = PenaltyConfig

    def __init__(self, config: Any, name: str, node: Any) -> None:
        self._config = config

    def score(self, edge: Edge, request: RouteRequest) -> float:
        """Return the penalty, 0 without one."""
        return float(self._config.weight * number(edge, self._config.penalty_tag, 0.0))


@dataclass(frozen=True)
class SemanticConfig:
    """Parameters of the score by semantic classes; each class's cost has its name."""

    weight: float = _weight()
    semantic_classes: tuple[str, ...] = fixed((), "Classes that have a cost.")
    semantic_key: str = fixed("class", "Metadata that names the class; empty: any key's name does.")


@functools.cache
def _with_classes(names: tuple[str, ...]) -> type[Any]:
    own = {item.name for item in dataclasses.fields(SemanticConfig)} | {"plugin"}
    for name in names:
        if not name.isidentifier() or name in own:
            raise ConfigError(f"semantic class '{name}' cannot be a parameter's name")
    fields = [(name, float, fixed(0.0, f"Cost of class {name}.")) for name in names]
    return dataclasses.make_dataclass(
        "SemanticConfig", fields, bases=(SemanticConfig,), frozen=True
    )


class SemanticScorer:
    """Scores the classes of an edge and of the node at its end.

    Source: nav2_route, SemanticScorer.
    """

    Config: ClassVar[type[Any]] = SemanticConfig

    @staticmethod
    def config_for(values: Mapping[str, Any]) -> type[Any]:
        """Return the parameters, with one for the cost of each class that the values name.

        Raises:
            ConfigError: A class's name cannot be a parameter's.
        """
        return _with_classes(tuple(dict.fromkeys(names_in(values.get("semantic_classes")))))

    def __init__(self, config: Any, name: str, node: Any) -> None:
        self._config = config
        self._costs = {one: float(getattr(config, one)) for one in config.semantic_classes}

    def score(self, edge: Edge, request: RouteRequest) -> float:
        """Return the sum of the costs of both."""
        key, total = self._config.semantic_key, 0.0
        for metadata in (edge.end.metadata, edge.metadata):
            classes = [str(metadata.get(key, ""))] if key else list(metadata)
            total += sum(self._costs.get(one, 0.0) for one in classes)
        return float(self._config.weight * total)


@dataclass(frozen=True)
class OrientationConfig:
    """Parameters of the scores by the robot's heading at one end."""

    orientation_weight: float = fixed(1.0, "Cost of a difference of heading.", minimum=0.0)
    use_orientation_threshold: bool = fixed(False, "Whether edges beyond the tolerance are closed.")
    orientation_tolerance: float = fixed(
        math.pi / 2.0, "Greatest difference of heading.", unit="rad", minimum=0.0, maximum=math.pi
    )


class StartPoseOrientationScorer:
    """Scores how far the heading of a route's first edge is from that of its start.

    Source: nav2_route, StartPoseOrientationScorer.
    """

    Config: ClassVar[type[Any]] = OrientationConfig

    def __init__(self, config: Any, name: str, node: Any) -> None:
        self._config = config

    def _at_end(self, edge: Edge, request: RouteRequest) -> tuple[bool, SE2 | None]:
        return edge.start.id == request.start_node, request.start

    def score(self, edge: Edge, request: RouteRequest) -> float | None:
        """Return the difference [rad], None beyond the tolerance; 0 for the other edges."""
        config, (at_end, pose) = self._config, self._at_end(edge, request)
        if pose is None:
            raise ScorerError(f"{type(self).__name__} needs a goal with use_poses: true")
        off = abs(wrap(edge.heading - pose.theta))
        if not at_end:
            return 0.0
        if config.use_orientation_threshold and off > config.orientation_tolerance:
            return None
        return float(config.orientation_weight * off)


class GoalOrientationScorer(StartPoseOrientationScorer):
    """Scores how far the heading of a route's last edge is from that of its goal.

    Source: nav2_route, GoalOrientationScorer.
    """

    def _at_end(self, edge: Edge, request: RouteRequest) -> tuple[bool, SE2 | None]:
        return edge.end.id == request.goal_node, request.goal


def costs_on_line(
    costmap: Costmap, start: Point, end: Point, every: int
) -> tuple[NDArray[np.uint8], bool]:
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


def costmap_topic(default: str) -> Any:
    """Declare the topic of a costmap."""
    return fixed(default, "Topic of the costmap, a nav2_msgs/Costmap.")


def max_cost() -> Any:
    """Declare the cost that blocks an edge."""
    return fixed(253.0, "Cost that blocks an edge.", minimum=1.0, maximum=255.0)


def check_resolution(default: int) -> Any:
    """Declare how many cells apart costs are looked at."""
    return fixed(default, "Every how many cells an edge is looked at.", minimum=1)


@dataclass(frozen=True)
class CostmapScorerConfig:
    """Parameters of the score by a costmap."""

    weight: float = _weight()
    costmap_topic: str = costmap_topic("global_costmap/costmap_raw")
    use_maximum: bool = fixed(True, "Whether the greatest cost counts, else the mean.")
    invalid_on_collision: bool = fixed(True, "Whether an edge that is blocked is closed.")
    invalid_off_map: bool = fixed(True, "Whether an edge that leaves the costmap is closed.")
    max_cost: float = max_cost()
    check_resolution: int = check_resolution(2)


class CostmapScorer:
    """Scores what a costmap has along the edge, as a share of the cost that blocks it.

    Source: nav2_route, CostmapScorer: unknown cells block, unless the cost to block is theirs.
    """

    Config: ClassVar[type[Any]] = CostmapScorerConfig

    def __init__(self, config: Any, name: str, node: Any) -> None:
        self._config = config
        self._read: Callable[[], Costmap | None] = node.costmap(config.costmap_topic)
        self._request: RouteRequest | None = None
        self._costmap: Costmap | None = None

    def score(self, edge: Edge, request: RouteRequest) -> float | None:
        """Return the share, None where the edge is closed, as all are without a costmap."""
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
