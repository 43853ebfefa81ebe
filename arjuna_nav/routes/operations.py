"""Operations while a route is driven: what they are given, what they ask for, those without ROS.

Source: nav2_route's operations of the same names.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Protocol

from arjuna_core.config import fixed
from arjuna_core.errors import ArjunaError
from arjuna_core.se2 import SE2
from arjuna_nav.routes.graph import Edge, Node


class OperationError(ArjunaError):
    """An operation has failed, and with it the goal."""


@dataclass(frozen=True)
class RouteEvent:
    """A look at a robot on its route.

    Attributes:
        now: Time [s].
        began: When its goal came [s].
        pose: Where it is, in the graph's frame.
        edge: The edge that it drives, None before the first node and at the end.
        ahead: The edges from the next node on.
        node: The node that it has just passed, None where it has passed none.
        called: Metadata with which the graph asks for this operation now; None where it does not.
    """

    now: float
    began: float
    pose: SE2
    edge: Edge | None
    ahead: tuple[Edge, ...]
    node: Node | None = None
    entered: Edge | None = None
    exited: Edge | None = None
    called: Mapping[str, Any] | None = None


@dataclass(frozen=True)
class OperationResult:
    """A note that an operation has done something.

    Attributes:
        reroute: Whether it asks for another route.
        blocked: Numbers of edges that are closed to it.
        pending: Whether the route cannot end yet.
    """

    reroute: bool = False
    blocked: frozenset[int] = frozenset()
    pending: bool = False


class RouteOperation(Protocol):
    """An operation; made of `(config, name, node)` in the node's `configure`.

    A class has `Config`, the frozen dataclass of its parameters. The node is the route server.
    """

    def perform(self, event: RouteEvent) -> OperationResult | None:
        """Do what is due, at each look at a route that is driven; it must not block.

        Where the graph asks for it several times at once, it is called once for each.

        Returns:
            None where nothing was done; else the feedback names the operation.

        Raises:
            ArjunaError: It has failed; so does the goal.
        """
        ...


def perform(
    operations: Mapping[str, RouteOperation], event: RouteEvent
) -> tuple[list[str], OperationResult]:
    """Return the names of the operations that did something, and what they ask for together.

    Raises:
        ArjunaError: The graph asks for one that does not exist, or one has failed.
    """
    calls: dict[str, list[Mapping[str, Any]]] = {}
    parts = ("NODE", event.node), ("ON_ENTER", event.entered), ("ON_EXIT", event.exited)
    for trigger, part in parts:
        for one in part.operations if part is not None else ():
            if one.trigger == trigger:
                calls.setdefault(one.type, []).append(one.metadata)
    if missing := sorted(set(calls) - set(operations)):
        listed = ", ".join(operations) or "none"
        raise OperationError(f"the graph asks for operation {missing[0]}; operations: {listed}")
    names, total = [], OperationResult()
    for name, operation in operations.items():
        for called in calls.get(name, (None,)):
            result = operation.perform(replace(event, called=called))
            if called is not None or (result is not None and not result.pending):
                names.append(name)
            if result is not None:
                total = OperationResult(
                    total.reroute or result.reroute,
                    total.blocked | result.blocked,
                    total.pending or result.pending,
                )
    return names, total


@dataclass(frozen=True)
class TimeMarkerConfig:
    """Parameters of the notes of times."""

    time_tag: str = fixed("abs_time_taken", "Metadata of edges: the time it took [s].")


class TimeMarker:
    """Notes in an edge's metadata how long the robot took for it, for the TimeScorer."""

    Config: ClassVar[type[Any]] = TimeMarkerConfig

    def __init__(self, config: Any, name: str, node: Any) -> None:
        self._tag = config.time_tag
        self._edge: Edge | None = None
        self._since = 0.0

    def perform(self, event: RouteEvent) -> OperationResult | None:
        if event.node is None:
            return None
        exited, entered_at = event.exited, self._since
        whole = exited is not None and exited is self._edge and entered_at >= event.began
        self._edge, self._since = event.entered, event.now
        if exited is None or not whole:
            return None
        exited.metadata[self._tag] = event.now - entered_at
        return OperationResult()
