"""slam_toolbox: the map and the robot in it, from its scans and odometry."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np
from geometry_msgs.msg import PoseWithCovariance, PoseWithCovarianceStamped
from nav_msgs.msg import MapMetaData
from nav_msgs.msg import OccupancyGrid as OccupancyGridMsg
from nav_msgs.srv import GetMap
from sensor_msgs.msg import LaserScan
from slam_toolbox.srv import Clear, LoopClosure, Pause, Reset, SaveMap
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import MarkerArray

from arjuna_core.errors import MapError
from arjuna_core.map_io import save_map
from arjuna_core.ros import qos
from arjuna_core.ros.convert import grid_msg, header, planar_covariance, pose_msg, transform_msg
from arjuna_core.ros.node import ManagedNode
from arjuna_core.ros.scan_queue import ScanQueue
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_slam.maps_folder import MapsFolderError, inside
from arjuna_slam.nodes.graph_markers import markers
from arjuna_slam.nodes.slam_config import SlamNodeConfig
from arjuna_slam.scan_matcher import MatchStatus
from arjuna_slam.slam import Slam, SlamUpdate

_RETRY = 0.02  # period at which waiting scans are looked at again [s]


class SlamToolboxNode(ManagedNode):
    """Feeds scans to SLAM, broadcasts map -> odom and publishes the map, as slam_toolbox does."""

    Config: ClassVar[type[Any]] = SlamNodeConfig
    DEFAULT_NAME = "slam_toolbox"

    def configure(self) -> None:
        """Build SLAM and the interfaces."""
        c = self.config
        self.slam = Slam(c)
        self._scans = ScanQueue(self, c.odom_frame, c.base_frame)
        self._paused = False
        self._update: SlamUpdate | None = None
        self._status = MatchStatus.MATCHED
        self._stamp = self._broadcast_stamp = -np.inf
        self._fresh = False
        self._map = self.publisher(OccupancyGridMsg, c.map_name, qos.LATCHED)
        self._metadata = self.publisher(MapMetaData, f"{c.map_name}_metadata", qos.LATCHED)
        self._pose = self.publisher(PoseWithCovarianceStamped, "pose", qos.DEFAULT)
        self._graph = self.publisher(MarkerArray, "slam_toolbox/graph_visualization", qos.LATEST)
        self._tf = self.publisher(TFMessage, "/tf", qos.TF)
        self._listen()

    def _listen(self) -> None:
        c = self.config
        self.subscribe(LaserScan, c.scan_topic, self._on_scan, qos.SENSOR_SUBSCRIPTION)
        self.serve(GetMap, "slam_toolbox/dynamic_map", self._on_dynamic_map)
        self.serve(SaveMap, "slam_toolbox/save_map", self._on_save_map)
        self.serve(Pause, "slam_toolbox/pause_new_measurements", self._on_pause)
        self.serve(Reset, "slam_toolbox/reset", self._on_reset)
        self.serve(LoopClosure, "slam_toolbox/manual_loop_closure", self._on_loop_closure)
        self.serve(Clear, "slam_toolbox/clear_changes", self._on_clear)
        self.every(_RETRY, self._process_scans)
        self.every(c.map_update_interval, self._publish_map)
        if c.transform_publish_period > 0.0:
            self.every(c.transform_publish_period, self._broadcast)

    def deactivate(self) -> None:
        """Forget the scans that wait."""
        self._scans.clear()

    def on_time_jump(self) -> None:
        """Start a new map: the odometry has most likely been reset with the clock."""
        if self.active:
            self.get_logger().warning("time jumped back: the map starts anew")
            self._restart()

    def on_config(self, config: Any) -> None:
        """Say when it counts: SLAM keeps its parameters as long as its map."""
        self.get_logger().info("parameters of SLAM itself take effect at the next reset")

    def _restart(self) -> None:
        self._scans.clear()
        self.slam = Slam(self.config)
        self._update = None
        self._stamp = self._broadcast_stamp = -np.inf
        self._fresh = False

    def _on_scan(self, message: Any) -> None:
        self._scans.add(message)
        self._process_scans()

    def _process_scans(self) -> None:
        for scan, T_odom_base in self._scans.ready():
            self._take_in(scan, T_odom_base)

    def _take_in(self, scan: Scan, T_odom_base: SE2) -> None:
        if self._paused:
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

    def _log_skipped(self, scan: Scan) -> None:
        count = self.slam.skipped
        if count in (1, 10) or count % 100 == 0:
            self.get_logger().warning(
                f"{count} scans skipped so far; the last, of {scan.stamp:.3f} s, "
                "has nothing in range or is no newer than the one before"
            )

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
        dated = self._stamp + c.transform_timeout
        transform = transform_msg(self._update.T_map_odom, c.map_frame, c.odom_frame, dated)
        self._tf.publish(TFMessage(transforms=[transform]))

    def _map_message(self) -> OccupancyGridMsg | None:
        grid = self.slam.map()
        return None if grid is None else grid_msg(grid, self.config.map_frame, self.now)

    def _publish_map(self) -> None:
        if not self._fresh:
            return
        message = self._map_message()
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

    def _on_save_map(self, request: Any, response: Any) -> Any:
        grid = self.slam.map()
        if grid is None:
            response.result = SaveMap.Response.RESULT_NO_MAP_RECEIEVD
            return response
        try:
            path, _ = save_map(grid, inside(self.config.maps_folder, request.name.data))
            self.get_logger().info(f"map saved as {path}")
            response.result = SaveMap.Response.RESULT_SUCCESS
        except (MapError, MapsFolderError) as error:
            self.get_logger().error(f"map not saved: {error}")
            response.result = SaveMap.Response.RESULT_UNDEFINED_FAILURE
        return response

    def _on_pause(self, request: Any, response: Any) -> Any:
        self._paused = not self._paused
        self.get_logger().info("scans are ignored" if self._paused else "scans are taken in")
        response.status = True
        return response

    def _on_reset(self, request: Any, response: Any) -> Any:
        self._restart()
        self._paused = request.pause_new_measurements
        response.result = Reset.Response.RESULT_SUCCESS
        return response

    def _on_loop_closure(self, request: Any, response: Any) -> Any:
        self.slam.optimize()
        self._fresh = len(self.slam.graph) > 0
        return response

    def _on_clear(self, request: Any, response: Any) -> Any:
        return response  # nodes cannot be moved by hand, so there is nothing to undo
