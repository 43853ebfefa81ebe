"""Node route_server: compute_route, compute_and_track_route."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar

from nav2_msgs.action import ComputeAndTrackRoute, ComputeRoute
from nav2_msgs.srv import SetRouteGraph
from nav_msgs.msg import Path as PathMsg
from visualization_msgs.msg import MarkerArray

from arjuna_core.errors import ArjunaError, InputFileError
from arjuna_core.files.maps_folder import MapsFolderError, path_in_folder
from arjuna_core.ros import qos
from arjuna_core.ros.convert import duration_msg, path_msg
from arjuna_core.ros.goal_server import GoalError
from arjuna_core.ros.tf import TransformError
from arjuna_core.se2 import SE2
from arjuna_nav.nodes.frames import pose_in, robot_pose
from arjuna_nav.nodes.routes.config import RouteServerConfig
from arjuna_nav.nodes.routes.messages import graph_markers, route_msg
from arjuna_nav.nodes.routes.plugins import OPERATIONS, SCORERS, RouteHost
from arjuna_nav.routes.graph import Edge, Graph, read_graph
from arjuna_nav.routes.obstacles import nearest_node
from arjuna_nav.routes.operations import RouteEvent, RouteOperation, perform
from arjuna_nav.routes.route import (
    Route,
    RouteSearchError,
    Tracker,
    find_route,
    path_along,
    pruned,
)
from arjuna_nav.routes.scorers import RouteRequest, RouteScorer, edge_cost

_NO_GRAPH = "no graph is loaded; valid: graph_filepath or route_server/set_route_graph"
_Codes = ComputeAndTrackRoute.Result  # ComputeRoute's and one of operations
T = TypeVar("T")


class RouteServerNode(RouteHost):
    """Answers a route at once; one that is tracked ends at its last node."""

    Config = RouteServerConfig
    DEFAULT_NAME = "route_server"

    def configure(self) -> None:
        config = self.config
        self.graph = self.tracker = None
        self._unread, self._reason = config.graph_filepath, _NO_GRAPH
        self._load()
        self._began = 0.0
        self._scorers: list[RouteScorer] = [
            SCORERS.make(getattr(config, name), name, self) for name in config.edge_cost_functions
        ]
        self._operations: dict[str, RouteOperation] = {
            name: OPERATIONS.make(getattr(config, name), name, self) for name in config.operations
        }
        self._costs = self.costmap(config.costmap_topic) if config.enable_nn_search else None
        self._out = self.publisher(PathMsg, "plan", qos.LATEST)
        self._markers = self.publisher(MarkerArray, "route_graph", qos.LATCHED)
        self._once = self.offer(ComputeRoute, "compute_route", self._on_goal)
        self._tracking = self.offer(
            ComputeAndTrackRoute, "compute_and_track_route", self._on_track, on_cancel=self._track
        )
        self.serve(SetRouteGraph, "route_server/set_route_graph", self._on_graph)
        self.every(1.0 / config.tracker_update_rate, self._track)

    def _load(self) -> None:
        """Read the graph, once its nodes' frames are known."""
        if not self._unread:
            return
        try:
            self.graph = self._graph_of(Path(self._unread))
            self._unread = ""
        except TransformError as error:
            self._reason = f"{self._unread}: {error}"

    def _graph_of(self, path: Path) -> Graph:
        return read_graph(path, self.config.route_frame, self.transforms.lookup)

    def activate(self) -> None:
        self._load()
        if self._unread:
            self.get_logger().warning(f"no graph yet: {self._reason}")
        if self.graph is not None:
            self._markers.publish(graph_markers(self.graph, self.config.route_frame, self.now))

    def halt(self) -> None:
        self.tracker, self._is_closed_ahead = None, False

    def _on_graph(self, request: Any, response: Any) -> Any:
        try:
            path = path_in_folder(self.config.graphs_folder, request.graph_filepath)
            self.graph, self._unread = self._graph_of(path), ""
        except (InputFileError, MapsFolderError, TransformError) as error:
            self.get_logger().error(str(error))
            return response
        self.activate()
        response.success = True
        return response

    def _on_goal(self) -> None:
        route, _ = self._find(self._request(self._once.take_newest()))
        path, message = self._messages(route)
        self._once.succeed(ComputeRoute.Result(path=path, route=message))

    def _on_track(self) -> None:
        goal = self._tracking.take_newest()
        self.halt()
        self._began = self.now
        request = self._request(goal)
        self._follow(request, *self._find(request))

    def _request(self, goal: Any) -> RouteRequest:
        """Return what a goal asks for.

        Raises:
            GoalError: It cannot be used.
        """
        graph, frame = self._loaded(), self.config.route_frame
        if not goal.use_poses:
            return RouteRequest(goal.start_id, goal.goal_id)
        try:
            start = pose_in(self, frame, goal.start) if goal.use_start else self._pose()
            end = pose_in(self, frame, goal.goal)
        except TransformError as error:
            raise GoalError(_Codes.TF_ERROR, str(error)) from error
        costmap = self._costs() if self._costs is not None else None
        first, last = (
            nearest_node(graph, (at.x, at.y), costmap, self.config.num_nearest_nodes)
            for at in (start, end)
        )
        return RouteRequest(first, last, start, end)

    def _loaded(self) -> Graph:
        self._load()
        if self.graph is None:
            raise GoalError(_Codes.NO_VALID_GRAPH, self._reason)
        return self.graph

    def _pose(self) -> SE2:
        config = self.config
        frames = config.route_frame, config.base_frame
        try:
            return robot_pose(self, *frames, config.transform_tolerance)
        except TransformError as error:
            raise GoalError(_Codes.TF_ERROR, str(error)) from error

    def _of_plugins(self, code: int, work: Callable[[], T]) -> T:
        """Return what work with plug-ins returns; what they raise becomes a GoalError of a code."""

        def run() -> T | GoalError:
            try:
                return work()
            except RouteSearchError as error:
                return GoalError(_Codes.TIMEOUT, str(error))
            except ArjunaError as error:
                return GoalError(code, str(error))

        done = self.guarded("plug-ins", run, lambda reason: GoalError(code, reason))()
        if isinstance(done, GoalError):
            raise done
        return done  # type: ignore[no-any-return]

    def _find(self, request: RouteRequest, edge: Edge | None = None) -> tuple[Route, Edge | None]:
        """Return the route that is asked for, and the edge to its first node if that is driven now.

        Raises:
            GoalError: There is none.
        """
        graph, config = self._loaded(), self.config
        ends = request.start_node, request.goal_node
        if missing := [node for node in ends if node not in graph.nodes]:
            raise GoalError(_Codes.INDETERMINANT_NODES_ON_GRAPH, f"the graph has no node {missing}")

        most = config.max_iterations if config.max_iterations > 0 else math.inf

        def cost(one: Edge) -> float | None:
            return edge_cost(self._scorers, one, request)

        route = self._of_plugins(
            _Codes.INVALID_EDGE_SCORER_USE, lambda: find_route(graph, *ends, cost, most)
        )
        if route is None:
            raise GoalError(_Codes.NO_VALID_ROUTE, f"no route from node {ends[0]} to {ends[1]}")
        start, goal = (
            None if one is None else (one.x, one.y) for one in (request.start, request.goal)
        )
        if edge is not None and route.edges[:1] == (edge,):
            route, start = route.without_first(), None
        else:
            edge = None
        least = config.min_prune_dist_from_start, config.min_prune_dist_from_goal
        off = config.max_prune_dist_from_edge
        return pruned(route, start, goal if config.prune_goal else None, *least, off), edge

    def _follow(self, request: RouteRequest, route: Route, edge: Edge | None) -> None:
        """Track a route; as in nav2_route, its first feedback says so as that after rerouting."""
        config = self.config
        radii = config.radius_to_achieve_node, config.boundary_radius_to_achieve_node
        self._asked, self._route, self.tracker = request, route, Tracker(route, *radii, edge)
        self._publish_progress(self.tracker, rerouted=True)

    def _track(self) -> None:
        server = self._tracking
        if server.goal is None or self.tracker is None:
            return
        if server.cancel_requested:
            self.halt()
            server.cancel(self._ended())
            return
        try:
            self._advance(self.tracker, self._pose())
        except GoalError as error:
            self.halt()
            server.fail(error)

    def _ended(self) -> Any:
        duration = duration_msg(self.now - self._began)
        return ComputeAndTrackRoute.Result(execution_duration=duration)

    def _advance(self, tracker: Tracker, pose: SE2) -> None:
        """Look where the robot is on its route, and do what is due there.

        Raises:
            GoalError: An operation has failed, or there is no other route.
        """
        if self._is_closed_ahead:
            self._is_closed_ahead = False
            self._reroute(tracker, pose, frozenset())
            return
        moved = tracker.update(pose.x, pose.y)
        passed = (tracker.last_node, tracker.edge, tracker.edge_before) if moved else ()
        event = RouteEvent(self.now, self._began, pose, tracker.edge, tracker.ahead, *passed)
        names, result = self._of_plugins(
            _Codes.OPERATION_FAILED, lambda: perform(self._operations, event)
        )
        if moved or names:
            self._publish_progress(tracker, names)
        if tracker.done and not result.pending:
            self.halt()
            self._tracking.succeed(self._ended())
        elif result.reroute and not tracker.done:
            self._reroute(tracker, pose, result.blocked)

    def _reroute(self, tracker: Tracker, pose: SE2, blocked: frozenset[int]) -> None:
        """Follow the cheapest route from the last node on, if it is another.

        Source: nav2_route, RouteTracker and GoalIntentExtractor::overrideStart.
        """
        first = tracker.last_node or self._route.start
        if self.config.aggregate_blocked_ids:
            blocked |= self._asked.blocked
        asked = replace(self._asked, start=pose, start_node=first.id, blocked=blocked)
        route, edge = self._find(asked, tracker.edge)
        ahead = tracker.edge, tracker.next_node, tracker.ahead
        if (edge, route.start, route.edges) != ahead:
            self._follow(asked, route, edge)

    def _publish_progress(
        self, tracker: Tracker, operations: Sequence[str] = (), rerouted: bool = False
    ) -> None:
        path, message = self._messages(self._route)
        feedback = ComputeAndTrackRoute.Feedback(route=message, path=path, rerouted=rerouted)
        feedback.operations_triggered = list(operations)
        last, following, edge = tracker.last_node, tracker.next_node, tracker.edge
        feedback.last_node_id = last.id if last is not None else 0
        feedback.next_node_id = following.id if following is not None else 0
        feedback.current_edge_id = edge.id if edge is not None else 0
        self._tracking.feedback(feedback)

    def _messages(self, route: Route) -> tuple[Any, Any]:
        """Return a route's path, which is published, and its message."""
        config, frame = self.config, self.config.route_frame
        radius = config.smoothing_radius if config.smooth_corners else 0.0
        path = path_msg(path_along(route, config.path_density, radius), frame, self.now)
        self._out.publish(path)
        return path, route_msg(route, frame, self.now)
