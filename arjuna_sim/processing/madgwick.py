"""Madgwick's filter: orientation of turn rates, gravity and, if given, the earth's field.

Source: S. Madgwick, "An efficient orientation filter for inertial and inertial/magnetic sensor
arrays", 2010: equations 12, 20, 25, 33, 44 to 49; its parameters are imu_filter_madgwick's.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from arjuna_core.arrays import Floats
from arjuna_core.pose3 import Pose3

UP = {"enu": (0.0, 0.0, 1.0), "nwu": (0.0, 0.0, 1.0), "ned": (0.0, 0.0, -1.0)}
"""What an accelerometer at rest measures, in each world frame."""
_NORTH = {"enu": 1, "nwu": 0, "ned": 0}


@dataclass
class MadgwickFilter:
    """Orientation as a quaternion w, x, y, z that turns the sensor's vectors into the world's.

    Attributes:
        world: `enu`, `nwu` or `ned`.
        gain: How fast gravity and field correct it [rad/s].
        zeta: How fast they correct the gyro's bias [rad/s^2].
    """

    world: str = "enu"
    gain: float = 0.1
    zeta: float = 0.0
    quaternion: Floats = field(default_factory=lambda: np.array((1.0, 0.0, 0.0, 0.0)))
    bias: Floats = field(default_factory=lambda: np.zeros(3))

    def start(self, acceleration: Floats, field_: Floats | None = None) -> None:
        """Take the orientation that an acceleration at rest and a field stand for."""
        self.quaternion = quaternion_of(orientation(acceleration, field_, self.world))

    def update(self, dt: float, rates: Floats, acceleration: Floats, field_: Floats | None) -> None:
        """Take a reading after a time [s]: turn rates [rad/s], acceleration, field if there is one.

        An acceleration of 0 corrects nothing, as in free fall.
        """
        q, gradient = self.quaternion, np.zeros(4)
        if (size := np.linalg.norm(acceleration)) > 0.0:
            gradient += _gradient(q, np.array(UP[self.world]), acceleration / size)
            if field_ is not None and (strength := np.linalg.norm(field_)) > 0.0:
                measured = field_ / strength
                gradient += _gradient(q, self._field_direction(measured), measured)
            if (steepness := np.linalg.norm(gradient)) > 0.0:
                gradient /= steepness
        if self.zeta > 0.0:
            error = 2.0 * product(q * (1.0, -1.0, -1.0, -1.0), gradient)[1:]
            self.bias = self.bias + error * (dt * self.zeta)
        turning = np.concatenate(((0.0,), rates - self.bias))
        q = q + (0.5 * product(q, turning) - self.gain * gradient) * dt
        self.quaternion = q / np.linalg.norm(q)

    def _field_direction(self, measured: Floats) -> Floats:
        """Return the field in the world with its horizontal part due north."""
        seen = rotation(self.quaternion) @ measured
        direction = np.zeros(3)
        direction[_NORTH[self.world]] = np.hypot(seen[0], seen[1])
        direction[2] = seen[2]
        return direction


def _gradient(q: Floats, direction: Floats, measured: Floats) -> Floats:
    """Return the gradient by q of half the squared error between a direction and its reading."""
    w, x, y, z = q
    a, b, c = direction
    by_w = b * z - c * y, c * x - a * z, a * y - b * x
    by_x = b * y + c * z, a * y - 2.0 * b * x + c * w, a * z - b * w - 2.0 * c * x
    by_y = b * x - c * w - 2.0 * a * y, a * x + c * z, a * w + b * z - 2.0 * c * y
    by_z = b * w + c * x - 2.0 * a * z, c * y - a * w - 2.0 * b * z, a * x + b * y
    slope = 2.0 * np.array((by_w, by_x, by_y, by_z))
    gradient: Floats = slope @ (rotation(q).T @ direction - measured)
    return gradient


def rotation(q: Floats) -> Floats:
    """Return the rotation matrix of a unit quaternion w, x, y, z."""
    w, x, y, z = q.tolist()
    return Pose3(quaternion=(w, x, y, z)).rotation()


def product(p: Floats, q: Floats) -> Floats:
    """Return the product of two quaternions."""
    vector = p[0] * q[1:] + q[0] * p[1:] + np.cross(p[1:], q[1:])
    return np.concatenate(((p[0] * q[0] - p[1:] @ q[1:],), vector))


def orientation(acceleration: Floats, field_: Floats | None, world: str) -> Floats:
    """Return the rotation into the world of an acceleration at rest and a field, `(3, 3)`.

    Without a field the sensor's x axis has no east, or north, component across.
    """
    up = acceleration / np.linalg.norm(acceleration)
    if field_ is None:
        axis = np.eye(3)[0 if abs(up[0]) < 0.99 else 1]
        ahead = axis - (axis @ up) * up
        ahead /= np.linalg.norm(ahead)
        left = np.cross(up, ahead)
        rows = (ahead, -left, -up) if world == "ned" else (ahead, left, up)
        return np.array(rows)
    east = np.cross(field_, up)
    east /= np.linalg.norm(east)
    north = np.cross(up, east)
    return np.array(
        {"enu": (east, north, up), "nwu": (north, -east, up), "ned": (north, east, -up)}[world]
    )


def quaternion_of(matrix: Floats) -> Floats:
    """Return the unit quaternion of a rotation matrix, its w not negative."""
    from scipy.spatial.transform import Rotation

    x, y, z, w = Rotation.from_matrix(matrix).as_quat()
    found = np.array((w, x, y, z))
    return -found if w < 0.0 else found
