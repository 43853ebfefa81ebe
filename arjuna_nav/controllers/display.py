"""The display of a controller's work: plain values, of which the server makes messages.

A class of controllers may offer topics by `shows(config)`, the kind of value on each. Before each
`compute` the server sets `wanted`, the topics that somebody listens to; what the controller then
puts into `shown` is published. Poses and points are of the path's frame.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from arjuna_core.arrays import Floats, Singles
from arjuna_core.se2 import SE2
from arjuna_nav.controllers.base import PathController
from arjuna_nav.controllers.plugins import CONTROLLERS


@dataclass(frozen=True)
class Plan:
    """Poses `(N, 3) float64` in order, published as a Path."""

    poses: Floats


@dataclass(frozen=True)
class Target:
    """A pose that is aimed at, published as a PoseStamped."""

    pose: SE2


@dataclass(frozen=True)
class Spot:
    """A point that is aimed at [m], published as a PointStamped a little above the floor."""

    x: float
    y: float


@dataclass(frozen=True)
class Flag:
    """Whether something holds, published as a Bool."""

    on: bool


@dataclass(frozen=True)
class Shape:
    """Points drawn alike, published as a Marker.

    Attributes:
        points: `(N, 2) float64` [m].
        colours: Red, green and blue, 0 to 1: `(3,)`, or `(N, 3)` of each point.
        size: Width of the line, or diameter of each point [m].
        line: Whether a line is drawn along the points, else each by itself.
        lifetime: Of the marker; 0 for ever [s].
    """

    name: str
    points: Floats
    colours: Floats
    size: float
    line: bool = False
    lifetime: float = 0.0


@dataclass(frozen=True)
class Shapes:
    """Shapes, published together as a MarkerArray."""

    shapes: list[Shape]


@dataclass(frozen=True)
class Cloud:
    """Points `(N, 2) float64` [m] with values `(N,)` by name, published as a PointCloud2."""

    points: Floats
    channels: Mapping[str, Singles]


@dataclass(frozen=True)
class Critic:
    """A critic's score of one trajectory; below 0 where it forbids it."""

    name: str
    raw_score: float
    scale: float


@dataclass(frozen=True)
class Judged:
    """A sampled trajectory and its scores, as dwb_msgs/TrajectoryScore has them.

    Attributes:
        velocity: Forward, to the left and of turning [m/s, m/s, rad/s].
        poses: `(N, 3) float64`, the start first.
        times: Of the poses after the start [s].
        scores: By critic.
        total: Below 0 where a critic forbids it.
    """

    velocity: tuple[float, float, float]
    poses: Floats
    times: Floats
    scores: tuple[Critic, ...]
    total: float


@dataclass(frozen=True)
class Evaluation:
    """All sampled trajectories, published as a LocalPlanEvaluation, and two indices."""

    trajectories: tuple[Judged, ...]
    best: int
    worst: int


def topics_of(plugin: str, config: Any) -> Mapping[str, type[Any]]:
    """Return the topics that a class of controllers offers, with the kind of value on each."""
    offers = getattr(CONTROLLERS.resolve(plugin), "shows", None)
    return {} if offers is None else dict(offers(config))


def want(controller: object, topics: frozenset[str]) -> None:
    """Ask a controller for values with its next command; what it showed before is gone."""
    if isinstance(controller, PathController):
        controller.wanted, controller.shown = topics, {}


def shown_by(controller: object) -> dict[str, Any]:
    """Return what a controller has shown since it was asked."""
    return controller.shown if isinstance(controller, PathController) else {}
