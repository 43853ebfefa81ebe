"""Graphs and routes as messages."""

from __future__ import annotations

from geometry_msgs.msg import Point, Vector3
from nav2_msgs.msg import Route as RouteMsg
from nav2_msgs.msg import RouteEdge, RouteNode
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker, MarkerArray

from arjuna_core.ros.convert import header
from arjuna_nav.routes.graph import Graph, Node
from arjuna_nav.routes.route import Route

_NODES, _EDGES = ColorRGBA(r=1.0, a=1.0), ColorRGBA(g=1.0, a=0.5)


def at(node: Node) -> Point:
    """Return where a node is."""
    return Point(x=node.x, y=node.y)


def route_msg(route: Route, frame: str, now: float) -> RouteMsg:
    """Return a route with its nodes and edges."""
    message = RouteMsg(header=header(frame, now), route_cost=route.cost)
    message.nodes = [RouteNode(nodeid=one.id, position=at(one)) for one in route.nodes]
    message.edges = [
        RouteEdge(edgeid=one.id, start=at(one.start), end=at(one.end)) for one in route.edges
    ]
    return message


def graph_markers(graph: Graph, frame: str, now: float) -> MarkerArray:
    """Return a graph as nav2_route shows it: balls, lines, and the numbers of both."""
    nodes, edges = graph.nodes.values(), graph.edges.values()
    clear = Marker(action=Marker.DELETEALL)  # a graph before this one
    balls = Marker(ns="route_graph_nodes", type=Marker.SPHERE_LIST, color=_NODES)
    balls.scale, balls.points = Vector3(x=0.1, y=0.1, z=0.1), [at(one) for one in nodes]
    lines = Marker(ns="route_graph_edges", type=Marker.LINE_LIST, color=_EDGES)
    lines.scale, lines.points = Vector3(x=0.05), [at(n) for e in edges for n in (e.start, e.end)]
    markers, texts = [clear, balls, lines], [("node", one.id, at(one), _NODES) for one in nodes]
    for one in edges:
        aside = 0.05 if one.start.id > one.end.id else -0.05  # those there and back lie apart
        x, y = (one.start.x + one.end.x) / 2.0, (one.start.y + one.end.y) / 2.0 + aside
        texts.append(("edge", one.id, Point(x=x, y=y), _EDGES))
    for k, (kind, number, point, colour) in enumerate(texts):
        text = Marker(ns=f"route_graph_{kind}_ids", id=k, color=colour, text=str(number))
        text.type, text.scale.z, text.pose.position = Marker.TEXT_VIEW_FACING, 0.1, point
        text.pose.position.x += 0.07
        markers.append(text)
    for marker in markers:
        marker.header = header(frame, now)
    return MarkerArray(markers=markers)
