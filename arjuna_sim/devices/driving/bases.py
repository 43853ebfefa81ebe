"""Bases by kind: speeds of their wheels for a velocity, and motion for their turns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from arjuna_core.arrays import Floats
from arjuna_core.twist import Velocity
from arjuna_sim.devices.drive import Base, DriveConfig, Kinematics, kinematics_of
from arjuna_sim.devices.driving.steered import SteeredBase, SwerveBase
from arjuna_sim.model.robot import RobotModel
from arjuna_sim.model.settings import DriveKind, DriveSettings
from arjuna_sim.model.urdf import Urdf
from arjuna_sim.model.wheels import (
    center,
    radius_of,
    rolling_direction,
    turning_point,
    wheel_sign,
)


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
class SidesBase(Kinematics):
    """Wheels of two sides, of which each turns as one wheel of the ideal two-wheeled robot.

    Attributes:
        sides: For each wheel and the left and the right side, how far it turns where the side's one
            turns forward by 1: more where it is smaller, 0 of the other side, `(W, 2) float64`.
        shares: What turns of the wheels add to those of their sides, in the mean, `(W, 2) float64`.
        axle: Where along x of the base it turns about [m].
    """

    sides: Floats
    shares: Floats
    axle: float = 0.0

    @staticmethod
    def of(robot: RobotModel, config: DriveConfig) -> SidesBase:
        """Return the base of a robot."""
        drive = robot.drive
        signs = np.array([wheel_sign(robot.urdf, name) for name in drive.wheels])
        radii = np.array([radius_of(robot.urdf, name) or drive.radius for name in drive.wheels])
        counts = len(drive.left), len(drive.right)
        sides, shares = np.zeros((2, len(signs), 2))
        own = np.arange(len(signs)), np.repeat((0, 1), counts)
        sides[own] = signs * radii.max(initial=0.0) / radii
        shares[own] = 1.0 / (sides[own] * np.repeat(counts, counts))
        ideal = kinematics_of(drive, config)
        axle = round(turning_point(robot.urdf, drive.left, drive.right), 4) + 0.0
        return SidesBase(ideal.track, ideal.radius, sides, shares, axle)

    def reachable(self, velocity: Velocity) -> Velocity:
        """Return a velocity without its part to the left."""
        return Velocity(velocity.x, yaw_rate=velocity.yaw_rate) if velocity.y else velocity

    def speeds(self, velocity: Velocity) -> Floats:
        """Return how fast the wheels' joints turn."""
        speeds: Floats = self.sides.dot(super().speeds(velocity))
        return speeds

    def motion(self, turns: Floats, angles: Floats) -> tuple[float, float, float]:
        """Return path [m], path to the left [m] and turn [rad] for turns of the sides [rad]."""
        path, side, turn = super().motion(turns, angles)
        return path, side - self.axle * turn, turn

    def encoders(self, joints: Floats) -> Floats:
        """Return how far the left and the right wheels have turned forward, in the mean [rad]."""
        turned: Floats = joints.dot(self.shares)
        return turned


def base_of(robot: RobotModel, config: DriveConfig) -> Base:
    """Return the base of a robot."""
    drive = robot.drive
    if drive.kind in (DriveKind.MECANUM, DriveKind.OMNI):
        return RollerBase.of(robot.urdf, drive)
    if drive.steering:
        kind = SwerveBase if drive.kind is DriveKind.SWERVE else SteeredBase
        return kind.of(robot.urdf, drive)
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
