"""ekf_filter_node: odometry from the wheels' odometry and the IMU's gyro."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from nav_msgs.msg import Odometry
from sensor_msgs.msg import Imu

from arjuna_core.config import duration_param, fixed, param
from arjuna_core.errors import ConfigError
from arjuna_core.ros import qos
from arjuna_core.ros.convert import seconds, transform_msg
from arjuna_core.ros.node import ManagedNode
from arjuna_core.ros.tf import TransformError, TransformPublisher, transforms_msg
from arjuna_sim.devices.ekf import FusedOdometry, FusedOdometryConfig
from arjuna_sim.devices.odometry import OdometryEstimate
from arjuna_sim.model.settings import WHEEL_ODOMETRY
from arjuna_sim.nodes.messages import odometry_msg

_Vector = tuple[float, float, float]


@dataclass(frozen=True)
class EkfConfig(FusedOdometryConfig):
    """Parameters of the node `ekf_filter_node`, over those of the filter."""

    odom0: str = fixed(WHEEL_ODOMETRY, "Topic of the wheels' odometry.")
    imu0: str = fixed(
        "imu/data", "Topic of the IMU; of one without an orientation /tf gives its mounting."
    )
    odom_topic: str = fixed("odom", "Topic of the fused odometry.")
    sensor_timeout: float = duration_param(
        0.5, "Wheels that say nothing for so long end the odometry.", minimum=0.02, maximum=60.0
    )
    publish_tf: bool = param(True, "Whether the transform of odometry is published.")


class EkfNode(ManagedNode):
    """Publishes odometry and its transform as wheels and gyro come; silent without wheels."""

    Config = EkfConfig
    DEFAULT_NAME = "ekf_filter_node"

    def configure(self) -> None:
        """Build the filter and create the topics.

        Raises:
            ConfigError: Its input is its own output.
        """
        config: EkfConfig = self.config
        self._check_inputs()
        self._begin()
        self._tf_out = TransformPublisher(self, "/tf", qos.TF)
        self._odom_out = self.publisher(Odometry, config.odom_topic, qos.DEFAULT)
        self.subscribe(Odometry, config.odom0, self._on_wheels, qos.DEFAULT)
        self.subscribe(Imu, config.imu0, self._on_imu, qos.SENSOR_SUBSCRIPTION)
        self._silent = 0  # looks that found no wheels, or wheels alone
        # [s] What does not come is reported after 5 s at the latest.
        self.every(5.0 / 2, self._check_silence)

    def _check_inputs(self) -> None:
        """Refuse a filter that would listen to itself, as `odom0: odom` here."""
        config, output = self.config, self.full_topic(self.config.odom_topic)
        if self.full_topic(config.odom0) == output:
            raise ConfigError(
                f"odom0 '{config.odom0}' is {output}, which this filter publishes: it would listen"
                f" to itself\nvalid: the wheels' own topic, here odom0: {WHEEL_ODOMETRY}, or"
                " another output, as odom_topic: odometry/filtered"
            )

    def _check_silence(self) -> None:
        if self._wheels is not None and self._has_gyro:
            return
        self._silent += 1
        # Of a robot without an IMU the simulator publishes odometry itself: nothing is to be fused.
        alone = self.count_publishers(self.full_topic(self.config.odom_topic)) < 2
        if self._silent != 2 or not alone:
            return
        silent = self.config.odom0 if self._wheels is None else self.config.imu0
        topic = self.full_topic(silent)
        count = self.count_publishers(topic)
        if self._wheels is not None:
            self.get_logger().warning(
                f"no gyro has come on {topic} (imu0), which {count} publish: odometry is that of"
                " the wheels alone, whose headings err by their slip"
            )
        else:
            self.get_logger().warning(
                f"no odometry of the wheels has come on {topic} (odom0), which {count} publish:"
                f" there is none of this filter; the simulator's wheels publish {WHEEL_ODOMETRY}"
            )

    def on_time_jump(self) -> None:
        """Restart at the origin, as the wheels' odometry does."""
        self._begin()

    def on_config(self, config: Any) -> None:
        """Trust wheels and gyro otherwise."""
        self._filter.config = config

    def _begin(self) -> None:
        self._filter = FusedOdometry(self.config)
        self._stamp: float | None = None
        self._wheels: Any = None  # their last message
        self._mounts: dict[str, _Vector] = {}  # the vertical, by the frame of an IMU that sits fast
        self._waiting = False  # it is not in the filter yet
        self._has_gyro = False  # the IMU has said something

    def _on_wheels(self, message: Any) -> None:
        """Wait for the gyro of the same instant; continue without if the last message had none."""
        if self._waiting:
            self._take_wheels()
            self._publish(self._filter.estimate)
        self._wheels, self._waiting = message, True

    def _on_imu(self, message: Any) -> None:
        if self._wheels is None:
            return
        now, wheels = seconds(message.header.stamp), seconds(self._wheels.header.stamp)
        since = wheels if self._stamp is None else self._stamp
        if now < since or now > wheels + self.config.sensor_timeout:
            return
        if self._waiting and now >= wheels:
            self._take_wheels()
        self._predict_to(now)
        self._has_gyro = True
        # Index 8 of a row-major 3 x 3 covariance is the variance about z.
        variance = float(message.angular_velocity_covariance[8])
        rates, up = message.angular_velocity, self._up(message)
        self._filter.gyro(up[0] * rates.x + up[1] * rates.y + up[2] * rates.z, variance)
        if not self._waiting:  # else the wheels of this tick say the rest of it
            self._publish(self._filter.estimate)

    def _up(self, message: Any) -> _Vector:
        """Return the vertical in an IMU's frame, by what it says or else by how it is mounted."""
        q = message.orientation
        length = q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z
        # A quaternion whose length is off by more than 1 % is no orientation.
        if message.orientation_covariance[0] >= 0.0 and abs(length - 1.0) <= 0.01:
            x, y = 2.0 * (q.x * q.z - q.w * q.y), 2.0 * (q.y * q.z + q.w * q.x)
            return x, y, 1.0 - 2.0 * (q.x * q.x + q.y * q.y)
        frame = message.header.frame_id.lstrip("/")
        if frame not in self._mounts:
            try:
                mount = self.transforms.mount(self._wheels.child_frame_id.lstrip("/"), frame)
            except TransformError:
                return 0.0, 0.0, 1.0
            x, y, z = mount.rotation()[2].tolist()
            self._mounts[frame] = x, y, z
        return self._mounts[frame]

    def _take_wheels(self) -> None:
        twist = self._wheels.twist.twist
        self._waiting = False
        self._predict_to(seconds(self._wheels.header.stamp))
        self._filter.wheels(twist.linear.x, twist.angular.z, twist.linear.y)

    def _predict_to(self, now: float) -> None:
        """Bring the filter up to a time [s]; what comes late counts as of now."""
        if self._stamp is not None:
            self._filter.predict(now - self._stamp)
        self._stamp = now if self._stamp is None else max(now, self._stamp)

    def _publish(self, estimate: OdometryEstimate) -> None:
        assert self._stamp is not None
        now, frame = self._stamp, self._wheels.header.frame_id
        child = self._wheels.child_frame_id
        if self.config.publish_tf:
            T = transform_msg(estimate.T_odom_base, frame, child, now)
            self._tf_out.publish(transforms_msg(T))
        self._odom_out.publish(odometry_msg(estimate, frame, child, now))
