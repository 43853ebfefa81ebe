"""Node route_server: compute_route, compute_and_track_route."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from geometry_msgs.msg import Point
from nav2_msgs.action import ComputeAndTrackRoute, ComputeRoute
from nav2_msgs.msg import Route as RouteMsg
from nav2_msgs.msg import RouteEdge, RouteNode
from nav2_msgs.srv import DynamicEdges, SetRouteGraph
from nav_msgs.msg import Path as PathMsg
from std_srvs.srv import Trigger

from arjuna_core.config import param
from arjuna_core.errors import InputFileError
from arjuna_core.files.maps_folder import MapsFolderError, path_in_folder
from arjuna_core.ros import qos
from arjuna_core.ros.convert import duration_msg, header, path_msg
from arjuna_core.ros.goal_server import GoalError, GoalNode
from arjuna_core.ros.tf import TransformError
from arjuna_nav.nodes.frames import pose_in, robot_pose
from arjuna_nav.routes.graph import Graph, read_graph
from arjuna_nav.routes.route import CLOSED, Route, Tracker, find_route, path_along, pruned

_Codes = ComputeRoute.Result


@dataclass(frozen=True)
class RouteServerConfig:
    """Parameters of the node `route_server`, by Nav2's names."""

    graph_filepath: str = param(
        "", "The graph, a GeoJSON file; empty: set by a service.", path=True
    )
    graphs_folder: str = param(".", "Folder that set_route_graph may read from.", path=True)
    route_frame: str = param("map", "Frame of the graph.", read_only=True)
    base_frame: str = param("base_footprint", "The robot's frame.", read_only=True)
    transform_tolerance: float = param(
        1.0, "How old the robot's pose may be.", unit="s", minimum=0.0
    )
    path_density: float = param(0.05, "Between poses of a path.", unit="m", minimum=0.001)
    tracker_update_rate: float = param(
        50.0, "How often progress is looked at.", unit="Hz", minimum=0.1, read_only=True
    )
    radius_to_achieve_node: float = param(
        2.0, "How near to a node the robot passes it.", unit="m", minimum=0.0
    )
    boundary_radius_to_achieve_node: float = param(
        1.0, "How near to the last node it has come there.", unit="m", minimum=0.0
    )
    prune_goal: bool = param(True, "Whether a last node beyond the goal is left out.")
    min_prune_distance_from_start: float = param(
        0.1, "How far along the first edge the robot leaves its node out.", unit="m", minimum=0.0
    )
    max_prune_dist_from_edge: float = param(
        8.0, "How far from an edge that holds.", unit="m", minimum=0.0
    )


