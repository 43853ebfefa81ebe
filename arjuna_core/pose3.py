"""Rigid motions of space, as URDF and SDF write them: a position and a rotation."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from arjuna_core.arrays import Floats
from arjuna_core.se2 import SE2

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]


@dataclass(frozen=True, slots=True, init=False)
class Pose3:
    """A pose or transform of space; `T_a_c = T_a_b @ T_b_c`.

    Attributes:
        position: Translation `(x, y, z)` [m].
        quaternion: Rotation as a unit quaternion `(w, x, y, z)`, as MuJoCo orders it.
    """

    position: Vector
    quaternion: Quaternion

    def __init__(
        self, position: Vector = (0.0, 0.0, 0.0), quaternion: Quaternion = (1.0, 0.0, 0.0, 0.0)
    ) -> None:
        _set_position(self, position)  # as SE2 does
        _set_quaternion(self, quaternion)

    @staticmethod
    def from_rpy(xyz: tuple[float, ...], rpy: tuple[float, ...]) -> Pose3:
        """Build a pose from a position [m] and fixed-axis roll, pitch and yaw [rad]."""
        (cr, sr), (cp, sp), (cy, sy) = ((math.cos(a / 2), math.sin(a / 2)) for a in rpy)
        w = cr * cp * cy + sr * sp * sy
        x = sr * cp * cy - cr * sp * sy
        y = cr * sp * cy + sr * cp * sy
        z = cr * cp * sy - sr * sp * cy
        return Pose3((xyz[0], xyz[1], xyz[2]), (w, x, y, z))

    @staticmethod
    def from_se2(pose: SE2, z: float = 0.0) -> Pose3:
        """Build an upright pose from a planar one, at height `z` [m]."""
        return Pose3.from_rpy((pose.x, pose.y, z), (0.0, 0.0, pose.theta))

    def __matmul__(self, other: Pose3) -> Pose3:
        x, y, z = self.position
        if any(other.position):
            dx, dy, dz = _turned(self.quaternion, other.position)
            x, y, z = dx + x, dy + y, dz + z
        return Pose3(
            (float(x), float(y), float(z)), quaternion_product(self.quaternion, other.quaternion)
        )

    def inverse(self) -> Pose3:
        """Return the transform that undoes this one."""
        w, x, y, z = self.quaternion
        back = w, -x, -y, -z
        px, py, pz = _turned(back, self.position)
        return Pose3((float(-px), float(-py), float(-pz)), back)

    def interpolate(self, other: Pose3, ratio: float) -> Pose3:
        """Interpolate; ratio 0 is self, 1 is other.

        Positions go straight, rotations along the shorter arc (Shoemake, Slerp, 1985).
        """
        a, b = np.array(self.quaternion), np.array(other.quaternion)
        b = b if a @ b >= 0.0 else -b
        angle = math.atan2(float(np.linalg.norm(b - a)), float(np.linalg.norm(b + a))) * 2.0
        if angle > 1e-9:
            a, b = a * math.sin((1.0 - ratio) * angle), b * math.sin(ratio * angle)
            w, x, y, z = (a + b) / math.sin(angle)
        else:
            w, x, y, z = b
        p = np.array(self.position) * (1.0 - ratio) + np.array(other.position) * ratio
        return Pose3(tuple(p.tolist()), (float(w), float(x), float(y), float(z)))

    def apply(self, points: Floats) -> Floats:
        """Map points `(N, 3) float64` [m] from the right-hand frame into the left-hand one."""
        result: Floats = points @ self.rotation().T + np.array(self.position)
        return result

    def rotation(self) -> Floats:
        """Return the rotation matrix, `(3, 3) float64`."""
        return np.array(_matrix(*self.quaternion))

    def rpy(self) -> Vector:
        """Return fixed-axis roll, pitch and yaw [rad]."""
        return rpy_of(*self.quaternion)

    def planar(self) -> SE2:
        """Return the pose seen from above."""
        return SE2(self.position[0], self.position[1], self.rpy()[2])


_set_position, _set_quaternion = (vars(Pose3)[n].__set__ for n in ("position", "quaternion"))
ORIGIN = Pose3()


def _matrix(w: float, x: float, y: float, z: float) -> tuple[Vector, Vector, Vector]:
    """Return the rows of a unit quaternion's rotation matrix."""
    return (
        (1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
        (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
        (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
    )


def _turned(quaternion: Quaternion, vector: Vector) -> Vector:
    """Return a vector turned by a unit quaternion; of one, NumPy takes six times as long."""
    a, b, c = vector
    rows = _matrix(*quaternion)
    x, y, z = (row[0] * a + row[1] * b + row[2] * c for row in rows)
    return x, y, z


def rpy_of(w: float, x: float, y: float, z: float) -> Vector:
    """Return fixed-axis roll, pitch and yaw [rad] of a unit quaternion."""
    roll = math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    pitch = math.asin(max(-1.0, min(1.0, 2 * (w * y - z * x))))
    yaw = math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    return roll, pitch, yaw


def unit_quaternion(w: float, x: float, y: float, z: float) -> Quaternion:
    """Return a rotation's quaternion of any length as one of length 1.

    Raises:
        ValueError: The quaternion is zero or not finite.
    """
    norm = math.sqrt(w * w + x * x + y * y + z * z)
    if not math.isfinite(norm) or norm < 1e-6:
        raise ValueError(f"quaternion ({x}, {y}, {z}, {w}) is no rotation")
    return w / norm, x / norm, y / norm, z / norm


def quaternion_product(a: Quaternion, b: Quaternion) -> Quaternion:
    """Multiply two quaternions `(w, x, y, z)`."""
    return (
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
        a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
    )
