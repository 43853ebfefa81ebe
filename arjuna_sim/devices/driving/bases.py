"""Bases by kind: speeds of their wheels for a velocity, and motion for their turns."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from arjuna_core.arrays import Floats
from arjuna_core.twist import Velocity
from arjuna_sim.devices.drive import Base, DriveConfig, Kinematics, kinematics_of
from arjuna_sim.model.robot import RobotModel
from arjuna_sim.model.settings import DriveKind, DriveSettings
from arjuna_sim.model.urdf import Urdf
from arjuna_sim.model.wheels import (
    axis,
    center,
    radius_of,
    rolling_direction,
    steered_by,
    wheel_sign,
)

_STANDS = 1e-3  # a base so slow keeps its steering where it is [m/s]


@dataclass(frozen=True)
class RollerBase(Base):
    """Three or more wheels with rollers, which move the base in any direction.

    Attributes:
        turning: How fast each wheel's joint turns for a velocity forward and to the left [m/s] and
            a turn rate [rad/s], `(W, 3) float64`.
        moving: Its inverse, of least squares, `(3, W) float64`.
    """

    turning: Floats
    moving: Floats

    @staticmethod
    def of(urdf: Urdf, drive: DriveSettings) -> RollerBase:
        """Return the base of a robot.

        A wheel at p that grips along n and rolls along d turns by n (v + w x p) / (r n d).

        Source: Muir and Neuman, Kinematic modeling of wheeled mobile robots, Journal of Robotic
        Systems 4 (1987).
        """
        rows = []
        for name, grip in zip(drive.wheels, drive.grips, strict=True):
            x, y = center(urdf, name)[:2].tolist()
            gripping = np.array([*grip, x * grip[1] - y * grip[0]])
            radius = radius_of(urdf, name) or drive.radius
            rows.append(gripping / (radius * float(np.dot(rolling_direction(urdf, name), grip))))
        turning = np.array(rows, np.float64)
        return RollerBase(turning, np.asarray(np.linalg.pinv(turning), np.float64))

    def speeds(self, velocity: Velocity) -> Floats:
        """Return how fast the wheels' joints turn."""
        speeds: Floats = self.turning @ (velocity.x, velocity.y, velocity.yaw_rate)
        return speeds

    def motion(self, turns: Floats, angles: Floats) -> tuple[float, float, float]:
        """Return path [m], path to the left [m] and turn [rad] for turns of the wheels [rad]."""
        path, side, turn = (self.moving @ turns).tolist()
        return path, side, turn


@dataclass(frozen=True)
class SidesBase(Base):
    """Wheels of two sides, of which each turns as one.

    Attributes:
        kinematics: The ideal two-wheeled robot that stands for it.
        sides: For each wheel and the left and the right side, +1 where the wheel is of that side
            and turning drives it forward, -1 where it drives it back, else 0, `(W, 2) float64`.
        counts: How many wheels each side has, at least 1, `(2,) float64`.
    """

    kinematics: Kinematics
    sides: Floats
    counts: Floats

    @staticmethod
    def of(robot: RobotModel, config: DriveConfig) -> SidesBase:
        """Return the base of a robot."""
        drive = robot.drive
        signs = [wheel_sign(robot.urdf, name) for name in (*drive.left, *drive.right)]
        counts = len(drive.left), len(drive.right)
        sides = np.zeros((len(signs), 2))
        sides[np.arange(len(signs)), np.repeat((0, 1), counts)] = signs
        return SidesBase(kinematics_of(drive, config), sides, np.maximum(counts, 1.0))

    def reachable(self, velocity: Velocity) -> Velocity:
        """Return a velocity without its part to the left."""
        return Velocity(velocity.x, yaw_rate=velocity.yaw_rate) if velocity.y else velocity

    def speeds(self, velocity: Velocity) -> Floats:
        """Return how fast the wheels' joints turn."""
        speeds: Floats = self.sides.dot(self.kinematics.wheel_speeds(velocity))
        return speeds

    def encoders(self, joints: Floats) -> Floats:
        """Return how far the left and the right wheels have turned forward, in the mean [rad]."""
        turned: Floats = joints.dot(self.sides)
        turned /= self.counts
        return turned

    def motion(self, turns: Floats, angles: Floats) -> tuple[float, float, float]:
        """Return path [m], path to the left [m] and turn [rad] for turns of the sides [rad]."""
        return self.kinematics.motion(turns, angles)


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

    @staticmethod
    def of(urdf: Urdf, drive: DriveSettings) -> SteeredBase:
        """Return the base of a robot."""
        wheels = [_wheel(urdf, name, drive) for name in drive.rolling]
        pivots = np.array([_pivot(urdf, name) for name in drive.steering])
        signs = np.array([1.0 if axis(urdf, n)[2] > 0.0 else -1.0 for n in drive.steering])
        count = len(drive.wheels)
        return SteeredBase(wheels[:count], wheels[count:], pivots, signs, drive.steering_limit)

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


def _wheel(urdf: Urdf, name: str, drive: DriveSettings) -> SteeredWheel:
    by, position = steered_by(urdf, name, drive.steering), center(urdf, name)[:2]
    pivot = position if by < 0 else np.array(_pivot(urdf, drive.steering[by]))
    radius = radius_of(urdf, name) or drive.radius
    return SteeredWheel(position, rolling_direction(urdf, name), radius, by, pivot)


def _pivot(urdf: Urdf, joint: str) -> tuple[float, float]:
    x, y, _ = urdf.T_root(urdf.joints[joint].child).position
    return x, y


def base_of(robot: RobotModel, config: DriveConfig) -> Base:
    """Return the base of a robot."""
    drive = robot.drive
    if drive.kind in (DriveKind.MECANUM, DriveKind.OMNI):
        return RollerBase.of(robot.urdf, drive)
    if drive.kind is DriveKind.STEERED:
        return SteeredBase.of(robot.urdf, drive)
    return SidesBase.of(robot, config)


class WheelSpeeds:
    """Slows a base down to what its wheels' joints may turn, along the same curve."""

    def __init__(self, robot: RobotModel, base: Base) -> None:
        self._names, self._base = robot.drive.wheels, base
        most = [robot.urdf.joints[name].max_speed or np.inf for name in self._names]
        self._most = np.array(most)
        self._bounded = bool(np.isfinite(self._most).any())
        self._cuts: list[str] = []
        self._is_said = False

    def slowed(self, velocity: Velocity) -> Velocity:
        """Return a velocity that the base can do, slower where a wheel would turn too fast."""
        if not self._bounded:
            return velocity
        shares = np.abs(self._base.speeds(velocity)) / self._most
        worst = int(shares.argmax())
        over = float(shares[worst])
        # A share above 1 by rounding alone is no excess.
        if over <= 1.0 + 1e-9:
            return velocity
        if not self._is_said:
            self._is_said, limit = True, f"{self._most[worst]:.4g} rad/s"
            cause = f"the velocity {limit} in the <limit> of joint '{self._names[worst]}'"
            self._cuts.append(f"a command is slowed to {1 / over:.3g} of its speed, by {cause}")
        return Velocity(velocity.x / over, y=velocity.y / over, yaw_rate=velocity.yaw_rate / over)

    def take_cuts(self) -> tuple[str, ...]:
        """Return whether that has slowed a command, once."""
        cuts, self._cuts = tuple(self._cuts), []
        return cuts
