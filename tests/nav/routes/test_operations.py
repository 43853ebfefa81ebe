"""Operations: which are performed when, what they ask for together, those that need no ROS."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from arjuna_core.config import load
from arjuna_core.grid import GridFrame
from arjuna_core.se2 import SE2
from arjuna_nav.costmap import Costmap
from arjuna_nav.routes import operations
from arjuna_nav.routes.graph import Edge, GraphOperation, Node
from arjuna_nav.routes.operations import OperationError, OperationResult, RouteEvent, perform


def asking(*triggers: str) -> tuple[GraphOperation, ...]:
    return tuple(GraphOperation("Bell", trigger, {"at": trigger}) for trigger in triggers)


ALL = ("NODE", "ON_ENTER", "ON_EXIT")
NODES = [Node(k, 4.0 * k, 0.0, operations=asking(*ALL)) for k in range(4)]
EDGES = [Edge(10 + k, NODES[k], NODES[k + 1], operations=asking(*ALL)) for k in range(3)]


def event(x: float = 0.0, passed: int | None = None, at: int = 0, **more: Any) -> RouteEvent:
    """Return a look at the robot on an edge, or where it has just passed a node."""
    edges = [None, *EDGES, None]
    about = {"now": 0.0, "began": 0.0, "pose": SE2(x), "edge": EDGES[at], **more}
    if passed is not None:
        about |= {"node": NODES[passed], "entered": edges[passed + 1], "exited": edges[passed]}
    return RouteEvent(ahead=tuple(EDGES[at + 1 :]), **about)


def made(name: str, values: dict[str, Any], costmap: Any = None) -> Any:
    cls = getattr(operations, name)
    node = SimpleNamespace(costmap=lambda topic: lambda: costmap)
    return cls(load(cls.Config, values), name, node)


class Played:
    """Returns the same result always, and keeps what it was called with."""

    def __init__(self, result: OperationResult | None = None) -> None:
        self.result = result
        self.called: list[Any] = []

    def perform(self, event: RouteEvent) -> OperationResult | None:
        self.called.append(event.called)
        return self.result


@pytest.mark.parametrize(
    ("passed", "called"),
    [
        (None, [None]),
        (0, [{"at": "NODE"}, {"at": "ON_ENTER"}]),
        (1, [{"at": "NODE"}, {"at": "ON_ENTER"}, {"at": "ON_EXIT"}]),
        (3, [{"at": "NODE"}, {"at": "ON_EXIT"}]),
    ],
)
def test_the_graph_asks_at_nodes_and_where_edges_begin_and_end(
    passed: int | None, called: list[Any]
) -> None:
    bell, other = Played(), Played()
    names, result = perform({"Other": other, "Bell": bell}, event(passed=passed))
    assert (bell.called, other.called) == (called, [None])
    assert names == ["Bell"] * len([one for one in called if one is not None])
    assert result == OperationResult()


def test_the_graph_cannot_ask_for_what_does_not_exist() -> None:
    with pytest.raises(OperationError, match="asks for operation Bell; operations: Other"):
        perform({"Other": Played()}, event(passed=0))


def test_what_operations_ask_for_counts_together() -> None:
    played = {
        "A": Played(OperationResult(reroute=True, blocked=frozenset({1}))),
        "B": Played(OperationResult(blocked=frozenset({2}))),
        "C": Played(OperationResult(pending=True)),
        "D": Played(),
    }
    names, result = perform(played, event())
    assert names == ["A", "B"], "one that waits has done nothing yet"
    assert result == OperationResult(True, frozenset({1, 2}), pending=True)


@pytest.mark.parametrize(
    ("looks", "taken"),
    [
        (((2.0, 0), (7.5, 1)), 5.5),
        (((2.0, 0), (4.0, None), (7.5, 1)), 5.5),
        (((2.0, 1), (7.5, 3)), None),
        (((7.5, 1),), None),
    ],
)
def test_the_time_of_an_edge_driven_from_end_to_end_is_noted(
    looks: tuple[tuple[float, int | None], ...], taken: float | None
) -> None:
    EDGES[0].metadata.clear()
    marker = made("TimeMarker", {"time_tag": "t"})
    done = [marker.perform(event(passed=passed, now=now)) for now, passed in looks]
    assert EDGES[0].metadata.get("t") == taken
    assert (done[-1] is not None) == (taken is not None)


def test_the_time_of_an_edge_that_another_goal_entered_is_not_noted() -> None:
    EDGES[0].metadata.clear()
    marker = made("TimeMarker", {})
    marker.perform(event(passed=0, now=2.0))
    marker.perform(event(passed=1, now=9.0, began=5.0))
    assert EDGES[0].metadata == {}


def row(obstacle: float, cost: int = 254, width: int = 26) -> Costmap:
    """Return a costmap of half-metre cells along the edges with a cost at a distance [m]."""
    frame = GridFrame(0.5, width, 2, SE2(-0.5, -0.5))
    costmap = Costmap(frame, np.zeros(frame.shape, np.uint8))
    costmap.data[:, int((obstacle + 0.5) / 0.5)] = cost
    return costmap


@pytest.mark.parametrize(
    ("values", "costmap", "x", "blocked"),
    [
        ({}, row(3.0), 1.0, 10),
        ({}, row(3.0), 3.7, None),
        ({}, row(5.0), 1.0, 11),
        ({}, row(7.0), 1.0, None),
        ({"max_collision_dist": 7.0}, row(7.0), 1.0, 11),
        ({"max_collision_dist": 0.0}, row(11.0), 1.0, 12),
        ({}, row(3.0, 252), 1.0, None),
        ({"max_cost": 200.0}, row(3.0, 252), 1.0, 10),
        ({"max_cost": 200.0}, row(3.0, 255), 1.0, None),
        ({"check_resolution": 2}, row(2.5), 1.0, None),
        ({"check_resolution": 2}, row(3.0), 1.0, 10),
        ({"max_collision_dist": 0.0}, row(2.0, 0, width=8), 1.0, None),
    ],
)
def test_an_obstacle_ahead_blocks_its_edge(
    values: dict[str, Any], costmap: Costmap, x: float, blocked: int | None
) -> None:
    result = made("CollisionMonitor", values, costmap).perform(event(x, now=1.0))
    expected = OperationResult(reroute=True, blocked=frozenset({blocked}))  # type: ignore[arg-type]
    assert result == (None if blocked is None else expected)


def test_the_route_is_looked_at_as_often_as_the_rate_says_and_on_it_only() -> None:
    monitor = made("CollisionMonitor", {"rate": 0.5}, row(3.0))
    times = (1.0, 1.5, 2.5, 3.9, 4.1)
    seen = [now for now in times if monitor.perform(event(now=now)) is not None]
    assert seen == [1.0, 2.5, 4.1]
    assert monitor.perform(event(now=9.0, edge=None)) is None


@pytest.mark.parametrize(
    ("values", "costmap", "text"),
    [
        ({"costmap_topic": "c"}, None, "no costmap to see the route by on c"),
        ({"reroute_on_collision": False}, row(3.0), "edge 10 is blocked, and reroute_on_coll"),
    ],
)
def test_says_why_the_route_cannot_be_driven(
    values: dict[str, Any], costmap: Costmap | None, text: str
) -> None:
    with pytest.raises(OperationError, match=text):
        made("CollisionMonitor", values, costmap).perform(event(now=1.0))