class RouteServerNode(GoalNode):
    """Answers a route at once; one that is tracked ends at its last node."""

    Config = RouteServerConfig
    DEFAULT_NAME = "route_server"

    def configure(self) -> None:
        """Read the graph and create the interfaces."""
        config = self.config
        self._graph: Graph | None = None
        if config.graph_filepath:
            self._graph = read_graph(Path(config.graph_filepath), config.route_frame)
        self._costs: dict[int, float] = {}
        self._tracked: tuple[Tracker, Route, int] | None = None
        self._began = 0.0
        self._out = self.publisher(PathMsg, "plan", qos.LATEST)
        self._once = self.offer(ComputeRoute, "compute_route", self._on_goal)
        self._tracking = self.offer(
            ComputeAndTrackRoute, "compute_and_track_route", self._on_track, on_cancel=self._track
        )
        self.serve(SetRouteGraph, "route_server/set_route_graph", self._on_graph)
        self.serve(DynamicEdges, "route_server/DynamicEdgesScorer/adjust_edges", self._on_edges)
        self.serve(Trigger, "route_server/ReroutingService/reroute", self._on_reroute)
        self.every(1.0 / config.tracker_update_rate, self._track)

    def halt(self) -> None:
        """Track no more."""
        self._tracked = None

    def _on_graph(self, request: Any, response: Any) -> Any:
        try:
            path = path_in_folder(self.config.graphs_folder, request.graph_filepath)
            self._graph = read_graph(path, self.config.route_frame)
        except (InputFileError, MapsFolderError) as error:
            self.get_logger().error(str(error))
            return response
        self._costs.clear()
        response.success = True
        return response

    def _on_edges(self, request: Any, response: Any) -> Any:
        numbers = {*request.closed_edges, *request.opened_edges}
        numbers |= {one.edgeid for one in request.adjust_edges}
        known = self._graph.edges if self._graph is not None else {}
        missing = sorted(numbers - set(known))
        if missing or any(not one.cost >= 0.0 for one in request.adjust_edges):
            self.get_logger().error(f"edges not adjusted: no edges {missing}, or a cost below 0")
            return response
        self._costs.update(dict.fromkeys(request.closed_edges, CLOSED))
        for number in request.opened_edges:
            self._costs.pop(number, None)
        self._costs.update({one.edgeid: float(one.cost) for one in request.adjust_edges})
        response.success = True
        return response

    def _on_reroute(self, request: Any, response: Any) -> Any:
        response.success = self._tracked is not None
        response.message = "" if response.success else "no route is tracked"
        if response.success:
            self._reroute()
        return response

    def _on_goal(self) -> None:
        try:
            route = self._route(self._once.take_newest())
        except GoalError as error:
            self._once.fail(error)
            return
        path, message = self._messages(route)
        self._once.succeed(_Codes(planning_time=duration_msg(0.0), path=path, route=message))

    def _on_track(self) -> None:
        goal = self._tracking.take_newest()
        self._tracked, self._began = None, self.now
        try:
            self._follow(self._route(goal), rerouted=False)
        except GoalError as error:
            self._tracking.fail(error)

    def _route(self, goal: Any) -> Route:
        """Return the route that a goal asks for.

        Raises:
            GoalError: There is none.
        """
        graph, config, frame = self._graph, self.config, self.config.route_frame
        if graph is None:
            reason = "no graph is loaded; valid: graph_filepath or route_server/set_route_graph"
            raise GoalError(_Codes.NO_VALID_GRAPH, reason)
        start = end = None
        if goal.use_poses:
            try:
                here = (
                    pose_in(self, frame, goal.start)
                    if goal.use_start
                    else robot_pose(self, frame, config.base_frame, self.config.transform_tolerance)
                )
                there = pose_in(self, frame, goal.goal)
            except TransformError as error:
                raise GoalError(_Codes.TF_ERROR, str(error)) from error
            start, end = (here.x, here.y), (there.x, there.y)
        ends = (
            goal.start_id if start is None else graph.nearest(*start),
            goal.goal_id if end is None else graph.nearest(*end),
        )
        missing = [node for node in ends if node not in graph.nodes]
        if missing:
            raise GoalError(_Codes.INDETERMINANT_NODES_ON_GRAPH, f"the graph has no node {missing}")
        route = find_route(graph, *ends, self._costs)
        if route is None:
            raise GoalError(_Codes.NO_VALID_ROUTE, f"no route from node {ends[0]} to {ends[1]}")
        least, off = config.min_prune_distance_from_start, config.max_prune_dist_from_edge
        return pruned(route, graph, start, end if config.prune_goal else None, least, off)

    def _follow(self, route: Route, rerouted: bool) -> None:
        config, graph = self.config, self._graph
        if graph is None:
            raise GoalError(_Codes.NO_VALID_GRAPH, "no graph is loaded")
        radii = config.radius_to_achieve_node, config.boundary_radius_to_achieve_node
        self._tracked = Tracker(route, graph, *radii), route, route.nodes[-1]
        self._publish_progress(rerouted)

    def _reroute(self) -> None:
        if self._tracked is None or self._graph is None:
            return
        tracker, route, goal = self._tracked
        first = tracker.next_node if tracker.next_node is not None else goal
        found = find_route(self._graph, first, goal, self._costs)
        if found is None:
            self.halt()
            reason = f"no other route from node {first} to {goal}"
            self._tracking.fail(GoalError(_Codes.NO_VALID_ROUTE, reason))
        elif found.nodes != route.nodes[-len(found.nodes) :]:
            self._follow(found, rerouted=True)

    def _track(self) -> None:
        server = self._tracking
        if server.goal is None or self._tracked is None:
            return
        if server.cancel_requested:
            self.halt()
            server.cancel(self._ended())
            return
        tracker = self._tracked[0]
        if any(self._costs.get(edge.id) == CLOSED for edge in tracker.ahead):
            self._reroute()
            return
        frame, base = self.config.route_frame, self.config.base_frame
        try:
            pose = robot_pose(self, frame, base, self.config.transform_tolerance)
        except TransformError as error:
            self.halt()
            server.fail(GoalError(_Codes.TF_ERROR, str(error)))
            return
        if tracker.update(pose.x, pose.y):
            self._publish_progress(rerouted=False)
        if tracker.done:
            self.halt()
            server.succeed(self._ended())

    def _ended(self) -> Any:
        duration = duration_msg(self.now - self._began)
        return ComputeAndTrackRoute.Result(execution_duration=duration)

    def _publish_progress(self, rerouted: bool) -> None:
        if self._tracked is None:
            return
        tracker, route, _ = self._tracked
        path, message = self._messages(route)
        feedback = ComputeAndTrackRoute.Feedback(route=message, path=path, rerouted=rerouted)
        feedback.last_node_id = tracker.last_node or 0
        feedback.next_node_id = tracker.next_node or 0
        feedback.current_edge_id = tracker.edge.id if tracker.edge is not None else 0
        self._tracking.feedback(feedback)

    def _messages(self, route: Route) -> tuple[Any, Any]:
        """Return a route's path, which is published, and its message."""
        graph, frame = self._graph, self.config.route_frame
        if graph is None:
            raise GoalError(_Codes.NO_VALID_GRAPH, "no graph is loaded")
        path = path_msg(path_along(route, graph, self.config.path_density), frame, self.now)
        self._out.publish(path)
        at = {node: Point(x=graph.nodes[node][0], y=graph.nodes[node][1]) for node in route.nodes}
        message = RouteMsg(header=header(frame, self.now), route_cost=route.cost)
        message.nodes = [RouteNode(nodeid=node, position=at[node]) for node in route.nodes]
        message.edges = [
            RouteEdge(edgeid=one.id, start=at[one.start], end=at[one.end]) for one in route.edges
        ]
        return path, message
