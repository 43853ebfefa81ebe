"""imu_filter_madgwick_node: orientation of a bare IMU, and of a compass where there is one."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from geometry_msgs.msg import Vector3Stamped
from sensor_msgs.msg import Imu, MagneticField
from tf2_msgs.msg import TFMessage

from arjuna_core.arrays import Floats
from arjuna_core.config import angle_param, duration_param, fixed, param, yaw_rate_param
from arjuna_core.geodesy import GRAVITY
from arjuna_core.pose3 import Pose3
from arjuna_core.ros import qos
from arjuna_core.ros.convert import pose3_msg, seconds, transform3_msg
from arjuna_core.ros.node import ManagedNode
from arjuna_core.ros.tf import transforms_msg
from arjuna_sim.processing.madgwick import UP, MadgwickFilter, orientation, quaternion_of, rotation


@dataclass(frozen=True)
class ImuFilterConfig:
    """Parameters of `imu_filter_madgwick`."""

    stateless: bool = fixed(False, "Whether each orientation is of one reading alone.")
    use_mag: bool = fixed(True, "Whether imu/mag gives the heading.")
    publish_tf: bool = param(True, "Whether the transform of the IMU's frame is published.")
    reverse_tf: bool = param(False, "Whether the IMU's frame is the parent in it.")
    fixed_frame: str = fixed("odom", "The transform's other frame.")
    constant_dt: float = duration_param(0.0, "Time between readings; 0 for that of their stamps.")
    remove_gravity_vector: bool = param(False, "Whether gravity is taken out of accelerations.")
    publish_debug_topics: bool = fixed(
        False, "Whether imu/rpy/raw and imu/rpy/filtered are published."
    )
    world_frame: str = fixed("enu", "The world's axes.", choices=tuple(UP))
    gain: float = yaw_rate_param(0.1, "How fast gravity and field correct.", maximum=1.0)
    zeta: float = param(
        0.0, "How fast they correct the gyro's bias.", unit="rad/s^2", minimum=0.0, maximum=1.0
    )
    mag_bias_x: float = param(0.0, "Bias of the field's x.", unit="T")
    mag_bias_y: float = param(0.0, "Bias of the field's y.", unit="T")
    mag_bias_z: float = param(0.0, "Bias of the field's z.", unit="T")
    orientation_stddev: float = angle_param(0.0, "Standard deviation that is published.")
    yaw_offset: float = fixed(0.0, "What is added to the heading.", unit="rad")
    declination: float = fixed(
        0.0, "Magnetic declination, which is taken from the heading.", unit="rad"
    )


class ImuFilterNode(ManagedNode):
    """Publishes `imu/data_raw` with an orientation on `imu/data`.

    With a compass nothing comes before its first message; the newest one counts for each reading.
    """

    Config = ImuFilterConfig
    DEFAULT_NAME = "imu_filter_madgwick"

    def configure(self) -> None:
        """Create the topics."""
        config: ImuFilterConfig = self.config
        self._filter: MadgwickFilter | None = None
        self._field: Floats | None = None
        self._last = 0.0
        self._out = self.publisher(Imu, "imu/data", qos.SENSOR_PUBLISHER)
        self._tf_out = self.publisher(TFMessage, "/tf", qos.TF)
        self._debug = {
            name: self.publisher(Vector3Stamped, f"imu/rpy/{name}", qos.SENSOR_PUBLISHER)
            for name in (("raw", "filtered") if config.publish_debug_topics else ())
        }
        self.subscribe(Imu, "imu/data_raw", self._on_imu, qos.SENSOR_SUBSCRIPTION)
        if config.use_mag:
            self.subscribe(MagneticField, "imu/mag", self._on_field, qos.SENSOR_SUBSCRIPTION)

    def on_config(self, config: ImuFilterConfig) -> None:
        """Take new gains."""
        if (running := getattr(self, "_filter", None)) is not None:
            running.gain, running.zeta = config.gain, config.zeta

    def on_time_jump(self) -> None:
        """Begin again."""
        self._filter = None

    def _on_field(self, message: Any) -> None:
        config, field = self.config, _vector(message.magnetic_field)
        bias = config.mag_bias_x, config.mag_bias_y, config.mag_bias_z
        self._field = field - bias if np.isfinite(field).all() else self._field

    def _on_imu(self, message: Any) -> None:
        config: ImuFilterConfig = self.config
        acceleration, rates = (
            _vector(v) for v in (message.linear_acceleration, message.angular_velocity)
        )
        stamp = seconds(message.header.stamp)
        if config.use_mag and self._field is None:
            return
        if self._filter is None or config.stateless:
            if not acceleration.any():
                return
            self._filter = MadgwickFilter(config.world_frame, config.gain, config.zeta)
            self._filter.start(acceleration, self._field)
        else:
            dt = config.constant_dt or stamp - self._last
            if dt <= 0.0:
                return
            self._filter.update(dt, rates, acceleration, self._field)
        self._last = stamp
        self._publish(message, stamp, self._filter.quaternion, acceleration)

    def _publish(
        self, message: Any, stamp: float, quaternion: Floats, acceleration: Floats
    ) -> None:
        config: ImuFilterConfig = self.config
        turned = Pose3.from_rpy((0.0, 0.0, 0.0), (0.0, 0.0, config.yaw_offset - config.declination))
        w, x, y, z = quaternion.tolist()
        pose = turned @ Pose3(quaternion=(w, x, y, z))
        message.orientation = pose3_msg(pose).orientation
        message.orientation_covariance = np.eye(3).ravel() * config.orientation_stddev**2
        if config.remove_gravity_vector:
            rest = rotation(quaternion).T @ np.array(UP[config.world_frame]) * GRAVITY
            felt = message.linear_acceleration
            felt.x, felt.y, felt.z = (acceleration - rest).tolist()
        self._out.publish(message)
        if config.publish_tf:
            T, parent, child = pose, config.fixed_frame, message.header.frame_id
            if config.reverse_tf:
                T, parent, child = pose.inverse(), child, parent
            self._tf_out.publish(transforms_msg(transform3_msg(T, parent, child, stamp)))
        for name, out in self._debug.items():
            shown = pose
            if name == "raw" and acceleration.any():
                raw = quaternion_of(orientation(acceleration, self._field, config.world_frame))
                shown = Pose3(quaternion=tuple(raw.tolist()))
            angles = Vector3Stamped(header=message.header)
            angles.vector.x, angles.vector.y, angles.vector.z = shown.rpy()
            out.publish(angles)


def _vector(message: Any) -> Floats:
    found = np.array((message.x, message.y, message.z))
    return found if math.isfinite(found.sum()) else np.where(np.isfinite(found), found, 0.0)
