"""slam_toolbox: the map and the robot in it, from its scans and odometry."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from geometry_msgs.msg import PoseWithCovarianceStamped
from nav_msgs.srv import GetMap
from rclpy.logging import LoggingSeverity
from rclpy.qos import QoSProfile, ReliabilityPolicy
from slam_toolbox.srv import ClearQueue, Pause, Reset
from std_srvs.srv import Empty, SetBool

from arjuna_core.ros import qos
from arjuna_core.ros.convert import se2_from_pose
from arjuna_core.ros.node import ManagedNode
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_slam.config import LEAST_INTERVAL, SlamNodeConfig
from arjuna_slam.localization import Localizer
from arjuna_slam.mapping.session import Session, Start, StartKind
from arjuna_slam.matching.scan_filter import Skip
from arjuna_slam.nodes.scan_intake import ScanIntake, shortened, subscribe_scans
from arjuna_slam.nodes.slam_files import MapMemory, SlamFiles
from arjuna_slam.nodes.slam_interactive import InteractiveGraph
from arjuna_slam.nodes.slam_output import SlamOutput
from arjuna_slam.pose_tracker import PoseTracker
from arjuna_slam.slam import Slam

_EVERY_SCAN = QoSProfile(depth=1000, reliability=ReliabilityPolicy.BEST_EFFORT)


class SlamToolboxNode(ManagedNode):
    """Feeds scans to SLAM, broadcasts map -> odom and publishes the map, as slam_toolbox does."""

    Config: ClassVar[type[Any]] = SlamNodeConfig
    DEFAULT_NAME = "slam_toolbox"

    def configure(self) -> None:
        for correction in self.config.corrections:
            self.get_logger().warning(correction)
        if self.config.debug_logging:
            self.get_logger().set_level(LoggingSeverity.DEBUG)
        self._scans = ScanIntake(self)
        self._paused = False
        self._use(Slam(self.config.core))
        self._output = SlamOutput(self, self.slam)
        self._interactive = InteractiveGraph(self)
        self.memory = self.keep(MapMemory(self, self.config.resume_file))
        files = SlamFiles(self, self._resume)
        if (session := self.memory.recall()) is not None:  # of before a crash
            self._continue(session, Start(StartKind.ODOMETRY))
        else:
            files.load_at_start()
        self._listen()

    def _listen(self) -> None:
        c = self.config
        profile = _EVERY_SCAN if c.synchronous else qos.SENSOR_SUBSCRIPTION
        subscribe_scans(self, c.scan_topic, profile, self._on_scan)
        self.subscribe(PoseWithCovarianceStamped, "initialpose", self._on_initial_pose, qos.DEFAULT)
        self.serve(GetMap, "slam_toolbox/dynamic_map", self._on_dynamic_map)
        self.serve(Pause, "slam_toolbox/pause_new_measurements", self._on_pause)
        self.serve(ClearQueue, "slam_toolbox/clear_queue", self._on_clear_queue)
        self.serve(Reset, "slam_toolbox/reset", self._on_reset)
        self.serve(Empty, "slam_toolbox/clear_localization_buffer", self._on_clear_buffer)
        self.serve(SetBool, "slam_toolbox/set_localization_mode", self._on_localization_mode)
        retry = 0.02  # period at which waiting scans are looked at again [s]
        self.every(retry, self._process_scans)
        self.every(max(c.map_update_interval, LEAST_INTERVAL), self._output.publish_map)
        keep = 5.0  # [s] between two copies of the map that outlive the process
        self.every(keep, self._keep_map)
        if c.transform_publish_period > 0.0:
            self.every(c.transform_publish_period, self._output.broadcast)

    def deactivate(self) -> None:
        self._scans.clear()
        self.memory.forget()
        counts = {reason.value: n for reason, n in self.slam.scans.counts.items() if n}
        if counts:
            listed = ", ".join(f"{count} because {reason}" for reason, count in counts.items())
            self.get_logger().info(f"scans not used: {listed}")

    def on_time_jump(self) -> None:
        """Start a new map: the odometry has most likely been reset with the clock."""
        if self.active:
            self.get_logger().warning("time jumped back: a new map begins")
            self._restart()

    def on_config(self, config: Any) -> None:
        self.get_logger().info("parameters of SLAM itself take effect at the next reset")

    def close_by_hand(self, moved: Mapping[int, SE2]) -> int:
        """Close loops where keyframes were put by hand; return how many, none on a saved graph."""
        closed = 0 if self._mapping is None else self._mapping.close_by_hand(moved)
        self._output.graph_changed()
        return closed

    def _use(self, slam: PoseTracker) -> None:
        self.slam = slam
        self._mapping = slam if isinstance(slam, Slam) else None
        self._localizer = slam if isinstance(slam, Localizer) else None
        self._warned: set[Skip] = set()

    def _begin_with(self, slam: PoseTracker) -> None:
        """Use another mapper, and forget what was of the one before."""
        self._use(slam)
        self._scans.restart()
        self._output.restart(slam)
        self._interactive.forget()

    def _restart(self) -> None:
        self.memory.forget()
        self._begin_with(Slam(self.config.core))

    def _resume(self, session: Session, start: Start, localize: bool) -> None:
        self.memory.forget()
        if localize:
            self._begin_with(Localizer(self.config.core, session, start))
        else:
            self._continue(session, start)

    def _continue(self, session: Session, start: Start) -> None:
        slam = Slam(self.config.core)
        slam.resume(session, start)
        self._begin_with(slam)

    def _on_scan(self, message: Any) -> None:
        self._scans.add(message)
        self._process_scans()

    def _process_scans(self) -> None:
        for scan, T_odom_base in self._scans.ready():
            self._take_in(shortened(scan, self.config.min_laser_range), T_odom_base)
        self._output.hold(self._scans.passed_over)

    def _keep_map(self) -> None:
        if self._mapping is not None:
            self.memory.remember(self._mapping)

    def _take_in(self, scan: Scan, T_odom_base: SE2) -> None:
        if self.memory.recalled_from > scan.stamp:
            self.on_time_jump()
        if self._paused or self._interactive.on:
            self._output.hold(scan.stamp)
            return
        update = self.slam.process(scan, T_odom_base)
        if update is None:
            self._log_skipped(scan)
            return
        self._output.take(update, scan.stamp)
        if update.keyframe:
            self._interactive.show_scan(scan, update.T_map_base)
            self.get_logger().debug(f"keyframe {update.node}, {update.closures} loop edges")

    def _log_skipped(self, scan: Scan) -> None:
        """Warn of each kind of bad scan once; odometry carries over those without a beam."""
        reason = self.slam.scans.last
        if reason is Skip.EMPTY:
            self._output.hold(scan.stamp)
        if reason is not None and reason not in self._warned:
            self._warned.add(reason)
            self.get_logger().warning(
                f"the scan of {scan.stamp:.3f} s is not used: {reason.value}; "
                "more of its kind are counted in silence"
            )

    def _on_initial_pose(self, message: Any) -> None:
        if self._localizer is None:
            self.get_logger().warning("initialpose is for localization; the map is being made")
            return
        try:
            pose = se2_from_pose(message.pose.pose)
        except ValueError as error:
            self.get_logger().warning(f"initialpose not used: {error}")
            return
        self._localizer.restart(Start(StartKind.NEAR_POSE, pose))

    def _on_dynamic_map(self, request: Any, response: Any) -> Any:
        message = self._output.map_message()
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
        if self._localizer is not None:
            self._localizer.clear_buffer()
            self._output.graph_changed()
        return response

    def _on_localization_mode(self, request: Any, response: Any) -> Any:
        """Only localize on the map made so far, or continue it, from where the robot is."""
        session, pose = self.slam.session(), self._output.T_map_base
        response.success = session is not None and pose is not None
        response.message = "no scan has come yet"
        if session is not None and pose is not None:
            if request.data != (self._localizer is not None):
                self._resume(session, Start(StartKind.NEAR_POSE, pose), request.data)
            response.message = f"{'localization' if request.data else 'mapping'} mode"
        return response

    def _on_reset(self, request: Any, response: Any) -> Any:
        self._restart()
        self._paused = request.pause_new_measurements
        response.result = Reset.Response.RESULT_SUCCESS
        return response
