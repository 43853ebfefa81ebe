"""Scorers: what an edge costs by each, where it is closed, what cannot be scored."""

from __future__ import annotations

import math
from typing import Any

import pytest

from arjuna_core.config import load
from arjuna_core.errors import ConfigError
from arjuna_core.se2 import SE2
from arjuna_nav.routes import scorers
from arjuna_nav.routes.graph import Edge, Node
from arjuna_nav.routes.scorers import RouteRequest, ScorerError, edge_cost

REQUEST = RouteRequest(0, 1, SE2(0.0, 0.0, 0.5), SE2(4.0, 0.0, -2.0))
NO_POSES = RouteRequest(0, 1)


def along_x(
    cost: float | None = None, overridable: bool = True, x: float = 4.0, **metadata: Any
) -> Edge:
    """Return the edge from node 0 in the origin to node 1, an office."""
    ends = Node(0, 0.0, 0.0), Node(1, x, 0.0, {"class": "office", "bumpy": 1})
    return Edge(5, *ends, cost, overridable, metadata)


def made(name: str, values: dict[str, Any]) -> Any:
    cls = getattr(scorers, name)
    config = cls.config_for(values) if hasattr(cls, "config_for") else cls.Config
    return cls(load(config, values), name, None)


OFFICE: dict[str, Any] = {"class": "office"}
BUMPY: dict[str, Any] = {"class": "bumpy"}
CLASSES = {"semantic_classes": ["office", "bumpy"], "office": 3.0, "bumpy": 7.0}
TOLERANT = {"use_orientation_threshold": True, "orientation_tolerance": 0.6}
STRICT = {"use_orientation_threshold": True, "orientation_tolerance": 0.4}


@pytest.mark.parametrize(
    ("name", "values", "edge", "cost"),
    [
        ("DistanceScorer", {}, along_x(), 4.0),
        ("DistanceScorer", {}, along_x(speed_limit=0.5), 8.0),
        ("DistanceScorer", {}, along_x(speed_limit=50), 8.0),
        ("DistanceScorer", {"weight": 3.0, "speed_tag": "slow"}, along_x(slow=0.25), 48.0),
        ("TimeScorer", {}, along_x(), 8.0),
        ("TimeScorer", {"max_vel": 2.0, "weight": 3.0}, along_x(), 6.0),
        ("TimeScorer", {}, along_x(abs_speed_limit=0.25), 16.0),
        ("TimeScorer", {"speed_tag": "v"}, along_x(v=4.0), 1.0),
        ("TimeScorer", {}, along_x(abs_speed_limit=0.25, abs_time_taken=5.0), 5.0),
        ("TimeScorer", {"time_tag": "t"}, along_x(t=6.0), 6.0),
        ("PenaltyScorer", {}, along_x(), 0.0),
        ("PenaltyScorer", {"weight": 2.0}, along_x(penalty=3.0), 6.0),
        ("PenaltyScorer", {"penalty_tag": "risk"}, along_x(penalty=3.0, risk=1.0), 1.0),
        ("SemanticScorer", {}, along_x(**OFFICE), 0.0),
        ("SemanticScorer", CLASSES, along_x(**BUMPY), 10.0),
        ("SemanticScorer", {**CLASSES, "weight": 2.0}, along_x(), 6.0),
        ("SemanticScorer", {**CLASSES, "semantic_key": "floor"}, along_x(floor="office"), 3.0),
        ("SemanticScorer", {**CLASSES, "semantic_key": ""}, along_x(office=0), 10.0),
        ("StartPoseOrientationScorer", {}, along_x(), 0.5),
        ("StartPoseOrientationScorer", {"orientation_weight": 4.0}, along_x(), 2.0),
        ("StartPoseOrientationScorer", TOLERANT, along_x(), 0.5),
        ("StartPoseOrientationScorer", STRICT, along_x(), None),
        ("GoalOrientationScorer", {}, along_x(), 2.0),
        ("GoalOrientationScorer", {"use_orientation_threshold": True}, along_x(), None),
    ],
)
def test_an_edge_costs(name: str, values: dict[str, Any], edge: Edge, cost: float | None) -> None:
    assert made(name, values).score(edge, REQUEST) == pytest.approx(cost)


@pytest.mark.parametrize(
    ("name", "edge", "request_", "text"),
    [
        ("DistanceScorer", along_x(speed_limit=0.0), REQUEST, "edge 5 has speed_limit 0; valid"),
        ("DistanceScorer", along_x(speed_limit=101), REQUEST, "edge 5 has speed_limit 101; valid"),
        ("PenaltyScorer", along_x(penalty="much"), REQUEST, "has penalty 'much'; valid: a number"),
        ("PenaltyScorer", along_x(penalty=math.nan), REQUEST, "has penalty nan; valid: a number"),
        ("StartPoseOrientationScorer", along_x(), NO_POSES, "needs a goal with use_poses: true"),
        ("GoalOrientationScorer", along_x(), NO_POSES, "needs a goal with use_poses: true"),
    ],
)
def test_says_what_cannot_be_scored(
    name: str, edge: Edge, request_: RouteRequest, text: str
) -> None:
    with pytest.raises(ScorerError, match=text):
        made(name, {}).score(edge, request_)


@pytest.mark.parametrize(
    ("values", "text"),
    [
        ({"semantic_classes": ["work cell"]}, "semantic class 'work cell' cannot be"),
        ({"semantic_classes": ["weight"]}, "semantic class 'weight' cannot be"),
        ({"hall": 2.0}, "unknown parameter 'hall'"),
    ],
)
def test_says_which_class_cannot_have_a_cost(values: dict[str, Any], text: str) -> None:
    with pytest.raises(ConfigError, match=text):
        made("SemanticScorer", values)


BOTH = ("DistanceScorer", "PenaltyScorer")


@pytest.mark.parametrize(
    ("names", "edge", "cost"),
    [
        (BOTH, along_x(penalty=2.0), 6.0),
        (BOTH, along_x(penalty=-3.0), 1.0),
        (BOTH, along_x(cost=9.0, penalty=2.0), 6.0),
        (BOTH, along_x(cost=9.0, overridable=False), 9.0),
        (BOTH, along_x(overridable=False), 4.0),
        ((), along_x(cost=9.0), 9.0),
    ],
)
def test_costs_add_up_unless_one_is_fixed(names: tuple[str, ...], edge: Edge, cost: float) -> None:
    assert edge_cost([made(name, {}) for name in names], edge, REQUEST) == cost


def test_what_a_scorer_or_the_request_closes_is_closed_with_a_fixed_cost_too() -> None:
    closing = made("StartPoseOrientationScorer", STRICT)
    fixed = along_x(cost=1.0, overridable=False)
    assert edge_cost([made("DistanceScorer", {}), closing], fixed, REQUEST) is None
    assert edge_cost([], fixed, RouteRequest(0, 1, blocked=frozenset({5}))) is None


@pytest.mark.parametrize(
    ("names", "edge", "text"),
    [
        (BOTH, along_x(penalty=-5.0), "edge 5 costs -1 in all; valid: at least 0"),
        ((), along_x(), "edge 5 has no cost, and no edge_cost_functions are listed"),
    ],
)
def test_says_which_edge_has_no_cost(names: tuple[str, ...], edge: Edge, text: str) -> None:
    with pytest.raises(ScorerError, match=text):
        edge_cost([made(name, {}) for name in names], edge, REQUEST)
