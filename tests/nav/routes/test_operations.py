"""Operations: which are performed when, what they ask for together, those that need no ROS."""

from __future__ import annotations

from typing import Any

import pytest

from arjuna_core.config import load
from arjuna_core.se2 import SE2
from arjuna_nav.routes.graph import Edge, GraphOperation, Node
from arjuna_nav.routes.operations import (
    OperationError,
    OperationResult,
    RouteEvent,
    TimeMarker,
    TimeMarkerConfig,
    perform,
)


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


def marker(**values: Any) -> TimeMarker:
    return TimeMarker(load(TimeMarkerConfig, values), "TimeMarker", None)


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
def test_operations_run_at_nodes_and_ends_of_edges(passed: int | None, called: list[Any]) -> None:
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
        "C": Played(OperationResult(pending=True)),
        "A": Played(OperationResult(reroute=True, blocked=frozenset({1}))),
        "B": Played(OperationResult(blocked=frozenset({2}))),
        "D": Played(),
    }
    names, result = perform(played, event())
    assert names == ["A", "B"], "one that waits has done nothing yet"
    assert result == OperationResult(True, frozenset({1, 2}), pending=True)


@pytest.mark.parametrize(
    ("seen", "taken"),
    [
        (((2.0, 0), (7.5, 1)), 5.5),
        (((2.0, 0), (4.0, None), (7.5, 1)), 5.5),
        (((2.0, 1), (7.5, 3)), None),
        (((7.5, 1),), None),
    ],
)
def test_the_time_of_an_edge_driven_from_end_to_end_is_noted(
    seen: tuple[tuple[float, int | None], ...], taken: float | None
) -> None:
    EDGES[0].metadata.clear()
    times = marker(time_tag="t")
    done = [times.perform(event(passed=passed, now=now)) for now, passed in seen]
    assert EDGES[0].metadata.get("t") == taken
    assert (done[-1] is not None) == (taken is not None)


def test_the_time_of_an_edge_that_another_goal_entered_is_not_noted() -> None:
    EDGES[0].metadata.clear()
    times = marker()
    times.perform(event(passed=0, now=2.0))
    times.perform(event(passed=1, now=9.0, began=5.0))
    assert EDGES[0].metadata == {}
