"""ekf_node, ukf_node: odometry/filtered and its transform, of any sensors."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any, ClassVar

import numpy as np
from geometry_msgs.msg import (
    AccelWithCovarianceStamped,
    PoseWithCovarianceStamped,
    Twist,
    TwistStamped,
    TwistWithCovarianceStamped,
)
from nav_msgs.msg import Odometry
from rclpy.qos import QoSProfile, ReliabilityPolicy
from robot_localization.srv import GetState, SetPose, ToggleFilterProcessing
from sensor_msgs.msg import Imu
from std_srvs.srv import Empty

from arjuna_core.arrays import Floats
from arjuna_core.pose3 import ORIGIN, Pose3
from arjuna_core.ros import qos
from arjuna_core.ros.convert import header, pose3_msg, seconds, transform3_msg
from arjuna_core.ros.node import ManagedNode
from arjuna_core.ros.silence import Silence, subscribe_watched
from arjuna_core.ros.tf import TransformPublisher, transforms_msg
from arjuna_sim.fusion.estimator import Estimator
from arjuna_sim.fusion.filters import ExtendedFilter, Filter, Measurement, UnscentedFilter
from arjuna_sim.fusion.kinematics import ACCELERATION, POSE, TWIST
from arjuna_sim.fusion.sensors import (
    Part,
    PoseInput,
    acceleration_measured,
    twist_measured,
    without_gravity,
)
from arjuna_sim.nodes.localization.config import FilterConfig, Sensor, UnscentedConfig, square
from arjuna_sim.nodes.messages import twist_msg
from arjuna_sim.nodes.mounted_frames import MountedFrames


@dataclass
class _Input:
    """A sensor and the uses of its parts."""

    sensor: Sensor
    pose: PoseInput | None
    twist: Part | None
    acceleration: Part | None
    last: float = -np.inf


class EkfFilterNode(ManagedNode):
    """Estimates pose, velocity and acceleration in space, as robot_localization's `ekf_node`."""

    Config: ClassVar[type[Any]] = FilterConfig
    DEFAULT_NAME = "ekf_filter_node"

    def configure(self) -> None:
        """Build the filter and create topics and services."""
        config: FilterConfig = self.config
        self._estimator = Estimator(
            self._new_filter,
            config.noise(),
            config.silence,
            config.history_length if config.smooth_lagged_data else 0.0,
            config.predict_to_current_time,
            config.control(),
        )
        self._on = not config.disabled_at_startup
        self._published = self._set_at = -np.inf
        self._mount = MountedFrames(self).mount
        self._tf_out = TransformPublisher(self, "/tf", qos.TF)
        self._odom_out = self.publisher(Odometry, config.odom_topic, qos.DEFAULT)
        self._acceleration_out = (
            self.publisher(AccelWithCovarianceStamped, "accel/filtered", qos.DEFAULT)
            if config.publish_acceleration
            else None
        )
        self._inputs = [self._input(sensor) for sensor in config.sensors()]
        if config.use_control:
            kind = TwistStamped if config.stamped_control else Twist
            self.subscribe(kind, "cmd_vel", self._on_command, qos.DEFAULT)
        self.subscribe(PoseWithCovarianceStamped, "set_pose", self._set_pose, qos.DEFAULT)
        self.serve(SetPose, "set_pose", self._on_set_pose)
        self.serve(ToggleFilterProcessing, "toggle", self._on_toggle)
        self.serve(Empty, "enable", self._on_enable)
        self.serve(Empty, "reset", self._on_reset)
        self.serve(GetState, "get_state", self._on_get_state)
        self.every(1.0 / config.frequency, self._update)

    def _new_filter(self) -> Filter:
        return ExtendedFilter(*self._first())

    def _first(self) -> tuple[Floats, Floats]:
        config = self.config
        return np.array(config.initial_state), square(config.initial_estimate_covariance)

    def _input(self, sensor: Sensor) -> _Input:
        """Subscribe to a sensor of which something is to be used."""
        types: dict[str, tuple[Any, Callable[[_Input, Any], None]]] = {
            "odom": (Odometry, self._on_odometry),
            "pose": (PoseWithCovarianceStamped, self._on_pose),
            "twist": (TwistWithCovarianceStamped, self._on_twist),
            "imu": (Imu, self._on_imu),
        }
        planar, options = self.config.two_d_mode, sensor.options
        what = ("pose", POSE), ("twist", TWIST), ("linear_acceleration", ACCELERATION)
        has = {"odom": what[:2], "pose": what[:1], "twist": what[1:2], "imu": what}[sensor.kind]
        parts = {name: sensor.part(name, states, planar) for name, states in has}
        pose = parts.get("pose")
        poses = None
        if pose is not None:
            poses = PoseInput(pose, options["differential"], options["relative"])
        made = _Input(sensor, poses, parts.get("twist"), parts.get("linear_acceleration"))
        if not any(parts.values()):
            self.get_logger().warning(
                f"{sensor.name} ({sensor.topic}) is not used: {sensor.name}_config has no true"
            )
            return made
        kind, take = types[sensor.kind]
        depth = QoSProfile(
            depth=max(1, sensor.queue_size), reliability=ReliabilityPolicy.BEST_EFFORT
        )
        silence = Silence(kind, f"{sensor.kind} message", depth, f"set {sensor.name}")
        subscribe_watched(self, sensor.topic, silence, partial(self._take, made, take))
        return made

    def _take(self, one: _Input, take: Callable[[_Input, Any], None], message: Any) -> None:
        stamp = seconds(message.header.stamp)
        if self._on and stamp >= one.last and stamp > self._set_at:
            one.last = stamp
            take(one, message)

    def _on_odometry(self, one: _Input, message: Any) -> None:
        child, pose = message.child_frame_id, pose_of(message.pose.pose)
        from_child = ORIGIN
        if one.pose and one.sensor.options["pose_use_child_frame"]:
            found = self._mount(child, self.config.base_link_frame)
            if found is None:
                return
            from_child = found
        self._add_pose(one, message.header, pose @ from_child, message.pose.covariance)
        self._add_twist(one, message.header, message.twist, child)

    def _on_pose(self, one: _Input, message: Any) -> None:
        pose = pose_of(message.pose.pose)
        self._add_pose(one, message.header, pose, message.pose.covariance)

    def _on_twist(self, one: _Input, message: Any) -> None:
        self._add_twist(one, message.header, message.twist, message.header.frame_id)

    def _add_pose(self, one: _Input, about: Any, pose: Pose3, covariance: Any) -> None:
        if one.pose is None:
            return
        T_world_frame: Pose3 | None = ORIGIN
        if not one.pose.differential:
            T_world_frame = self._mount(self.config.world, about.frame_id)
        if T_world_frame is not None:
            noise = np.reshape(covariance, (6, 6))
            self._add(one.pose.measured(seconds(about.stamp), pose, noise, T_world_frame))

    def _add_twist(self, one: _Input, about: Any, message: Any, frame: str) -> None:
        if one.twist is None:
            return
        if (mounted := self._mount(self.config.base_link_frame, frame)) is not None:
            self._twist(one.twist, about, _six(message.twist), message.covariance, mounted)

    def _twist(self, part: Part, about: Any, twist: Floats, covariance: Any, at: Pose3) -> None:
        noise, state = np.reshape(covariance, (6, 6)), self._estimator.filter.state
        self._add(twist_measured(part, seconds(about.stamp), twist, noise, at, state))

    def _on_imu(self, one: _Input, message: Any) -> None:
        """Take orientation, turn rates and acceleration, each unless its covariance starts -1."""
        mounted = self._mount(self.config.base_link_frame, message.header.frame_id)
        if mounted is None:
            return
        stamp, turns = seconds(message.header.stamp), message.orientation_covariance
        orientation = None
        if turns[0] != -1.0:
            orientation = Pose3(quaternion=unit(message.orientation))
        if one.pose is not None and orientation is not None:
            self._add(one.pose.of_imu(stamp, orientation, _lower(turns), mounted))
        rates, rate = message.angular_velocity_covariance, message.angular_velocity
        if one.twist is not None and rates[0] != -1.0:
            turning = np.array((0.0, 0.0, 0.0, rate.x, rate.y, rate.z))
            self._twist(one.twist, message.header, turning, _lower(rates), mounted)
        noise, felt = message.linear_acceleration_covariance, message.linear_acceleration
        if one.acceleration is not None and noise[0] != -1.0:
            values = np.array((felt.x, felt.y, felt.z))
            if one.sensor.options["remove_gravitational_acceleration"]:
                gravity = self.config.gravitational_acceleration
                state = self._estimator.filter.state
                values = without_gravity(values, gravity, orientation, mounted, state)
            square3 = np.reshape(noise, (3, 3))
            self._add(acceleration_measured(one.acceleration, stamp, values, square3, mounted))

    def _add(self, measured: Measurement | None) -> None:
        if measured is not None:
            self._estimator.add(measured)

    def _on_command(self, message: Any) -> None:
        stamped = self.config.stamped_control
        stamp = seconds(message.header.stamp) if stamped else self.now
        self._estimator.command(_six(message.twist if stamped else message), stamp)

    def _set_pose(self, message: Any) -> None:
        at = self._mount(self.config.world, message.header.frame_id)
        if at is None:
            return
        pose, stamp = at @ pose_of(message.pose.pose), seconds(message.header.stamp)
        turned = np.kron(np.eye(2), at.rotation())
        noise = turned @ np.reshape(message.pose.covariance, (6, 6)) @ turned.T
        for one in self._inputs:
            if one.pose is not None:
                one.pose.forget()
        self._set_at = stamp if stamp > 0.0 else self.now
        values = np.array((*pose.position, *pose.rpy()))
        self._estimator.set_pose(values, noise, self._set_at)

    def _on_set_pose(self, request: Any, response: Any) -> Any:
        self._set_pose(request.pose)
        return response

    def _on_toggle(self, request: Any, response: Any) -> Any:
        response.status = bool(request.on) != self._on
        if not request.on:
            self._reset()
        self._on = bool(request.on)
        return response

    def _on_enable(self, request: Any, response: Any) -> Any:
        self._on = True
        return response

    def _on_reset(self, request: Any, response: Any) -> Any:
        self._reset()
        return response

    def _on_get_state(self, request: Any, response: Any) -> Any:
        """Return the state of base_link_frame at a time, as robot_localization_listener_node."""
        own = ("", self.config.base_link_frame, self.config.output)
        if request.frame_id not in own:
            reason = f"frame_id is '{request.frame_id}'; valid: {self.config.base_link_frame}"
            self.guard.refused(self, "get_state", reason)
            return response
        state, covariance = self._estimator.at(seconds(request.time_stamp))
        response.state, response.covariance = state, covariance.ravel()
        return response

    def _reset(self) -> None:
        self._estimator.reset()
        self._published = self._set_at = -np.inf
        for one in self._inputs:
            one.last = -np.inf
            if one.pose is not None:
                one.pose.forget()

    def on_time_jump(self) -> None:
        """Forget everything, if so asked."""
        if self.config.reset_on_time_jump and self.configured:
            self._reset()

    def _update(self) -> None:
        if not self._on:
            return
        self._estimator.update(self.now)
        stamp = self._estimator.stamp
        again = stamp is not None and stamp <= self._published
        if stamp is None or (again and not self.config.permit_corrected_publication):
            return
        self._published = stamp
        self._publish(stamp)

    def _publish(self, stamp: float) -> None:
        config, state = self.config, self._estimator.filter.state
        covariance = self._estimator.filter.covariance
        pose = Pose3.from_rpy(tuple(state[:3].tolist()), tuple(state[3:6].tolist()))
        if config.publish_tf:
            self._publish_transform(pose, stamp + config.transform_time_offset)
        message = Odometry(header=header(config.world, stamp), child_frame_id=config.output)
        message.pose.pose = pose3_msg(pose)
        message.pose.covariance = covariance[POSE, POSE].ravel()
        message.twist.twist = twist_msg(state[TWIST])
        message.twist.covariance = covariance[TWIST, TWIST].ravel()
        self._odom_out.publish(message)
        if self._acceleration_out is not None:
            said = AccelWithCovarianceStamped(header=header(config.output, stamp))
            linear, noise = said.accel.accel.linear, np.zeros((6, 6))
            linear.x, linear.y, linear.z = state[ACCELERATION].tolist()
            noise[:3, :3] = covariance[ACCELERATION, ACCELERATION]
            said.accel.covariance = noise.ravel()
            self._acceleration_out.publish(said)

    def _publish_transform(self, pose: Pose3, stamp: float) -> None:
        """Publish odom to the robot, or map to odom by what is known of odom to the robot.

        Where the robot's frame has a parent already, as its description gives base_link's, odom
        becomes the parent of what carries both: a frame has one.
        """
        config, parent, child = self.config, self.config.world, self.config.output
        if parent == config.odom_frame:
            carrier = self.transforms.rigid_root(child)
            if carrier not in (parent, child):
                pose, child = pose @ self.transforms.mount(child, carrier), carrier
        else:
            T_odom_base = self._mount(config.odom_frame, child)
            if T_odom_base is None:
                return
            pose, child = pose @ T_odom_base.inverse(), config.odom_frame
        T = transform3_msg(pose, parent, child, stamp)
        self._tf_out.publish(transforms_msg(T))


