"""The pose graph as markers for RViz."""

from __future__ import annotations

from typing import Any

from geometry_msgs.msg import Point, Vector3
from numpy.typing import NDArray
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker, MarkerArray

from arjuna_slam.graph.pose_graph import EdgeKind, PoseGraph

_NAMESPACE = "slam_toolbox"
NODE_COLOR = ColorRGBA(r=1.0, a=1.0)
_EDGE = ColorRGBA(b=1.0, a=1.0)
_LOOP = ColorRGBA(r=1.0, g=0.6, a=1.0)


def markers(graph: PoseGraph, head: Any) -> MarkerArray:
    """Return keyframes as spheres and measurements as lines, loop edges in a colour of their own.

    Args:
        graph: The graph.
        head: Header with the map's frame.
    """
    nodes = _marker(head, 0, Marker.SPHERE_LIST, 0.1, NODE_COLOR)
    nodes.points = [_point(pose) for pose in graph.poses]
    edges = _marker(head, 1, Marker.LINE_LIST, 0.03, _EDGE)
    loops = _marker(head, 2, Marker.LINE_LIST, 0.03, _LOOP)
    for edge in graph.edges:
        lines = loops if edge.kind is EdgeKind.LOOP else edges
        lines.points += [_point(graph.poses[edge.i]), _point(graph.poses[edge.j])]
    return MarkerArray(markers=[nodes, edges, loops])


def _marker(head: Any, number: int, kind: int, size: float, color: ColorRGBA) -> Marker:
    marker = Marker(header=head, ns=_NAMESPACE, id=number, type=kind, action=Marker.ADD)
    marker.color = color
    marker.scale = Vector3(x=size, y=size, z=size)
    marker.pose.orientation.w = 1.0
    return marker


def _point(pose: NDArray[Any]) -> Point:
    return Point(x=float(pose[0]), y=float(pose[1]))
