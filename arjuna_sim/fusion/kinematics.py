"""The 15 states of a body in space, and its motion with constant acceleration."""

from __future__ import annotations

import math

import numpy as np

from arjuna_core.arrays import Floats
from arjuna_core.pose3 import Pose3

SIZE = 15
POSE, TWIST, ACCELERATION = slice(0, 6), slice(6, 12), slice(12, 15)
"""Position and roll, pitch, yaw in the world; velocity and turn rates, acceleration in the body."""
ANGLES = slice(3, 6)
OUT_OF_PLANE = (2, 3, 4, 8, 9, 10, 14)
"""The states that are 0 of a robot in the plane: z, roll and pitch, and what they change by."""


def wrapped(angles: Floats) -> Floats:
    """Return angles within [-pi, pi)."""
    result: Floats = (angles + math.pi) % (2.0 * math.pi) - math.pi
    return result


def rotation(roll: float, pitch: float, yaw: float) -> Floats:
    """Return the matrix of fixed-axis angles [rad], `(3, 3) float64`, body to world."""
    return Pose3.from_rpy((0.0, 0.0, 0.0), (roll, pitch, yaw)).rotation()


def transition(state: Floats, dt: float) -> Floats:
    """Return the matrix that brings a state forward by a time [s], `(15, 15) float64`.

    Source: Moore and Stouch, A generalized extended Kalman filter implementation for ROS, 2014.
    """
    roll, pitch, yaw = state[ANGLES].tolist()
    sr, cr, cp, tp = math.sin(roll), math.cos(roll), math.cos(pitch), math.tan(pitch)
    turned = rotation(roll, pitch, yaw)
    matrix = np.eye(SIZE)
    matrix[0:3, 6:9], matrix[0:3, 12:15] = turned * dt, turned * (0.5 * dt * dt)
    matrix[3:6, 9:12] = _euler_rates(sr, cr, cp, tp) * dt
    matrix[6:9, 12:15] = np.eye(3) * dt
    return matrix


def _euler_rates(sr: float, cr: float, cp: float, tp: float) -> Floats:
    """Return what turns rates of the body into those of roll, pitch and yaw."""
    return np.array([[1.0, sr * tp, cr * tp], [0.0, cr, -sr], [0.0, sr / cp, cr / cp]])


def jacobian(state: Floats, dt: float, matrix: Floats) -> Floats:
    """Return the derivative of `transition(state, dt) @ state`, `(15, 15) float64`.

    Args:
        matrix: That transition, whose dependence on the angles is added.
    """
    roll, pitch, yaw = state[ANGLES].tolist()
    (sr, cr), (sp, cp), (sy, cy) = ((math.sin(a), math.cos(a)) for a in (roll, pitch, yaw))
    tp = sp / cp
    path = state[6:9] * dt + state[12:15] * (0.5 * dt * dt)
    turned = matrix[0:3, 6:9] / dt
    of_roll = np.stack((np.zeros(3), turned[:, 2], -turned[:, 1]), axis=1)
    of_pitch = np.array(
        [
            [-cy * sp, cy * cp * sr, cy * cp * cr],
            [-sy * sp, sy * cp * sr, sy * cp * cr],
            [-cp, -sp * sr, -sp * cr],
        ]
    )
    of_yaw = np.stack((-turned[1], turned[0], np.zeros(3)))
    result: Floats = matrix.copy()
    result[0:3, 3], result[0:3, 4], result[0:3, 5] = of_roll @ path, of_pitch @ path, of_yaw @ path
    _, q, r = (state[9:12] * dt).tolist()
    result[3, 3] += (cr * q - sr * r) * tp
    result[4, 3] -= sr * q + cr * r
    result[5, 3] += (cr * q - sr * r) / cp
    result[3, 4] += (sr * q + cr * r) / (cp * cp)
    result[5, 4] += (sr * q + cr * r) * tp / cp
    return result
