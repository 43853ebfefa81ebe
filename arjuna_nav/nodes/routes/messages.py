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
    stamped, nodes, edges = header(frame, now), graph.nodes.values(), graph.edges.values()
    balls = Marker(header=stamped, ns="route_graph_nodes", type=Marker.SPHERE_LIST, color=_NODES)
    balls.scale, balls.points = Vector3(x=0.1, y=0.1, z=0.1), [at(one) for one in nodes]
    lines = Marker(header=stamped, ns="route_graph_edges", type=Marker.LINE_LIST, color=_EDGES)
    lines.scale.x = 0.05
    lines.points = [at(end) for one in edges for end in (one.start, one.end)]
    clear = Marker(header=stamped, action=Marker.DELETEALL)  # of a graph before this one
    markers = [clear, balls, lines]
    texts = [("node", one.id, one.x, one.y, _NODES) for one in nodes]
    for one in edges:
        aside = 0.05 if one.start.id > one.end.id else -0.05  # those there and back lie apart
        x, y = (one.start.x + one.end.x) / 2.0, (one.start.y + one.end.y) / 2.0 + aside
        texts.append(("edge", one.id, x, y, _EDGES))
    for k, (kind, number, x, y, colour) in enumerate(texts):
        text = Marker(header=stamped, ns=f"route_graph_{kind}_ids", id=k, color=colour)
        text.type, text.text, text.scale.z = Marker.TEXT_VIEW_FACING, str(number), 0.1
        text.pose.position = Point(x=x + 0.07, y=y)
        markers.append(text)
    return MarkerArray(markers=markers)
