"""Observations of the simulator as messages."""

from __future__ import annotations

import array
import math
from typing import Any

from geometry_msgs.msg import Pose, Twist, Vector3
from nav_msgs.msg import Odometry
from sensor_msgs.msg import Imu, JointState
from simulation_interfaces.msg import Bounds, EntityState

from arjuna_core.pose3 import Pose3, unit_quaternion
from arjuna_core.ros.convert import PLANAR, header, pose3_msg, pose_msg
from arjuna_core.ros.messages import maker
from arjuna_sim.devices.imu import ImuReading
from arjuna_sim.devices.odometry import OdometryEstimate
from arjuna_sim.model.entities import EntityMotion
from arjuna_sim.physics.robot_motion import JointStates, Truth

WORLD = "world"
_FARTHEST = 10_000.0  # [m] beyond it single precision tears meshes apart
_SPACE, _TURN = ("x", "y", "z"), ("x", "y", "z", "w")
_odometry = maker(
    Odometry,
    *("header", "child_frame_id", "pose.pose"),
    *("twist.twist.linear.x", "twist.twist.linear.y", "twist.twist.angular.z"),
)
_joints = maker(JointState, "header", "name", "position", "velocity")
_imu = maker(
    Imu,
    *("header", *(f"orientation.{i}" for i in _TURN)),
    *(f"{name}.{i}" for name in ("angular_velocity", "linear_acceleration") for i in _SPACE),
)


def odometry_msg(estimate: OdometryEstimate, frame: str, child: str, now: float) -> Odometry:
    """Return dead reckoning at a time [s] as an Odometry message."""
    motion = estimate.v, estimate.side, estimate.w
    message: Odometry = _odometry(
        header(frame, now), child, pose_msg(estimate.T_odom_base), *motion
    )
    message.pose.covariance[PLANAR] = estimate.covariance.ravel()
    v_variance, w_variance = estimate.twist_variance
    twist = message.twist.covariance
    twist[0], twist[35] = v_variance, w_variance
    if estimate.side:
        twist[7] = v_variance
    return message


def truth_msg(truth: Truth, child: str, now: float) -> Odometry:
    """Return the true pose and motion at a time [s] as an Odometry message, without errors."""
    pose = pose3_msg(truth.pose3)
    message: Odometry = _odometry(header(WORLD, now), child, pose, truth.v, truth.side, truth.w)
    return message


def motion_msg(motion: EntityMotion, now: float) -> EntityState:
    """Return an entity's pose and motion at a time [s] as an EntityState message."""
    message = EntityState(header=header(WORLD, now), pose=pose3_msg(motion.pose))
    message.twist = twist_msg((*motion.linear, *motion.angular))
    return message


def pose3_from_msg(message: Pose) -> Pose3:
    """Return a Pose message as a pose of space; its quaternion need not be normalised.

    Raises:
        ValueError: A value is not finite or too far away, or the quaternion is no rotation.
    """
    p, q = message.position, message.orientation
    if not all(math.isfinite(value) for value in (p.x, p.y, p.z)):
        raise ValueError(f"position ({p.x}, {p.y}, {p.z}) is not finite")
    if max(abs(p.x), abs(p.y), abs(p.z)) > _FARTHEST:
        raise ValueError(f"position ({p.x}, {p.y}, {p.z}) is farther than {_FARTHEST:g} m")
    return Pose3((p.x, p.y, p.z), unit_quaternion(q.w, q.x, q.y, q.z))


def twist_msg(values: Any) -> Twist:
    """Return a velocity and a turn rate of space `(6,)` as a Twist message."""
    return Twist(linear=_vector(values[:3]), angular=_vector(values[3:]))


def box_msg(low: Any, high: Any) -> Bounds:
    """Return the least and greatest corner of a box as a Bounds message, the upper one first."""
    return Bounds(type=Bounds.TYPE_BOX, points=[_vector(high), _vector(low)])


def joint_state_msg(joints: JointStates, now: float) -> JointState:
    """Return joint positions and velocities at a time [s] as a JointState message."""
    positions, velocities = (
        array.array("d", values.tobytes()) for values in (joints.positions, joints.velocities)
    )
    return _joints(header("", now), list(joints.names), positions, velocities)


def imu_msg(reading: ImuReading, frame: str, now: float) -> Imu:
    """Return an IMU's reading at a time [s] as an Imu message."""
    w, *turn = reading.orientation.quaternion
    vectors = *reading.angular_velocity.tolist(), *reading.linear_acceleration.tolist()
    message: Imu = _imu(header(frame, now), *turn, w, *vectors)
    message.orientation_covariance[:8:4] = reading.tilt_variance
    # The gyro's sum drifts without bound: a client must not take it for a compass.
    message.orientation_covariance[8] = 0.1
    message.angular_velocity_covariance[::4] = reading.angular_variance
    message.linear_acceleration_covariance[::4] = reading.linear_variance
    return message


def _vector(values: Any) -> Vector3:
    x, y, z = map(float, values)
    return Vector3(x=x, y=y, z=z)