class UkfFilterNode(EkfFilterNode):
    """The same by the unscented filter, as robot_localization's `ukf_node`."""

    Config = UnscentedConfig
    DEFAULT_NAME = "ukf_filter_node"

    def _new_filter(self) -> Filter:
        config = self.config
        return UnscentedFilter(*self._first(), config.alpha, config.kappa, config.beta)


def pose_of(message: Any) -> Pose3:
    """Return a Pose message as a pose of space."""
    p = message.position
    return Pose3((p.x, p.y, p.z), unit(message.orientation))


def unit(q: Any) -> tuple[float, float, float, float]:
    """Return a unit quaternion; one that is all 0, as nobody set it, stands for no turn."""
    length = float(np.linalg.norm((q.w, q.x, q.y, q.z)))
    if length == 0.0:
        return 1.0, 0.0, 0.0, 0.0
    return q.w / length, q.x / length, q.y / length, q.z / length


def _six(twist: Any) -> Floats:
    v, w = twist.linear, twist.angular
    return np.array((v.x, v.y, v.z, w.x, w.y, w.z))


def _lower(covariance: Any) -> Floats:
    """Return a covariance of three values as that of the last three of six."""
    whole = np.zeros((6, 6))
    whole[3:, 3:] = np.reshape(covariance, (3, 3))
    return whole
