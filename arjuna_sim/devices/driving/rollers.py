"""Bases on mecanum or omni wheels, whose rollers let them slip one way and grip the other."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arjuna_core.twist import Velocity
from arjuna_sim.model.settings import DriveSettings
from arjuna_sim.model.urdf import Urdf
from arjuna_sim.model.wheels import center, radius_of, rolling_direction

_NONE = np.zeros(0)


@dataclass(frozen=True)
class RollerBase:
    """Three or more wheels with rollers, which move the base any way.

    Attributes:
        turning: How fast each wheel's joint turns for a velocity forward and to the left [m/s] and
            a turn rate [rad/s], `(W, 3) float64`.
        moving: Its inverse, of least squares, `(3, W) float64`.
    """

    turning: NDArray[np.float64]
    moving: NDArray[np.float64]

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

    def reachable(self, velocity: Velocity) -> Velocity:
        """Return the velocity itself."""
        return velocity

    def speeds(self, velocity: Velocity) -> NDArray[np.float64]:
        """Return how fast the wheels' joints turn."""
        speeds: NDArray[np.float64] = self.turning @ (velocity.x, velocity.y, velocity.yaw_rate)
        return speeds

    def angles(self, velocity: Velocity) -> NDArray[np.float64]:
        """Return nothing: nothing steers."""
        return _NONE

    def encoders(self, joints: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return what each wheel's encoder says."""
        return joints

    def motion(
        self, turns: NDArray[np.float64], angles: NDArray[np.float64]
    ) -> tuple[float, float, float]:
        """Return path [m], way to the left [m] and turn [rad] for turns of the wheels [rad]."""
        path, side, turn = (self.moving @ turns).tolist()
        return path, side, turn
