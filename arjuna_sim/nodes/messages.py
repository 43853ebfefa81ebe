"""What the simulator observes, as messages."""

from __future__ import annotations

import array
import math
from typing import Any

from geometry_msgs.msg import Point, Pose, Quaternion, TransformStamped, Twist, Vector3
from nav_msgs.msg import Odometry
from sensor_msgs.msg import Imu, JointState
from simulation_interfaces.msg import Bounds, EntityState

from arjuna_core.pose3 import Pose3
from arjuna_core.ros.convert import PLANAR, between, header, set_header, set_yaw
from arjuna_sim.devices.imu import ImuReading
from arjuna_sim.devices.odometry import OdometryEstimate
from arjuna_sim.model.entities import EntityMotion
from arjuna_sim.physics.robot_motion import JointStates, Truth

WORLD = "world"
# The gyro's sum drifts without bound; a client must not take it for a compass.
_YAW_VARIANCE = 0.1
_DIAGONAL = PLANAR[::4]
_FARTHEST = 10_000.0  # [m] beyond it single precision tears meshes apart


def transform3_msg(
    T: Pose3, parent: str, child: str, now: float, into: TransformStamped | None = None
) -> TransformStamped:
    """Return `T_parent_child` in space at a time [s] as a TransformStamped message.

    Args:
        T: The transform.
        parent: Frame mapped into.
        child: Frame mapped from.
        now: [s].
        into: One that an earlier call returned, to be used again.
    """
    message = between(parent, child, now, into)
    at, turn = message.transform.translation, message.transform.rotation
    at.x, at.y, at.z = T.position
    turn.w, turn.x, turn.y, turn.z = T.quaternion
    return message


def odometry_msg(
    estimate: OdometryEstimate, frame: str, child: str, now: float, into: Odometry | None = None
) -> Odometry:
    """Return dead reckoning at a time [s] as an Odometry message.

    Args:
        estimate: Where the robot is and how it moves.
        frame: In which it is.
        child: The robot's frame.
        now: [s].
        into: One that an earlier call returned, to be used again.
    """
    message = into or Odometry()
    set_header(message.header, frame, now)
    message.child_frame_id = child
    pose, twist, T = message.pose.pose, message.twist.twist, estimate.T_odom_base
    pose.position.x, pose.position.y = T.x, T.y
    set_yaw(pose.orientation, T.theta)
    message.pose.covariance[PLANAR] = estimate.covariance.ravel()
    twist.linear.x, twist.linear.y, twist.angular.z = estimate.v, estimate.side, estimate.w
    v_variance, w_variance = estimate.twist_variance
    side_variance = v_variance if estimate.side else 0.0
    message.twist.covariance[_DIAGONAL] = v_variance, side_variance, w_variance
    return message


def truth_msg(truth: Truth, child: str, now: float, into: Odometry | None = None) -> Odometry:
    """Return the true pose and motion at a time [s] as an Odometry message, without errors.

    Args:
        truth: Where the robot is and how it moves.
        child: Its frame.
        now: [s].
        into: One that an earlier call returned, to be used again.
    """
    message = into or Odometry()
    set_header(message.header, WORLD, now)
    message.child_frame_id = child
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
    _set(message.twist.linear, motion.linear)
    _set(message.twist.angular, motion.angular)
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
    points = [Vector3(), Vector3()]
    _set(points[0], high)
    _set(points[1], low)
    return Bounds(type=Bounds.TYPE_BOX, points=points)


def joint_state_msg(joints: JointStates, now: float, into: JointState | None = None) -> JointState:
    """Return joint positions and velocities at a time [s] as a JointState message.

    Args:
        joints: Their names, positions and velocities.
        now: [s].
        into: One that an earlier call for the same joints returned, to be used again.
    """
    message = into or JointState(name=list(joints.names))
    set_header(message.header, "", now)
    message.position = array.array("d", joints.positions.tobytes())
    message.velocity = array.array("d", joints.velocities.tobytes())
    return message


def imu_msg(reading: ImuReading, frame: str, now: float, into: Imu | None = None) -> Imu:
    """Return an IMU's reading at a time [s] as an Imu message.

    Args:
        reading: What it says.
        frame: Its frame.
        now: [s].
        into: One that an earlier call returned, to be used again.
    """
    message = into or Imu()
    set_header(message.header, frame, now)
    turn = message.orientation
    turn.w, turn.x, turn.y, turn.z = reading.orientation.quaternion
    _set(message.angular_velocity, reading.angular_velocity.tolist())
    _set(message.linear_acceleration, reading.linear_acceleration.tolist())
    message.orientation_covariance[:8:4] = reading.tilt_variance
    message.orientation_covariance[8] = _YAW_VARIANCE
    message.angular_velocity_covariance[::4] = reading.angular_variance
    message.linear_acceleration_covariance[::4] = reading.linear_variance
    return message


def _set(vector: Any, values: Any) -> None:
    vector.x, vector.y, vector.z = map(float, values)
