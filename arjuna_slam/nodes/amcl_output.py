"""The output of the amcl node: pose, quality, particles and the transform to odom."""

from __future__ import annotations

import math

from arjuna_interfaces.msg import LocalizationQuality
from geometry_msgs.msg import PoseWithCovariance, PoseWithCovarianceStamped
from nav2_msgs.msg import Particle, ParticleCloud
from rclpy.parameter import Parameter

from arjuna_core.ros import qos
from arjuna_core.ros.convert import header, planar_covariance, pose_msg, transform_msg
from arjuna_core.ros.node import ManagedNode
from arjuna_core.ros.tf import TransformPublisher, transforms_msg
from arjuna_core.se2 import SE2
from arjuna_slam.amcl.belief import Belief
from arjuna_slam.amcl.estimate import Estimate, Status

_LONGEST = 1.0  # [s] that map -> odom is dated ahead for slow scans, Nav2's transform_tolerance


class AmclOutput:
    """The publishers of amcl, whose configuration names the frames."""

    def __init__(self, node: ManagedNode) -> None:
        self._node = node
        self._status: Status | None = None  # that was logged last
        self._covered = -math.inf  # until when map -> odom was broadcast [s]
        self._scanned = -math.inf  # the stamp of the last scan [s]
        self._poses = node.publisher(PoseWithCovarianceStamped, "amcl_pose", qos.LATCHED)
        self._cloud = node.publisher(ParticleCloud, "particle_cloud", qos.SENSOR_PUBLISHER)
        self._quality = node.publisher(
            LocalizationQuality, "amcl/localization_quality", qos.LATCHED
        )
        self._tf = TransformPublisher(node, "/tf", qos.TF)

    def restart(self) -> None:
        """Forget what was broadcast, after the clock was set back."""
        self._covered = self._scanned = -math.inf

    def broadcast(self, T_map_odom: SE2, stamp: float) -> None:
        """Broadcast map -> odom, dated ahead of a scan's stamp [s] by the tolerance.

        Two periods of the scans are covered at least, for whoever transforms what is newer than
        the last scan before the next one is processed.
        """
        c = self._node.config
        period = stamp - self._scanned if math.isfinite(self._scanned) else 0.0
        self._scanned = stamp
        dates = [stamp + max(c.transform_tolerance, min(2.0 * period, _LONGEST))]
        if stamp > self._covered:  # after a pause nothing covers the scan itself
            dates.insert(0, stamp)
        self._covered = dates[-1]
        frames = (c.global_frame_id, c.odom_frame_id)
        transforms = [transform_msg(T_map_odom, *frames, date) for date in dates]
        self._tf.publish(transforms_msg(*transforms))

    def publish(self, estimate: Estimate, belief: Belief, stamp: float) -> None:
        """Publish an estimate of a time [s], and the particles to those who listen."""
        self._log_change(estimate)
        head = header(self._node.config.global_frame_id, stamp)
        pose = PoseWithCovariance(
            pose=pose_msg(estimate.T_map_base), covariance=planar_covariance(estimate.covariance)
        )
        self._poses.publish(PoseWithCovarianceStamped(header=head, pose=pose))
        self._quality.publish(
            LocalizationQuality(header=head, quality=estimate.quality, reason=estimate.reason)
        )
        if self._cloud.get_subscription_count():
            rows = zip(belief.particles, belief.weights.tolist(), strict=True)
            particles = [
                Particle(pose=pose_msg(SE2.from_array(row)), weight=weight) for row, weight in rows
            ]
            self._cloud.publish(ParticleCloud(header=head, particles=particles))

    def save(self, estimate: Estimate) -> None:
        """Write a pose that is tracked to initial_pose, so that a later start continues there."""
        if estimate.status is Status.TRACKING:
            pose = estimate.T_map_base
            values = {"x": pose.x, "y": pose.y, "yaw": pose.theta}
            self._node.set_parameters_atomically(
                [Parameter(f"initial_pose.{name}", value=value) for name, value in values.items()]
            )

    def _log_change(self, estimate: Estimate) -> None:
        if estimate.status is self._status:
            return
        self._status = estimate.status
        if estimate.status is Status.TRACKING:
            self._node.get_logger().info(f"tracking: {estimate.reason}")
        else:
            self._node.get_logger().warning(f"{estimate.status.value}: {estimate.reason}")
