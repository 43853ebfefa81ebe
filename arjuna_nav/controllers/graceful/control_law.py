"""The graceful control law: a smooth curve that ends at a pose with its heading.

Source: Park and Kuipers, A smooth control law for graceful motion of differential wheeled mobile
    robots in 2D environment, ICRA 2011; limits as in nav2_graceful_controller.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from arjuna_core.arrays import Floats


@njit(cache=True)
def approach(
    target: Floats, law: Floats, limits: Floats, spacing: float
) -> tuple[Floats, float, float]:
    """Return the poses of the trajectory to a target seen from the robot, and the first velocity.

    Args:
        target: `(3,) float64` [m, m, rad].
        law: As `steer` takes it.
        limits: As `steer` takes them.
        spacing: Distance between two poses; it ends within that and 1 cm of the target [m].

    Returns:
        Poses `(N, 3) float64`, the robot's first; forward speed [m/s]; yaw rate [rad/s].
    """
    poses = np.zeros((200, 3))
    first_v = first_w = 0.0
    count = 1
    for k in range(1, len(poses)):
        x, y, theta = poses[k - 1]
        dx, dy, c, s = target[0] - x, target[1] - y, math.cos(theta), math.sin(theta)
        v, w = steer(c * dx + s * dy, c * dy - s * dx, target[2] - theta, law, limits)
        if k == 1:
            first_v, first_w = v, w
        dt = spacing / max(v, 1e-3)
        poses[k, 0] = x + v * dt * math.cos(theta + 0.5 * w * dt)
        poses[k, 1] = y + v * dt * math.sin(theta + 0.5 * w * dt)
        poses[k, 2] = theta + w * dt
        count = k + 1
        if math.hypot(target[0] - poses[k, 0], target[1] - poses[k, 1]) < spacing + 0.01:
            break
    return poses[:count], first_v, first_w


@njit(cache=True)
def steer(x: float, y: float, theta: float, law: Floats, limits: Floats) -> tuple[float, float]:
    """Return the velocity to a target seen from the robot.

    Args:
        x: Ahead [m].
        y: To the left [m].
        theta: The target's heading [rad].
        law: `(4,) float64`, k_phi, k_delta, beta and lambda.
        limits: `(4,) float64`, least and greatest speed [m/s], the distance from the target within
            which the greatest is less [m], greatest yaw rate [rad/s].

    Returns:
        Forward speed [m/s] and yaw rate [rad/s].
    """
    k_phi, k_delta, beta, power = law
    v_min, v_max, slowing, w_max = limits
    r, sight = max(math.hypot(x, y), 1e-3), math.atan2(y, x)
    phi, delta = _wrapped(theta - sight), _wrapped(-sight)
    bend = (1.0 + k_phi / (1.0 + (k_phi * phi) ** 2)) * math.sin(delta)
    curvature = -(k_delta * (delta - math.atan(-k_phi * phi)) + bend) / r
    v = min(v_max / (1.0 + beta * abs(curvature) ** power), v_max * r / slowing)
    v = min(max(v, v_min), v_max)
    w = min(max(v * curvature, -w_max), w_max)
    return (min(v, abs(w / curvature)) if abs(curvature) > 1e-6 else v), w


@njit(cache=True)
def _wrapped(angle: float) -> float:
    return (angle + math.pi) % (2.0 * math.pi) - math.pi
