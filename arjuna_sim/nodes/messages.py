"""Observations of the simulator as messages."""

from __future__ import annotations

import array
import math
from typing import Any

from geometry_msgs.msg import (
    Point,
    Pose,
    PoseWithCovariance,
    Quaternion,
    Transform,
    TransformStamped,
    Twist,
    TwistWithCovariance,
    Vector3,
)
from nav_msgs.msg import Odometry
from sensor_msgs.msg import Imu, JointState
from simulation_interfaces.msg import Bounds, EntityState

from arjuna_core.pose3 import Pose3
from arjuna_core.ros.convert import PLANAR, header, pose_msg
from arjuna_sim.devices.imu import ImuReading
from arjuna_sim.devices.odometry import OdometryEstimate
from arjuna_sim.model.entities import EntityMotion
from arjuna_sim.physics.robot_motion import JointStates, Truth

WORLD = "world"
_DIAGONAL = PLANAR[::4]
_FARTHEST = 10_000.0  # [m] beyond it single precision tears meshes apart


def transform3_msg(T: Pose3, parent: str, child: str, now: float) -> TransformStamped:
    """Return `T_parent_child` in space at a time [s] as a TransformStamped message."""
    (x, y, z), (qw, qx, qy, qz) = T.position, T.quaternion
    transform = Transform(
        translation=Vector3(x=x, y=y, z=z), rotation=Quaternion(x=qx, y=qy, z=qz, w=qw)
    )
    return TransformStamped(header=header(parent, now), child_frame_id=child, transform=transform)


def odometry_msg(estimate: OdometryEstimate, frame: str, child: str, now: float) -> Odometry:
    """Return dead reckoning at a time [s] as an Odometry message.

    Args:
        estimate: Pose and motion of the robot.
        frame: The frame of its pose.
        child: The robot's frame.
        now: [s].
    """
    linear = Vector3(x=estimate.v, y=estimate.side)
    message = Odometry(
        header=header(frame, now),
        child_frame_id=child,
        pose=PoseWithCovariance(pose=pose_msg(estimate.T_odom_base)),
        twist=TwistWithCovariance(twist=Twist(linear=linear, angular=Vector3(z=estimate.w))),
    )
    message.pose.covariance[PLANAR] = estimate.covariance.ravel()
    v_variance, w_variance = estimate.twist_variance
    side_variance = v_variance if estimate.side else 0.0
    message.twist.covariance[_DIAGONAL] = v_variance, side_variance, w_variance
    return message


def truth_msg(truth: Truth, child: str, now: float) -> Odometry:
    """Return the true pose and motion at a time [s] as an Odometry message, without errors."""
    message = Odometry(header=header(WORLD, now), child_frame_id=child)
    _set_truth(message.pose.pose, message.twist.twist, truth)
    return message


def entity_state(truth: Truth, now: float) -> EntityState:
    """Return the robot's true pose and motion at a time [s] as an EntityState message."""
    message = EntityState(header=header(WORLD, now))
    _set_truth(message.pose, message.twist, truth)
    return message


def _set_truth(pose: Pose, twist: Twist, truth: Truth) -> None:
    at, turn = pose.position, pose.orientation
    at.x, at.y, at.z = truth.pose.x, truth.pose.y, truth.z
    turn.w, turn.x, turn.y, turn.z = Pose3.from_rpy(
        (at.x, at.y, at.z), (truth.roll, truth.pitch, truth.pose.theta)
    ).quaternion
    twist.linear.x, twist.linear.y, twist.angular.z = truth.v, truth.side, truth.w


def motion_msg(motion: EntityMotion, now: float) -> EntityState:
    """Return an entity's pose and motion at a time [s] as an EntityState message."""
    message = EntityState(header=header(WORLD, now), pose=pose3_msg(motion.pose))
    message.twist = Twist(linear=_vector(motion.linear), angular=_vector(motion.angular))
    return message


def pose3_msg(pose: Pose3) -> Pose:
    """Return a pose of space as a Pose message."""
    w, x, y, z = pose.quaternion
    px, py, pz = pose.position
    return Pose(position=Point(x=px, y=py, z=pz), orientation=Quaternion(x=x, y=y, z=z, w=w))


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
    norm = math.sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z)
    if not math.isfinite(norm) or norm < 1e-6:
        raise ValueError(f"quaternion ({q.x}, {q.y}, {q.z}, {q.w}) is no rotation")
    return Pose3((p.x, p.y, p.z), (q.w / norm, q.x / norm, q.y / norm, q.z / norm))


def box_msg(low: Any, high: Any) -> Bounds:
    """Return the least and greatest corner of a box as a Bounds message, the upper one first."""
    return Bounds(type=Bounds.TYPE_BOX, points=[_vector(high), _vector(low)])


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
    w, x, y, z = reading.orientation.quaternion
    message = Imu(
        header=header(frame, now),
        orientation=Quaternion(x=x, y=y, z=z, w=w),
        angular_velocity=_vector(reading.angular_velocity.tolist()),
        linear_acceleration=_vector(reading.linear_acceleration.tolist()),
    )
    message.orientation_covariance[:8:4] = reading.tilt_variance
    # The gyro's sum drifts without bound: a client must not take it for a compass.
    message.orientation_covariance[8] = 0.1
    message.angular_velocity_covariance[::4] = reading.angular_variance
    message.linear_acceleration_covariance[::4] = reading.linear_variance
    return message


def _vector(values: Any) -> Vector3:
    x, y, z = map(float, values)
    return Vector3(x=x, y=y, z=z)
