"""The scorers and operations of route_server that speak ROS, and the lists of all of them.

Source: nav2_route's plug-ins of the same names.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Set
from dataclasses import dataclass
from typing import Any, ClassVar

from nav2_msgs.msg import SpeedLimit
from nav2_msgs.srv import DynamicEdges
from std_srvs.srv import Trigger

from arjuna_core.config import NoParameters, fixed
from arjuna_core.plugins import PluginTypes
from arjuna_core.ros import qos
from arjuna_core.ros.convert import header
from arjuna_core.ros.goal_server import GoalNode
from arjuna_core.ros.tf import TransformError
from arjuna_nav.costmap import Costmap
from arjuna_nav.nodes.costmap.reader import CostmapReader
from arjuna_nav.routes.graph import Edge, Graph
from arjuna_nav.routes.operations import OperationError, OperationResult, RouteEvent
from arjuna_nav.routes.route import Tracker
from arjuna_nav.routes.scorers import RouteRequest, speed_share


class RouteHost(GoalNode):
    """The route server as its plug-ins see it.

    Attributes:
        graph: The graph, None where none is loaded.
        tracker: Of the route that is tracked, None where none is.
    """

    graph: Graph | None = None
    tracker: Tracker | None = None
    _is_closed_ahead = False

    def edges_closed(self, edges: Set[Edge]) -> None:
        """Have a route that is tracked left at its next look, if it leads over one of these."""
        ahead = self.tracker.ahead if self.tracker is not None else ()
        self._is_closed_ahead = not edges.isdisjoint(ahead)

    def costmap(self, topic: str) -> Callable[[], Costmap | None]:
        """Return what reads the costmap of a topic in the graph's frame; None is logged."""
        config = self.config
        reader = CostmapReader(self, topic, "", config.base_frame, config.transform_tolerance)

        def read() -> Costmap | None:
            costmap, problem = None, ""
            try:
                costmap = reader.current(math.inf, config.route_frame)
            except TransformError as error:
                problem = str(error)
            if costmap is None:
                why = problem or reader.why_not_current()
                self.get_logger().warning(f"no costmap to see routes by: {why}")
            return costmap

        return read


class DynamicEdgesScorer:
    """Closes edges, opens them and adds to their costs by a service; a new graph has none."""

    Config: ClassVar[type[Any]] = NoParameters

    def __init__(self, config: Any, name: str, node: RouteHost) -> None:
        self._node = node
        self._closed: set[Edge] = set()
        self._costs: dict[Edge, float] = {}
        node.serve(DynamicEdges, f"{node.get_name()}/{name}/adjust_edges", self._adjust)

    def score(self, edge: Edge, request: RouteRequest) -> float | None:
        return None if edge in self._closed else self._costs.get(edge, 0.0)

    def _adjust(self, request: Any, response: Any) -> Any:
        edges = self._node.graph.edges if self._node.graph is not None else {}
        numbers = {*request.closed_edges, *request.opened_edges}
        numbers |= {one.edgeid for one in request.adjust_edges}
        missing = sorted(numbers - set(edges))
        if missing or any(not one.cost >= 0.0 for one in request.adjust_edges):
            problem = f"no edges {missing}, or a cost below 0"
            self._node.get_logger().error(f"edges not adjusted: {problem}")
            return response
        self._closed |= {edges[one] for one in request.closed_edges}
        self._closed -= {edges[one] for one in request.opened_edges}
        self._node.edges_closed(self._closed)
        self._costs |= {edges[one.edgeid]: float(one.cost) for one in request.adjust_edges}
        response.success = True
        return response


@dataclass(frozen=True)
class SpeedConfig:
    """Parameters of the speed limits of edges."""

    speed_limit_topic: str = fixed("speed_limit", "Topic of the limits, a nav2_msgs/SpeedLimit.")
    speed_tag: str = fixed("speed_limit", "Metadata of edges: share of the speed, or per cent.")


class AdjustSpeedLimit:
    """Publishes the speed limit of the edge that is entered, where it changes; none at the end."""

    Config: ClassVar[type[Any]] = SpeedConfig

    def __init__(self, config: Any, name: str, node: RouteHost) -> None:
        self._node, self._tag = node, config.speed_tag
        self._share = 1.0
        self._out = node.publisher(SpeedLimit, config.speed_limit_topic, qos.DEFAULT)

    def perform(self, event: RouteEvent) -> OperationResult | None:
        if event.node is None:
            return None
        share = speed_share(event.entered, self._tag) if event.entered is not None else 1.0
        if share == self._share:
            return None
        self._share = share
        stamp = header(self._node.config.route_frame, event.now)
        limit = SpeedLimit(header=stamp, percentage=True, speed_limit=100.0 * share)
        self._out.publish(limit)
        return OperationResult()


