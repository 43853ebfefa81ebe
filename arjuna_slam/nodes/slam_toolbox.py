"""slam_toolbox: the map and the robot in it, from its scans and odometry."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, ClassVar

import numpy as np
from geometry_msgs.msg import PoseWithCovariance, PoseWithCovarianceStamped
from nav_msgs.msg import MapMetaData
from nav_msgs.msg import OccupancyGrid as OccupancyGridMsg
from nav_msgs.srv import GetMap
from rclpy.logging import LoggingSeverity
from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import LaserScan
from slam_toolbox.srv import ClearQueue, Pause, Reset
from std_srvs.srv import Empty
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import MarkerArray

from arjuna_core.ros import qos
from arjuna_core.ros.convert import (
    grid_msg,
    header,
    planar_covariance,
    pose_msg,
    se2_from_pose,
    transform_msg,
)
from arjuna_core.ros.node import ManagedNode
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_slam.localization import Localizer
from arjuna_slam.mapping.session import Session, Start, StartKind
from arjuna_slam.matching.scan_filter import Skip
from arjuna_slam.matching.scan_matcher import MatchStatus
from arjuna_slam.nodes.graph_markers import markers
from arjuna_slam.nodes.scan_intake import ScanIntake, shortened
from arjuna_slam.nodes.slam_config import SlamNodeConfig
from arjuna_slam.nodes.slam_files import SlamFiles
from arjuna_slam.nodes.slam_interactive import InteractiveGraph
from arjuna_slam.slam import Slam, SlamUpdate

_RETRY = 0.02  # period at which waiting scans are looked at again [s]
_MOST_MOVED = 200  # keyframes traced anew for one map: a closure must not hold up the scans
_EVERY_SCAN = QoSProfile(depth=1000, reliability=ReliabilityPolicy.BEST_EFFORT)


class SlamToolboxNode(ManagedNode):
    """Feeds scans to SLAM, broadcasts map -> odom and publishes the map, as slam_toolbox does."""

    Config: ClassVar[type[Any]] = SlamNodeConfig
    DEFAULT_NAME = "slam_toolbox"

    def configure(self) -> None:
        """Build SLAM and the interfaces, and go on from a saved graph if one is named."""
        c = self.config
        self._warn_of_unused()
        self._scans = ScanIntake(self)
        self._paused = False
        self._map = self.publisher(OccupancyGridMsg, c.map_name, qos.LATCHED)
        self._metadata = self.publisher(MapMetaData, f"{c.map_name}_metadata", qos.LATCHED)
        self._pose = self.publisher(PoseWithCovarianceStamped, "pose", qos.DEFAULT)
        self._graph = self.publisher(MarkerArray, "slam_toolbox/graph_visualization", qos.LATEST)
        self._tf = self.publisher(TFMessage, "/tf", qos.TF)
        self._begin(self._new())
        self._interactive = InteractiveGraph(self)
        SlamFiles(self, self._resume).load_at_start()
        self._listen()

    def _warn_of_unused(self) -> None:
        """Name the parameters that have no meaning here, once."""
        if names := self.config.set_in_vain:
            self.get_logger().warning(f"accepted, but of no effect here: {', '.join(names)}")
        if self.config.debug_logging:
            self.get_logger().set_level(LoggingSeverity.DEBUG)

    def _listen(self) -> None:
        c = self.config
        profile = _EVERY_SCAN if c.synchronous else qos.SENSOR_SUBSCRIPTION
        self.subscribe(LaserScan, c.scan_topic, self._on_scan, profile)
        self.subscribe(PoseWithCovarianceStamped, "initialpose", self._on_initial_pose, qos.DEFAULT)
        self.serve(GetMap, "slam_toolbox/dynamic_map", self._on_dynamic_map)
        self.serve(Pause, "slam_toolbox/pause_new_measurements", self._on_pause)
        self.serve(ClearQueue, "slam_toolbox/clear_queue", self._on_clear_queue)
        self.serve(Reset, "slam_toolbox/reset", self._on_reset)
        self.serve(Empty, "slam_toolbox/clear_localization_buffer", self._on_clear_buffer)
        self.every(_RETRY, self._process_scans)
        self.every(c.map_update_interval, self._publish_map)
        if c.transform_publish_period > 0.0:
            self.every(c.transform_publish_period, self._broadcast)

    def deactivate(self) -> None:
        """Forget the scans that wait; say how many were of no use."""
        self._scans.clear()
        counts = {reason.value: n for reason, n in self.slam.scans.counts.items() if n}
        if counts:
            listed = ", ".join(f"{count} because {reason}" for reason, count in counts.items())
            self.get_logger().info(f"scans not used: {listed}")

    def on_time_jump(self) -> None:
        """Start a new map: the odometry has most likely been reset with the clock."""
        if self.active:
            self.get_logger().warning("time jumped back: the map starts anew")
            self._restart()

    def on_config(self, config: Any) -> None:
        """Say when it counts: SLAM keeps its parameters as long as its map."""
        self.get_logger().info("parameters of SLAM itself take effect at the next reset")

    def graph_changed(self) -> None:
        """Publish the map when it is next due, although no keyframe came."""
        self._fresh = len(self.slam.graph) > 0

    def _core_config(self) -> Any:
        c = self.config
        return replace(c, lifelong=True) if c.mode == "lifelong" else c

    def _new(self) -> Slam:
        return Slam(self._core_config())

    def _begin(self, slam: Slam | Localizer) -> None:
        """Go on with another mapper."""
        self.slam = slam
        self._update: SlamUpdate | None = None
        self._status = MatchStatus.MATCHED
        self._stamp = self._broadcast_stamp = -np.inf
        self._warned: set[Skip] = set()
        self.graph_changed()

    def _restart(self) -> None:
        self._scans.restart()
        self._begin(self._new())
        self._interactive.forget()

    def _resume(self, session: Session, start: Start, localize: bool) -> None:
        """Go on from a saved session, mapping or only localizing."""
        config = self._core_config()
        self._scans.restart()
        if localize:
            self._begin(Localizer(config, session, start))
        else:
            slam = Slam(config)
            slam.resume(session, start)
            self._begin(slam)
        self._interactive.forget()

    def _on_scan(self, message: Any) -> None:
        self._scans.add(message)
        self._process_scans()

    def _process_scans(self) -> None:
        for scan, T_odom_base in self._scans.ready():
            self._take_in(shortened(scan, self.config.min_laser_range), T_odom_base)

    def _take_in(self, scan: Scan, T_odom_base: SE2) -> None:
        if self._paused or self._interactive.on:
            self._stamp = scan.stamp
            return
        update = self.slam.process(scan, T_odom_base)
        if update is None:
            self._log_skipped(scan)
            return
        first = self._update is None
        self._update, self._stamp = update, scan.stamp
        self._fresh |= update.keyframe
        self._log_status(update.status)
        self._publish_pose(update, scan.stamp)
        if first:
            self._publish_map()
        if update.keyframe:
            self._interactive.show_scan(scan, update.T_map_base)
            self.get_logger().debug(f"keyframe {update.node}, {update.closures} loop edges")

    def _log_skipped(self, scan: Scan) -> None:
        """Warn of each kind of bad scan once; they are counted, and no more is made of them."""
        reason = self.slam.scans.last
        if reason is not None and reason not in self._warned:
            self._warned.add(reason)
            self.get_logger().warning(
                f"the scan of {scan.stamp:.3f} s is not used: {reason.value}; "
                "more of its kind are counted in silence"
            )

    def _on_initial_pose(self, message: Any) -> None:
        if not isinstance(self.slam, Localizer):
            self.get_logger().warning("initialpose is for localization; the map is being made")
            return
        try:
            pose = se2_from_pose(message.pose.pose)
        except ValueError as error:
            self.get_logger().warning(f"initialpose not used: {error}")
            return
        self.slam.restart(Start(StartKind.NEAR_POSE, pose))

    def _log_status(self, status: MatchStatus) -> None:
        if status is self._status:
            return
        self._status = status
        if status is MatchStatus.MATCHED:
            self.get_logger().info("scans match the map again")
        else:
            self.get_logger().warning(f"scan matching: {status.value}; following the odometry")

    def _publish_pose(self, update: SlamUpdate, stamp: float) -> None:
        c = self.config
        scale = np.diag([c.position_covariance_scale, c.position_covariance_scale, 1.0])
        scale[2, 2] = c.yaw_covariance_scale
        covariance = planar_covariance(np.sqrt(scale) @ update.covariance @ np.sqrt(scale))
        pose = PoseWithCovariance(pose=pose_msg(update.T_map_base), covariance=covariance)
        head = header(c.map_frame, stamp)
        self._pose.publish(PoseWithCovarianceStamped(header=head, pose=pose))

    def _broadcast(self) -> None:
        if self._update is None or self._stamp <= self._broadcast_stamp:
            return  # a stamp sent twice is an error to tf2
        self._broadcast_stamp = self._stamp
        c = self.config
        dated = (self.now if c.restamp_tf else self._stamp) + c.transform_timeout
        transform = transform_msg(self._update.T_map_odom, c.map_frame, c.odom_frame, dated)
        self._tf.publish(TFMessage(transforms=[transform]))

    def _map_message(self, most_moved: int | None = None) -> OccupancyGridMsg | None:
        grid = self.slam.map(most_moved)
        return None if grid is None else grid_msg(grid, self.config.map_frame, self.now)

    def _publish_map(self) -> None:
        if not (self._fresh or self.slam.map_behind):
            return
        message = self._map_message(_MOST_MOVED)
        if message is None:
            return
        self._fresh = False
        self._map.publish(message)
        self._metadata.publish(message.info)
        if self._graph.get_subscription_count():
            self._graph.publish(markers(self.slam.graph, message.header))

    def _on_dynamic_map(self, request: Any, response: Any) -> Any:
        message = self._map_message()
        if message is not None:
            response.map = message
        return response

    def _on_pause(self, request: Any, response: Any) -> Any:
        self._paused = not self._paused
        self.get_logger().info("scans are ignored" if self._paused else "scans are taken in")
        response.status = True
        return response

    def _on_clear_queue(self, request: Any, response: Any) -> Any:
        self._scans.clear()
        response.status = True
        return response

    def _on_clear_buffer(self, request: Any, response: Any) -> Any:
        self.get_logger().info("localization keeps no scans: there is nothing to clear")
        return response

    def _on_reset(self, request: Any, response: Any) -> Any:
        self._restart()
        self._paused = request.pause_new_measurements
        response.result = Reset.Response.RESULT_SUCCESS
        return response
