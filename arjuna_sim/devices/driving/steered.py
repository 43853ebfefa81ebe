"""Bases whose wheels are steered: about one centre, or each on its own."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from arjuna_core.arrays import Floats
from arjuna_core.twist import Velocity
from arjuna_sim.devices.drive import Base
from arjuna_sim.model.settings import DriveSettings
from arjuna_sim.model.urdf import Urdf
from arjuna_sim.model.wheels import axis, center, radius_of, rolling_direction, steered_by

_STANDS = 1e-3  # a base so slow keeps its steering where it is [m/s]


@dataclass(frozen=True)
class SteeredWheel:
    """A wheel that rolls along a line, which a joint may turn.

    Attributes:
        position: Its centre at angle 0, `(2,) float64` [m].
        direction: In which positive turning rolls it at angle 0, `(2,) float64`.
        radius: [m].
        by: Index of the joint that steers it, -1 for none.
        pivot: What it turns about, `(2,) float64` [m].
    """

    position: Floats
    direction: Floats
    radius: float
    by: int
    pivot: Floats

    def turned(self, angle: float) -> tuple[Floats, Floats]:
        """Return position and direction, steered to the left by an angle [rad]."""
        c, s = math.cos(angle), math.sin(angle)
        R = np.array([[c, -s], [s, c]])
        return self.pivot + R @ (self.position - self.pivot), R @ self.direction


class SteeredBase(Base):
    """Wheels that all roll about one centre, which lies on the line of those that do not steer.

    Args:
        others: The wheels that nothing drives.
        pivots: What the steering joints turn about, `(S, 2) float64` [m].
        signs: +1 for a steering joint whose positive angle steers to the left, else -1, `(S,)`.
        limit: How far the wheels are steered at most [rad].

    Source: Siegwart and Nourbakhsh, Introduction to Autonomous Mobile Robots, section 3.2, for the
    constraints of rolling and of not sliding, which the odometry solves by least squares.
    """

    def __init__(
        self,
        wheels: list[SteeredWheel],
        others: list[SteeredWheel],
        pivots: Floats,
        signs: Floats,
        limit: float,
    ) -> None:
        self._wheels, self._others = wheels, others
        self._pivots, self._signs = pivots, signs
        rigid = [w.position[0] for w in wheels + others if w.by < 0]
        self._axle = float(np.mean(rigid or pivots[:, 0]))
        ahead = np.abs(pivots[:, 0] - self._axle)
        nearest = float((ahead / math.tan(limit) + np.abs(pivots[:, 1])).max())
        self._bend = 1.0 / nearest  # greatest curvature [1/m]
        self._limit = limit
        self._held = np.zeros(len(signs))

    @classmethod
    def of(cls, urdf: Urdf, drive: DriveSettings) -> SteeredBase:
        """Return the base of a robot."""
        pivots = np.array([_pivot(urdf, name, drive) for name in drive.steering])
        wheels = [_wheel(urdf, name, drive, pivots) for name in drive.rolling]
        signs = np.array([1.0 if axis(urdf, n)[2] > 0.0 else -1.0 for n in drive.steering])
        count = len(drive.wheels)
        return cls(wheels[:count], wheels[count:], pivots, signs, drive.steering_limit)

    @property
    def turning_radius(self) -> float:
        """Radius of the tightest bend [m]."""
        return 1.0 / self._bend

    @property
    def axle(self) -> float:
        """Position along x of the line about whose points it turns [m]."""
        return self._axle

    def reachable(self, velocity: Velocity) -> Velocity:
        """Return a velocity whose bend the steering can do."""
        most = self._bend * abs(velocity.x)
        return Velocity(velocity.x, yaw_rate=max(-most, min(most, velocity.yaw_rate)))

    def _twist(self, velocity: Velocity) -> Floats:
        return np.array([velocity.x, -velocity.yaw_rate * self._axle, velocity.yaw_rate])

    def angles(self, velocity: Velocity) -> Floats:
        """Return where the steering joints stand; they stay when the base does."""
        if abs(velocity.x) < _STANDS:
            return self._held
        v, side, w = self._twist(velocity).tolist()
        x, y = self._pivots.T
        forward, left = v - w * y, side + w * x
        steer = np.arctan(left / np.where(forward == 0.0, _STANDS, forward))
        self._held = self._signs * np.clip(steer, -self._limit, self._limit)
        return self._held

    def speeds(self, velocity: Velocity) -> Floats:
        """Return how fast the wheels' joints turn."""
        return self._rows(self._wheels, self.angles(velocity))[0] @ self._twist(velocity)

    def speeds_at(self, velocity: Velocity, angles: Floats) -> Floats:
        """Return how fast they turn at other angles [rad]: the speed ahead holds, not the turn."""
        rolling, sliding = self._rows(self._wheels + self._others, angles)
        turning = sliding[:, 2] - self._axle * sliding[:, 1]
        rate = -velocity.x * float(turning @ sliding[:, 0]) / max(float(turning @ turning), 1e-12)
        return rolling[: len(self._wheels)] @ self._twist(Velocity(velocity.x, yaw_rate=rate))

    def motion(self, turns: Floats, angles: Floats) -> tuple[float, float, float]:
        """Return path [m], path to the left [m] and turn [rad] for turns of the wheels [rad]."""
        rolling, sliding = self._rows(self._wheels, angles)
        _, of_others = self._rows(self._others, angles)
        rows = np.vstack((rolling, sliding, of_others))
        known = np.concatenate((turns, np.zeros(len(rows) - len(turns))))
        path, side, turn = np.linalg.lstsq(rows, known, rcond=None)[0].tolist()
        return path, side, turn

    def _rows(self, wheels: list[SteeredWheel], angles: Floats) -> tuple[Floats, Floats]:
        """Return how wheels turn and how they would slide by the base's motion, `(N, 3)` each."""
        rolling, sliding = np.zeros((len(wheels), 3)), np.zeros((len(wheels), 3))
        for i, wheel in enumerate(wheels):
            angle = 0.0 if wheel.by < 0 else float(self._signs[wheel.by] * angles[wheel.by])
            (x, y), (dx, dy) = wheel.turned(angle)
            rolling[i] = (dx / wheel.radius, dy / wheel.radius, (x * dy - y * dx) / wheel.radius)
            sliding[i] = (-dy / wheel.radius, dx / wheel.radius, (x * dx + y * dy) / wheel.radius)
        return rolling, sliding