class ReroutingService:
    """Asks for another route where its service is called."""

    Config: ClassVar[type[Any]] = NoParameters

    def __init__(self, config: Any, name: str, node: RouteHost) -> None:
        self._node = node
        self._asked = False
        node.serve(Trigger, f"{node.get_name()}/{name}/reroute", self._ask)

    def _ask(self, request: Any, response: Any) -> Any:
        response.success = self._node.tracker is not None
        response.message = "" if response.success else "no route is tracked"
        self._asked = response.success
        return response

    def perform(self, event: RouteEvent) -> OperationResult | None:
        asked, self._asked = self._asked, False
        return OperationResult(reroute=True) if asked else None


@dataclass(frozen=True)
class TriggerConfig:
    """Parameters of the calls of services."""

    service_name: str = fixed("", "Service where the graph's metadata name none.")
    service_timeout: float = fixed(
        0.5, "How long a service may take to answer.", unit="s", minimum=0.0
    )


@dataclass
class _Call:
    name: str
    client: Any
    since: float
    answer: Any = None


class TriggerEvent:
    """Calls a service, a std_srvs/Trigger, where the graph asks for it.

    The route does not end before it has answered; where it does not, the goal fails.
    """

    Config: ClassVar[type[Any]] = TriggerConfig

    def __init__(self, config: Any, name: str, node: RouteHost) -> None:
        self._config, self._name, self._node = config, name, node
        self._clients: dict[str, Any] = {}
        self._calls: list[_Call] = []

    def perform(self, event: RouteEvent) -> OperationResult | None:
        self._calls = [call for call in self._calls if call.since >= event.began]
        if event.called is not None:
            self._call(str(event.called.get("service_name", self._config.service_name)), event.now)
        for call in list(self._calls):
            self._look_after(call, event.now)
        return OperationResult(pending=True) if self._calls else None

    def _call(self, name: str, now: float) -> None:
        if not name:
            problem = "needs a service_name, as a parameter or in the graph's metadata"
            raise OperationError(f"operation {self._name} {problem}")
        if name not in self._clients:
            self._clients[name] = self._node.client(Trigger, name)
        self._calls.append(_Call(name, self._clients[name], now))

    def _look_after(self, call: _Call, now: float) -> None:
        if call.answer is None and call.client.service_is_ready():
            call.answer = call.client.call_async(Trigger.Request())
        if call.answer is not None and call.answer.done():
            self._calls.remove(call)
            if not call.answer.result().success:
                said = call.answer.result().message
                self._node.get_logger().warning(f"{call.name} answered false: {said}")
        elif now - call.since > self._config.service_timeout:
            self._calls.remove(call)
            limit = f"{self._config.service_timeout:g} s"
            raise OperationError(f"service {call.name} did not answer within {limit}")


def _types(kind: str, *paths: str) -> PluginTypes:
    """Return the classes of nav2_route; a plug-in of a class's own name need not name it."""
    names = {path.partition(":")[2]: path for path in paths}
    classes = {f"nav2_route::{name}": path for name, path in names.items()}
    return PluginTypes(kind, classes, "", {name: f"nav2_route::{name}" for name in names})


_CORES = "arjuna_nav.routes"
SCORERS = _types(
    "route scorer",
    f"{_CORES}.scorers:DistanceScorer",
    f"{_CORES}.scorers:TimeScorer",
    f"{_CORES}.scorers:PenaltyScorer",
    f"{_CORES}.obstacles:CostmapScorer",
    f"{_CORES}.scorers:SemanticScorer",
    f"{_CORES}.scorers:StartPoseOrientationScorer",
    f"{_CORES}.scorers:GoalOrientationScorer",
    f"{__name__}:DynamicEdgesScorer",
)
"""Scorers of edges by Nav2's class names."""
OPERATIONS = _types(
    "route operation",
    f"{__name__}:AdjustSpeedLimit",
    f"{__name__}:ReroutingService",
    f"{__name__}:TriggerEvent",
    f"{_CORES}.obstacles:CollisionMonitor",
    f"{_CORES}.operations:TimeMarker",
)
"""Operations on routes by Nav2's class names."""
