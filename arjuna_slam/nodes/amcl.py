"""amcl: where the robot is in the map, from its scans and odometry."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np
from geometry_msgs.msg import PoseWithCovarianceStamped
from nav2_msgs.srv import SetInitialPose
from nav_msgs.msg import OccupancyGrid as OccupancyGridMsg
from std_srvs.srv import Empty

from arjuna_core.grid import OccupancyGrid
from arjuna_core.ros import qos
from arjuna_core.ros.convert import (
    covariance_from_pose,
    grid_from_msg,
    se2_from_pose,
    seconds,
)
from arjuna_core.ros.node import ManagedNode
from arjuna_core.ros.scan_queue import BaseFrames, ScanQueue
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_slam.amcl.config import ALWAYS, NEVER, AmclNodeConfig, filter_part
from arjuna_slam.amcl.estimate import Estimate, LocalizationError, Status
from arjuna_slam.amcl.filter import ParticleFilter
from arjuna_slam.nodes.amcl_output import AmclOutput
from arjuna_slam.nodes.scan_intake import subscribe_scans

_PARAMETER_COVARIANCE = np.diag([0.25, 0.25, 0.0685])  # RViz's: half a metre, fifteen degrees


class AmclNode(ManagedNode):
    """Feeds scans to the particle filter and broadcasts map -> odom, as nav2_amcl does.

    Besides nav2_amcl's topics it publishes `amcl/localization_quality`.
    """

    Config: ClassVar[type[Any]] = AmclNodeConfig
    DEFAULT_NAME = "amcl"

    _grid: OccupancyGrid | None = None
    _filter: ParticleFilter | None = None
    _built_for: tuple[Any, ...] = ()
    _estimate: Estimate | None = None
    _given: tuple[SE2, Any] | None = None  # an initial pose that waits for the map
    _doubted = 0.0  # quality that must be reached before the pose is published again; 0: none

    def configure(self) -> None:
        self._rng = np.random.default_rng(self.config.seed)
        pose = self.config.odom_frame_id, self.config.base_frame_id
        self._scans = ScanQueue(BaseFrames(self, *pose, parameter="base_frame_id", adopt=True))
        self._update_wanted = False
        self._output = AmclOutput(self)
        self._listen()
        if self.config.save_pose_rate > 0.0:
            self.every(1.0 / self.config.save_pose_rate, self._save_pose)

    def _listen(self) -> None:
        c = self.config
        self.subscribe(
            *(OccupancyGridMsg, c.map_topic, self._on_map, qos.LATCHED),
            while_inactive=True,
            shared=True,
        )
        subscribe_scans(self, c.scan_topic, qos.SENSOR_SUBSCRIPTION, self._on_scan)
        self.subscribe(
            PoseWithCovarianceStamped,
            "initialpose",
            self._on_initial_pose,
            qos.DEFAULT,
            while_inactive=True,
        )
        self.serve(Empty, "reinitialize_global_localization", self._on_globalize)
        self.serve(Empty, "request_nomotion_update", self._on_nomotion)
        self.serve(SetInitialPose, "set_initial_pose", self._on_set_initial_pose)
        retry = 0.02  # period at which waiting scans are looked at again [s]
        self.every(retry, self._process_scans)

    def activate(self) -> None:
        if self.config.always_reset_initial_pose:
            self._estimate = None
        self._begin()

    def deactivate(self) -> None:
        self._scans.clear()

    def cleanup(self) -> None:
        self._doubted = 0.0
        self._grid = self._filter = self._estimate = self._given = None

    def on_time_jump(self) -> None:
        """Start again: the odometry has most likely been reset with the clock."""
        if self.active:
            self._output.restart()
            self._scans.clear()
            self._estimate = None
            self._begin()

    def on_config(self, config: Any) -> None:
        """Rebuild the filter around the last estimate, if the change affects it."""
        if self._grid is not None and filter_part(config) != self._built_for:
            self._build(self._grid)

    def trouble(self) -> str:
        estimate = self._estimate
        if estimate is None or (estimate.status is not Status.LOST and not self._doubted):
            return ""
        return f"lost{' since the map was replaced' * bool(self._doubted)}: {estimate.reason}"

    def _on_map(self, message: Any) -> None:
        """Take a map; on one that replaces another the pose is trusted once scans agree.

        With `relocalize` only: else, as Nav2 does, it is broadcast whatever the scans say.
        """
        replaces = self._grid is not None
        if replaces and self.config.first_map_only:
            return
        try:
            self._build(grid_from_msg(message))
        except ValueError as error:
            self._refuse("map", error)
            return
        kept = 0.8  # share of the quality that the new map must reach
        if replaces and self._estimate is not None and self.config.relocalize:
            before = kept * self._estimate.quality
            self._doubted = min(float(self.config.relocalize_agreement), before)

    def _build(self, grid: OccupancyGrid) -> None:
        try:
            belief = ParticleFilter(self.config, grid, self._rng)
        except LocalizationError as error:
            self._refuse("map or parameters", error)
            return
        self._grid, self._filter = grid, belief
        self._built_for = filter_part(self.config)
        if self.active:
            self._begin()

    def _refuse(self, what: str, why: object) -> None:
        self.get_logger().error(f"{what} refused, all stays as it was: {why}")

    def _begin(self) -> None:
        if self._filter is None:
            return
        mode = self.config.global_localization_at_start
        if mode != ALWAYS or self._estimate is not None:
            start = self._given or self._known()
            if start is not None and self._start_at(*start):
                return
        if mode != NEVER:
            self._filter.globalize()
        elif not self._filter.initialized:
            self.get_logger().warning("there is no initial pose: publish one on initialpose")

    def _known(self) -> tuple[SE2, Any] | None:
        if self._estimate is not None:
            return self._estimate.T_map_base, self._estimate.covariance
        start = self.config.initial_pose
        given = (SE2(start.x, start.y, start.yaw), _PARAMETER_COVARIANCE)
        return given if self.config.set_initial_pose else None

    def _start_at(self, pose: SE2, covariance: Any) -> bool:
        """Start the filter at a pose, or keep that until a map comes; return whether it started."""
        if self._filter is None:
            self._given = (pose, covariance)
            return False
        self._given = None
        try:
            self._filter.set_pose(pose, covariance)
        except LocalizationError as error:
            self._refuse("initial pose", error)
            return False
        return True

    def _on_initial_pose(self, message: Any) -> None:
        frame, wanted = message.header.frame_id.lstrip("/"), self.config.global_frame_id
        if frame != wanted:
            self._refuse("initial pose", f"frame '{frame}', valid: '{wanted}'")
            return
        try:
            pose = se2_from_pose(message.pose.pose)
        except ValueError as error:
            self._refuse("initial pose", error)
            return
        self._doubted = 0.0
        start = pose @ self._moved_since(seconds(message.header.stamp))
        self._given = (start, covariance_from_pose(message.pose.covariance))
        if self.active:
            self._start_at(*self._given)

    def _moved_since(self, stamp: float) -> SE2:
        """Return how far the robot has moved since a time [s], by odometry; 0: it is now.

        Source: nav2_amcl, AmclNode::handleInitialPose.
        """
        frames = self.config.odom_frame_id, self.config.base_frame_id
        then = self.transforms.try_lookup(*frames, stamp) if stamp > 0.0 else None
        now = self.transforms.try_lookup(*frames)
        return SE2() if then is None or now is None else then.inverse() @ now

    def _on_set_initial_pose(self, request: Any, response: Any) -> Any:
        self._on_initial_pose(request.pose)
        return response

    def _on_globalize(self, request: Any, response: Any) -> Any:
        if self.active and self._filter is not None:
            self._filter.globalize()
        return response

    def _on_nomotion(self, request: Any, response: Any) -> Any:
        self._update_wanted = True
        return response

    def _on_scan(self, message: Any) -> None:
        self._scans.add(message)
        self._process_scans()

    def _process_scans(self) -> None:
        if self._filter is not None:
            for scan, T_odom_base in self._scans.ready():
                self._take_in(self._filter, scan, T_odom_base)

    def _take_in(self, localizer: ParticleFilter, scan: Scan, T_odom_base: SE2) -> None:
        try:
            estimate = localizer.update(T_odom_base, scan, self._update_wanted)
        except LocalizationError as error:
            self._refuse(f"scan at {scan.stamp:.3f} s", error)
            return
        self._update_wanted = False
        if estimate is not None:
            self._estimate = estimate
            self._output.publish(estimate, localizer.belief, scan.stamp)
            if estimate.quality >= self._doubted:
                self._doubted = 0.0
        last = self._estimate
        if last is None or self._doubted or not self.config.tf_broadcast:
            return
        self._output.broadcast(last.T_map_odom, scan.stamp)

    def _save_pose(self) -> None:
        if self._estimate is not None and not self.config.always_reset_initial_pose:
            self._output.save(self._estimate)
