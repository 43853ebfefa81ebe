"""A robot's base: what its wheels are told for a velocity, and what their turning says of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from arjuna_sim.devices.drive import DriveConfig, Kinematics, Velocity, kinematics_of
from arjuna_sim.devices.driving.rollers import RollerBase
from arjuna_sim.devices.driving.steered import SteeredBase
from arjuna_sim.devices.odometry import Motion
from arjuna_sim.model.robot import Robot
from arjuna_sim.model.settings import DriveKind
from arjuna_sim.model.wheels import wheel_sign

_NONE = np.zeros(0)


class Base(Motion, Protocol):
    """What a kind of drive does with wheels, which are in the order of `DriveSettings.wheels`."""

    def reachable(self, velocity: Velocity) -> Velocity:
        """Return what of a velocity the base can do."""
        ...

    def speeds(self, velocity: Velocity) -> NDArray[np.float64]:
        """Return how fast the wheels' joints turn for a reachable velocity, `(W,)` [rad/s]."""
        ...

    def angles(self, velocity: Velocity) -> NDArray[np.float64]:
        """Return where the steering joints stand for it, `(S,) float64` [rad]."""
        ...

    def encoders(self, joints: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return what encoders count at the wheels' joints' positions, `(W,)` [rad]."""
        ...


@dataclass(frozen=True)
class SidesBase:
    """Wheels of two sides, of which each turns as one.

    Attributes:
        kinematics: The ideal two-wheeled robot that stands for it.
        left: +1 for each left wheel that turning drives forward, else -1, `(L,) float64`.
        right: As `left`.
    """

    kinematics: Kinematics
    left: NDArray[np.float64]
    right: NDArray[np.float64]

    def reachable(self, velocity: Velocity) -> Velocity:
        """Return a velocity without its way to the side."""
        return Velocity(velocity.v, velocity.w) if velocity.side else velocity

    def speeds(self, velocity: Velocity) -> NDArray[np.float64]:
        """Return how fast the wheels' joints turn."""
        left, right = self.kinematics.wheel_speeds(velocity)
        return np.concatenate((left * self.left, right * self.right))

    def angles(self, velocity: Velocity) -> NDArray[np.float64]:
        """Return nothing: nothing steers."""
        return _NONE

    def encoders(self, joints: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return how far the left and the right wheels have turned forward, in the mean [rad]."""
        count = len(self.left)
        left = joints[:count] @ self.left / max(1, count)
        right = joints[count:] @ self.right / max(1, len(self.right))
        return np.array([left, right])

    def motion(
        self, turns: NDArray[np.float64], angles: NDArray[np.float64]
    ) -> tuple[float, float, float]:
        """Return path [m], way to the left [m] and turn [rad] for turns of the sides [rad]."""
        return self.kinematics.motion(turns, angles)


def base_of(robot: Robot, config: DriveConfig) -> Base:
    """Return the base of a robot.

    Args:
        robot: The robot.
        config: What was calibrated, for a base of two sides.
    """
    drive = robot.drive
    if drive.kind in (DriveKind.MECANUM, DriveKind.OMNI):
        return RollerBase.of(robot.urdf, drive)
    if drive.kind is DriveKind.STEERED:
        return SteeredBase.of(robot.urdf, drive)
    left, right = (
        np.array([wheel_sign(robot.urdf, name) for name in names])
        for names in (drive.left, drive.right)
    )
    return SidesBase(kinematics_of(drive, config), left, right)
