"""Rays of a planar lidar's sweep; apart, since a client that only hears scans needs no Numba."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from arjuna_core.arrays import Floats


@njit(cache=True)
def rays_of_sweep(
    count: int, angle_min: float, increment: float, x: float, y: float, theta: float, twist: Floats
) -> Floats:
    """Return start and bearing of each beam of a sensor at x, y, theta of a base that moves."""
    rays = np.empty((count, 3))
    vx, vy, yaw = twist
    for i in range(count):
        share = i / max(count - 1, 1)
        heading = share * yaw
        c, s = math.cos(heading), math.sin(heading)
        a = s / yaw if yaw != 0.0 else share
        b = (1.0 - c) / yaw if yaw != 0.0 else 0.0
        rays[i, 0] = a * vx - b * vy + c * x - s * y
        rays[i, 1] = b * vx + a * vy + s * x + c * y
        rays[i, 2] = heading + theta + angle_min + increment * i
    return rays
