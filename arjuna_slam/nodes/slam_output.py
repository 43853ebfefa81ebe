"""The output of the slam_toolbox node: pose, correction of the odometry, map and graph."""

from __future__ import annotations

from typing import Any

import numpy as np
from geometry_msgs.msg import Point, PoseWithCovariance, PoseWithCovarianceStamped, Vector3
from nav_msgs.msg import MapMetaData
from nav_msgs.msg import OccupancyGrid as OccupancyGridMsg
from numpy.typing import NDArray
from rclpy.qos import DurabilityPolicy
from std_msgs.msg import ColorRGBA, Float64
from visualization_msgs.msg import Marker, MarkerArray

from arjuna_core.ros import qos
from arjuna_core.ros.convert import grid_msg, header, planar_covariance, pose_msg, transform_msg
from arjuna_core.ros.node import ManagedNode
from arjuna_core.ros.tf import TransformPublisher, transforms_msg
from arjuna_core.se2 import SE2
from arjuna_slam.graph.pose_graph import EdgeKind, PoseGraph
from arjuna_slam.matching.scan_matcher import MatchStatus
from arjuna_slam.pose_tracker import PoseTracker, SlamUpdate

_NAMESPACE = "slam_toolbox"
NODE_COLOR = ColorRGBA(r=1.0, a=1.0)
_EDGE = ColorRGBA(b=1.0, a=1.0)
_LOOP = ColorRGBA(r=1.0, g=0.6, a=1.0)


def markers(graph: PoseGraph, head: Any) -> MarkerArray:
    """Return keyframes as spheres and measurements as lines, loop edges in another colour."""
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


class SlamOutput:
    """The publishers of slam_toolbox, whose configuration names the frames."""

    def __init__(self, node: ManagedNode, slam: PoseTracker) -> None:
        self._node = node
        c = node.config
        self._map = node.publisher(OccupancyGridMsg, c.map_name, qos.LATCHED)
        self._metadata = node.publisher(MapMetaData, f"{c.map_name}_metadata", qos.LATCHED)
        self._pose = node.publisher(PoseWithCovarianceStamped, "pose", qos.DEFAULT)
        self._entropy = node.publisher(Float64, "entropy", qos.DEFAULT)
        self._graph = node.publisher(MarkerArray, "slam_toolbox/graph_visualization", qos.LATEST)
        self._tf = TransformPublisher(node, "/tf", qos.TF)
        self.restart(slam)

    def restart(self, slam: PoseTracker) -> None:
        """Speak of another mapper."""
        self._slam = slam
        self._update: SlamUpdate | None = None
        self._status = MatchStatus.MATCHED
        self._stamp = self._broadcast_stamp = -np.inf
        self.graph_changed()

    @property
    def T_map_base(self) -> SE2 | None:
        """The robot's last pose, None before the first."""
        return None if self._update is None else self._update.T_map_base

    def graph_changed(self) -> None:
        """Publish the map when it is next due, although no keyframe came."""
        self._fresh = len(self._slam.graph) > 0

    def hold(self, stamp: float) -> None:
        """Let the correction hold for a scan's stamp [s] too that was not taken in."""
        self._stamp = max(self._stamp, stamp)

    def take(self, update: SlamUpdate, stamp: float) -> None:
        """Publish what a scan of some stamp [s] brought."""
        first = self._update is None
        self._update, self._stamp = update, stamp
        self._fresh |= update.keyframe
        self._log(update.status)
        self._publish_pose(update, stamp)
        if first:
            self.publish_map()

    def _log(self, status: MatchStatus) -> None:
        if status is self._status:
            return
        self._status = status
        if status is MatchStatus.MATCHED:
            self._node.get_logger().info("scans match the map again")
        else:
            reason = f"scan matching: {status.value}; following the odometry"
            self._node.get_logger().warning(reason)

    def _publish_pose(self, update: SlamUpdate, stamp: float) -> None:
        c = self._node.config
        scale = np.diag([c.position_covariance_scale, c.position_covariance_scale, 1.0])
        scale[2, 2] = c.yaw_covariance_scale
        covariance = planar_covariance(np.sqrt(scale) @ update.covariance @ np.sqrt(scale))
        pose = PoseWithCovariance(pose=pose_msg(update.T_map_base), covariance=covariance)
        head = header(c.map_frame, stamp)
        self._pose.publish(PoseWithCovarianceStamped(header=head, pose=pose))
        if update.entropy is not None:
            self._entropy.publish(Float64(data=update.entropy))

    def broadcast(self) -> None:
        """Broadcast map -> odom, once for each time that it is dated: to tf2 twice is an error."""
        c = self._node.config
        stamp = self._node.now if c.restamp_tf else self._stamp
        if self._update is None or stamp <= self._broadcast_stamp:
            return
        self._broadcast_stamp = stamp
        dated = stamp + c.transform_timeout
        transform = transform_msg(self._update.T_map_odom, c.map_frame, c.odom_frame, dated)
        self._tf.publish(transforms_msg(transform))

    def map_message(self, most_moved: int | None = None) -> OccupancyGridMsg | None:
        """Return the map, or None before the first scan; `most_moved` as in `PoseTracker.map`."""
        grid = self._slam.map(most_moved)
        return None if grid is None else grid_msg(grid, self._node.config.map_frame, self._node.now)

    def _has_late_listeners(self) -> bool:
        """Return whether somebody listens to the map who gets none of before."""
        infos = self._node.get_subscriptions_info_by_topic(self._map.topic_name)
        return any(info.qos_profile.durability == DurabilityPolicy.VOLATILE for info in infos)

    def publish_map(self) -> None:
        """Publish map and graph, if they are others than before or always are to be.

        They are for whoever asks for no latched map, too: slam_toolbox publishes it each time, and
        programs that explore by it would wait for it beside a robot that stands.
        """
        unchanged = not (self._fresh or self._slam.keyframes.map_behind)
        always = self._node.config.publish_unchanged_map
        if unchanged and not (always or self._has_late_listeners()):
            return
        most_moved = 200  # keyframes traced again: a closure must not delay the scans
        message: Any = self.map_message(most_moved)
        if message is None:
            return
        self._fresh = False
        self._map.publish(message)
        self._metadata.publish(message.info)
        if self._graph.get_subscription_count():
            self._graph.publish(markers(self._slam.graph, message.header))
