"""What the simulator observes, as messages."""

from __future__ import annotations

import array
from typing import Any

import numpy as np
from geometry_msgs.msg import Quaternion, Transform, TransformStamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import Imu, JointState
from simulation_interfaces.msg import EntityState

from arjuna_core.ros.convert import header, planar_covariance, pose_msg
from arjuna_sim.imu import ImuReading
from arjuna_sim.observation import JointStates, Truth
from arjuna_sim.odometry import OdometryEstimate
from arjuna_sim.pose3 import Pose3

WORLD = "world"
# The gyro's sum drifts without bound; a client must not take it for a compass.
_YAW_VARIANCE = 0.1


def transform3_msg(T: Pose3, parent: str, child: str, now: float) -> TransformStamped:
    """Return `T_parent_child` in space at a time [s] as a TransformStamped message."""
    w, x, y, z = T.quaternion
    transform = Transform(rotation=Quaternion(x=x, y=y, z=z, w=w))
    transform.translation.x, transform.translation.y, transform.translation.z = T.position
    return TransformStamped(header=header(parent, now), child_frame_id=child, transform=transform)


def odometry_msg(estimate: OdometryEstimate, frame: str, child: str, now: float) -> Odometry:
    """Return dead reckoning at a time [s] as an Odometry message."""
    message = Odometry(header=header(frame, now), child_frame_id=child)
    message.pose.pose = pose_msg(estimate.T_odom_base)
    message.pose.covariance = planar_covariance(estimate.covariance)
    message.twist.twist.linear.x = estimate.v
    message.twist.twist.angular.z = estimate.w
    v_variance, w_variance = estimate.twist_variance
    message.twist.covariance = planar_covariance(np.diag([v_variance, 0.0, w_variance]))
    return message


def truth_msg(truth: Truth, child: str, now: float) -> Odometry:
    """Return the true pose and motion at a time [s] as an Odometry message, without errors."""
    message = Odometry(header=header(WORLD, now), child_frame_id=child)
    state = entity_state(truth, now)
    message.pose.pose, message.twist.twist = state.pose, state.twist
    return message


def entity_state(truth: Truth, now: float) -> EntityState:
    """Return the true pose and motion at a time [s] as an EntityState message."""
    message = EntityState(header=header(WORLD, now))
    w, x, y, z = Pose3.from_rpy(
        (0.0, 0.0, 0.0), (truth.roll, truth.pitch, truth.pose.theta)
    ).quaternion
    message.pose.position.x, message.pose.position.y = truth.pose.x, truth.pose.y
    message.pose.position.z = truth.z
    message.pose.orientation = Quaternion(x=x, y=y, z=z, w=w)
    message.twist.linear.x, message.twist.angular.z = truth.v, truth.w
    return message


def joint_state_msg(joints: JointStates, now: float) -> JointState:
    """Return joint positions and velocities at a time [s] as a JointState message."""
    return JointState(
        header=header("", now),
        name=list(joints.names),
        position=array.array("d", joints.positions.tobytes()),
        velocity=array.array("d", joints.velocities.tobytes()),
    )


def imu_msg(reading: ImuReading, frame: str, now: float) -> Imu:
    """Return an IMU's reading at a time [s] as an Imu message."""
    message = Imu(header=header(frame, now))
    w, x, y, z = Pose3.from_rpy((0.0, 0.0, 0.0), reading.rpy).quaternion
    message.orientation = Quaternion(x=x, y=y, z=z, w=w)
    _set(message.angular_velocity, reading.angular_velocity)
    _set(message.linear_acceleration, reading.linear_acceleration)
    tilt = reading.tilt_variance
    message.orientation_covariance = np.diag([tilt, tilt, _YAW_VARIANCE]).ravel()
    message.angular_velocity_covariance = np.eye(3).ravel() * reading.angular_variance
    message.linear_acceleration_covariance = np.eye(3).ravel() * reading.linear_variance
    return message


def _set(vector: Any, values: Any) -> None:
    vector.x, vector.y, vector.z = (float(value) for value in values)
