"""Scorers of edges: each adds to what an edge costs, or closes it.

Source: nav2_route's scorers of the same names.
"""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Protocol

from arjuna_core.config import fixed
from arjuna_core.errors import ArjunaError, ConfigError
from arjuna_core.plugins import names_in
from arjuna_core.se2 import SE2, wrap
from arjuna_nav.routes.graph import Edge


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
    `costmap(topic)` returns what reads a costmap; its `edges_closed(edges)` has a route that leads
    over one of them left.
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
    value = edge.metadata.get(tag)
    if value is None:
        return default
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


@dataclass(frozen=True)
class WeightConfig:
    """Parameters of any score."""

    weight: float = fixed(1.0, "Weight of this scorer's costs.", minimum=0.0)


class Scorer:
    """A scorer that needs its parameters alone."""

    Config: ClassVar[type[Any]] = WeightConfig

    def __init__(self, config: Any, name: str, node: Any) -> None:
        self._config = config


@dataclass(frozen=True)
class DistanceConfig(WeightConfig):
    """Parameters of the score by length."""

    speed_tag: str = fixed("speed_limit", "Metadata of edges: share of the speed, or per cent.")


class DistanceScorer(Scorer):
    """Scores the length [m], by the share of the speed at which the edge is driven."""

    Config = DistanceConfig

    def score(self, edge: Edge, request: RouteRequest) -> float:
        return float(self._config.weight * edge.length / speed_share(edge, self._config.speed_tag))


@dataclass(frozen=True)
class TimeConfig(WeightConfig):
    """Parameters of the score by time."""

    speed_tag: str = fixed("abs_speed_limit", "Metadata of edges: the speed there [m/s].")
    time_tag: str = fixed("abs_time_taken", "Metadata of edges: the time it took [s].")
    max_vel: float = fixed(0.5, "Speed where no other is given.", unit="m/s", minimum=0.01)


class TimeScorer(Scorer):
    """Scores the time [s]: what it took the last time, else the length by the speed."""

    Config = TimeConfig

    def score(self, edge: Edge, request: RouteRequest) -> float:
        config = self._config
        taken, speed = number(edge, config.time_tag, 0.0), number(edge, config.speed_tag, 0.0)
        if taken <= 0.0:
            taken = edge.length / (speed if speed > 0.0 else config.max_vel)
        return float(config.weight * taken)


@dataclass(frozen=True)
class PenaltyConfig(WeightConfig):
    """Parameters of the score by penalty."""

    penalty_tag: str = fixed("penalty", "Metadata of edges: the penalty.")


class PenaltyScorer(Scorer):
    """Scores the penalty in the metadata, 0 without one."""

    Config = PenaltyConfig

    def score(self, edge: Edge, request: RouteRequest) -> float:
        return float(self._config.weight * number(edge, self._config.penalty_tag, 0.0))


@dataclass(frozen=True)
class SemanticConfig(WeightConfig):
    """Parameters of the score by semantic classes; each class's cost has its name."""

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


class SemanticScorer(Scorer):
    """Scores the classes of an edge and of the node at its end: the sum of their costs."""

    Config = SemanticConfig

    @staticmethod
    def config_for(values: Mapping[str, Any]) -> type[Any]:
        """Return the parameters, with one for the cost of each class that the values name.

        Raises:
            ConfigError: A class's name cannot be a parameter's.
        """
        return _with_classes(tuple(dict.fromkeys(names_in(values.get("semantic_classes")))))

    def score(self, edge: Edge, request: RouteRequest) -> float:
        config, found = self._config, list[str]()
        for metadata in (edge.end.metadata, edge.metadata):
            key = config.semantic_key
            found += [str(metadata.get(key, ""))] if key else list(metadata)
        costs = (getattr(config, one) for one in found if one in config.semantic_classes)
        return float(config.weight * sum(costs))


@dataclass(frozen=True)
class OrientationConfig:
    """Parameters of the scores by the robot's heading at one end."""

    orientation_weight: float = fixed(1.0, "Cost of a difference of heading.", minimum=0.0)
    use_orientation_threshold: bool = fixed(False, "Whether edges beyond the tolerance are closed.")
    orientation_tolerance: float = fixed(
        math.pi / 2.0, "Greatest difference of heading.", unit="rad", minimum=0.0
    )


class StartPoseOrientationScorer(Scorer):
    """Scores how far the heading of a route's first edge is from that of its start [rad]."""

    Config = OrientationConfig

    def _at_end(self, edge: Edge, request: RouteRequest) -> tuple[bool, SE2 | None]:
        return edge.start.id == request.start_node, request.start

    def score(self, edge: Edge, request: RouteRequest) -> float | None:
        config, (at_end, pose) = self._config, self._at_end(edge, request)
        if pose is None:
            raise ScorerError(f"{type(self).__name__} needs a goal with use_poses: true")
        off = abs(wrap(edge.heading - pose.theta)) if at_end else 0.0
        if config.use_orientation_threshold and off > config.orientation_tolerance:
            return None
        return float(config.orientation_weight * off)


class GoalOrientationScorer(StartPoseOrientationScorer):
    """Scores how far the heading of a route's last edge is from that of its goal [rad]."""

    def _at_end(self, edge: Edge, request: RouteRequest) -> tuple[bool, SE2 | None]:
        return edge.end.id == request.goal_node, request.goal