class SwerveBase(SteeredBase):
    """Wheels that are all steered by a quarter turn or more: they move the base in any direction.

    Each points along its own motion by the shorter way, and rolls backwards where that is shorter.
    """

    def reachable(self, velocity: Velocity) -> Velocity:
        """Return the velocity itself."""
        return velocity

    def _twist(self, velocity: Velocity) -> Floats:
        return np.array([velocity.x, velocity.y, velocity.yaw_rate])

    def angles(self, velocity: Velocity) -> Floats:
        """Return where the steering joints stand; that of a wheel that stands stays."""
        (vx, vy, w), (x, y) = self._twist(velocity).tolist(), self._pivots.T
        forward, left, held = vx - w * y, vy + w * x, self._signs * self._held
        turn = np.arctan2(left, forward) - held
        steer = held + turn - np.pi * np.round(turn / np.pi)
        other = steer - np.copysign(np.pi, steer)  # which rolls it the other way
        is_other = (np.abs(steer) > self._limit) & (np.abs(other) < np.abs(steer))
        steer = np.where(is_other, other, steer)
        steer = np.clip(steer, -self._limit, self._limit)
        moves = np.hypot(forward, left) >= _STANDS
        self._held = np.where(moves, self._signs * steer, self._held)
        return self._held

    def speeds_at(self, velocity: Velocity, angles: Floats) -> Floats:
        """Return how fast they turn at other angles [rad]: by the part of the motion along them."""
        return self._rows(self._wheels, angles)[0] @ self._twist(velocity)


def _wheel(urdf: Urdf, name: str, drive: DriveSettings, pivots: Floats) -> SteeredWheel:
    by, position = steered_by(urdf, name, drive.steering), center(urdf, name)[:2]
    pivot: Floats = position if by < 0 else pivots[by]
    radius = radius_of(urdf, name) or drive.radius
    return SteeredWheel(position, rolling_direction(urdf, name), radius, by, pivot)


def _pivot(urdf: Urdf, joint: str, drive: DriveSettings) -> Floats:
    """Return where a steering joint's axis, which may lean, is as high as the wheels it steers."""
    position, toward = np.array(urdf.T_root(urdf.joints[joint].child).position), axis(urdf, joint)
    index = drive.steering.index(joint)
    own = [name for name in drive.rolling if steered_by(urdf, name, drive.steering) == index]
    height = float(np.mean([center(urdf, name)[2] for name in own])) if own else position[2]
    found: Floats = (position + toward * ((height - position[2]) / toward[2]))[:2]
    return found
