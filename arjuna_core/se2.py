"""Rigid motions of the plane, SE(2): poses, their composition and their logarithm."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import overload

import numpy as np

from arjuna_core.arrays import Floats

_SMALL_ANGLE = 1e-9


@overload
def wrap(angle: float) -> float: ...
@overload
def wrap(angle: Floats) -> Floats: ...
def wrap(angle: float | Floats) -> float | Floats:
    """Wrap an angle [rad], scalar or array, to [-pi, pi)."""
    return (angle + math.pi) % (2.0 * math.pi) - math.pi


@dataclass(frozen=True, slots=True, init=False)
class SE2:
    """A pose or transform of the plane.

    `T_a_b` maps coordinates in frame b into frame a; `T_a_c = T_a_b @ T_b_c`.

    Attributes:
        x: Translation [m].
        y: Translation [m].
        theta: Rotation [rad], not wrapped by the constructor; `heading` reads the same.
    """

    x: float
    y: float
    theta: float

    def __init__(self, x: float = 0.0, y: float = 0.0, theta: float = 0.0) -> None:
        # A frozen dataclass's own takes twice as long; thirty are made in a tick.
        _set_x(self, x)
        _set_y(self, y)
        _set_theta(self, theta)

    @property
    def heading(self) -> float:
        """The heading of a robot at this pose [rad]."""
        return self.theta

    def __matmul__(self, other: SE2) -> SE2:
        """Compose two transforms; the angle of the result is wrapped to [-pi, pi)."""
        c, s = math.cos(self.theta), math.sin(self.theta)
        return SE2(
            self.x + c * other.x - s * other.y,
            self.y + s * other.x + c * other.y,
            wrap(self.theta + other.theta),
        )

    def inverse(self) -> SE2:
        """Return the transform that undoes this one."""
        c, s = math.cos(self.theta), math.sin(self.theta)
        return SE2(-c * self.x - s * self.y, s * self.x - c * self.y, wrap(-self.theta))

    def apply(self, points: Floats) -> Floats:
        """Map points `(N, 2) float64` [m] from the right-hand frame into the left-hand one."""
        c, s = math.cos(self.theta), math.sin(self.theta)
        result: Floats = points @ np.array([[c, s], [-s, c]])
        result += (self.x, self.y)
        return result

    def distance(self, other: SE2) -> float:
        """Return the distance between the two origins [m]."""
        return math.hypot(other.x - self.x, other.y - self.y)

    def array(self) -> Floats:
        """Return `(x, y, theta)` as a `(3,) float64` array [m, m, rad]."""
        return np.array([self.x, self.y, self.theta])

    def matrix(self) -> Floats:
        """Return the homogeneous matrix, `(3, 3) float64`."""
        c, s = math.cos(self.theta), math.sin(self.theta)
        return np.array([[c, -s, self.x], [s, c, self.y], [0.0, 0.0, 1.0]])

    @staticmethod
    def from_array(values: Floats) -> SE2:
        """Build a pose from `(3,)` values `x, y, theta` [m, m, rad]."""
        return SE2(float(values[0]), float(values[1]), float(values[2]))

    @staticmethod
    def exp(tangent: Floats | tuple[float, float, float]) -> SE2:
        """Exponential map of a `(3,)` twist `vx, vy, omega` over unit time.

        Source: Sola et al., A micro Lie theory, 2018, appendix C.
        """
        vx, vy, w = map(float, tangent)
        if abs(w) < _SMALL_ANGLE:
            return SE2(vx, vy, w)
        a, b = math.sin(w) / w, (1.0 - math.cos(w)) / w
        return SE2(a * vx - b * vy, b * vx + a * vy, wrap(w))

    def log(self) -> Floats:
        """Logarithm: the `(3,) float64` twist whose `exp` is this transform."""
        w = wrap(self.theta)
        if abs(w) < _SMALL_ANGLE:
            return np.array([self.x, self.y, w])
        a, b = math.sin(w) / w, (1.0 - math.cos(w)) / w
        scale = 1.0 / (a * a + b * b)
        return np.array([scale * (a * self.x + b * self.y), scale * (a * self.y - b * self.x), w])

    def interpolate(self, other: SE2, ratio: float) -> SE2:
        """Interpolate along the straight line and the shorter turn; ratio 0 is self, 1 is other."""
        return SE2(
            self.x + ratio * (other.x - self.x),
            self.y + ratio * (other.y - self.y),
            wrap(self.theta + ratio * wrap(other.theta - self.theta)),
        )


_set_x, _set_y, _set_theta = (vars(SE2)[name].__set__ for name in ("x", "y", "theta"))
IDENTITY = SE2()


def yaw_of(x: float, y: float, z: float, w: float) -> float:
    """Return the rotation about z [rad] of a quaternion, which need not be normalised.

    Raises:
        ValueError: The quaternion is zero or not finite.
    """
    norm = x * x + y * y + z * z + w * w
    if not math.isfinite(norm) or norm < 1e-12:
        raise ValueError(f"quaternion ({x}, {y}, {z}, {w}) is no rotation")
    return math.atan2(2.0 * (w * z + x * y), norm - 2.0 * (y * y + z * z))


def is_upside_down(x: float, y: float, z: float, w: float) -> bool:
    """Return whether a rotation, as a quaternion, points the z axis down."""
    return x * x + y * y > z * z + w * w
